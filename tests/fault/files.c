/* The temporary folders of the program and their files. */
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scenario.h"

enum { MODE = 0640 };
static char above[200];
static _Thread_local int own;

const char *in_folder(const char *name) {
    static _Thread_local char paths[8][300];
    static _Thread_local unsigned turn;
    char *const path = paths[turn++ % 8];
    snprintf(path, sizeof *paths, "%s/%d/%s", above, own, name);
    return path;
}

void use_folder(int thread) {
    own = thread;
}

void require(int holds, const char *what, const char *name) {
    if (holds)
        return;
    fprintf(stderr, "faults: %s: %s: %s\n", name, what, strerror(errno));
    exit(2);
}

void write_file(const char *name, const void *bytes, size_t size) {
    FILE *const file = fopen(in_folder(name), "wb");
    require(file != NULL && fwrite(bytes, 1, size, file) == size && fclose(file) == 0, "cannot be written", name);
}

size_t read_file(const char *name, void *bytes, size_t capacity) {
    FILE *const file = fopen(in_folder(name), "rb");
    if (file == NULL)
        return SIZE_MAX;
    const size_t size = fread(bytes, 1, capacity, file);
    fclose(file);
    return size;
}

static int entries(const char *path, int end) {
    int count = 0;
    DIR *const open = opendir(path);
    require(open != NULL, "cannot be opened", path);
    for (const struct dirent *entry; (entry = readdir(open)) != NULL;)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0) {
            char inner[600];
            snprintf(inner, sizeof inner, "%s/%s", path, entry->d_name);
            count++;
            if (end && unlink(inner) != 0)
                require(entries(inner, 1) >= 0 && rmdir(inner) == 0, "cannot be removed", inner);
        }
    closedir(open);
    return count;
}

int files_in(const char *name) {
    return entries(name[0] == '/' ? name : in_folder(name), 0);
}

void empty_folder(const char *name) {
    require(mkdir(in_folder(name), 0700) == 0 || errno == EEXIST, "cannot be created", name);
    entries(in_folder(name), 1);
}

void create_folders(int count) {
    const char *const given = getenv("TMPDIR");
    snprintf(above, sizeof above, "%s/toliman-faults-XXXXXX", given != NULL ? given : "/tmp");
    require(mkdtemp(above) != NULL, "cannot be created", above);
    while (count-- > 0) {
        use_folder(count);
        empty_folder("");
    }
}

void remove_folders(void) {
    entries(above, 1);
    rmdir(above);
}

void keep_file(const char *name, saved_file *kept) {
    struct stat attributes = {0};
    require(stat(in_folder(name), &attributes) == 0 && attributes.st_size > 0, "is missing or empty", name);
    kept->size = (size_t)attributes.st_size;
    kept->bytes = malloc(kept->size);
    require(read_file(name, kept->bytes, kept->size) == kept->size, "cannot be read", name);
}

void put_file(const char *name, const saved_file *kept) {
    write_file(name, kept->bytes, kept->size);
}

void must_begin_with(const char *name, const saved_file *kept) {
    unsigned char *const found = malloc(kept->size);
    must(read_file(name, found, kept->size) == kept->size && memcmp(found, kept->bytes, kept->size) == 0,
         "what the file had is lost");
    free(found);
}

const unsigned char *damaged(const saved_file *kept) {
    static unsigned char *bytes;
    static const saved_file *last;
    if (last == kept)
        return bytes;
    last = kept;
    bytes = realloc(bytes, kept->size);
    memcpy(bytes, kept->bytes, kept->size);
    bytes[kept->size / 2] ^= 1;
    return bytes;
}

void put_old(void) {
    empty_folder("saved");
    write_file(SAVED, "old", 3);
    unlink(in_folder(SAVED_LINK));
    require(chmod(in_folder(SAVED), MODE) == 0 && symlink(SAVED, in_folder(SAVED_LINK)) == 0, "no link", SAVED_LINK);
}

/* The file must be the old or the complete one, with its permissions, and after TOLIMAN_OK the latter. No other file
 * may remain, unless every call fails and it cannot be removed. */
void check_saved(const saved_file *complete, toliman_status status) {
    struct stat attributes = {0};
    saved_file found;
    keep_file(SAVED, &found);
    const int is_new = found.size == complete->size && memcmp(found.bytes, complete->bytes, found.size) == 0;
    const int is_old = found.size == 3 && memcmp(found.bytes, "old", 3) == 0;
    free(found.bytes);
    must(status == TOLIMAN_OK ? is_new : is_new || is_old, "neither the old file nor the new one");
    must(stat(in_folder(SAVED), &attributes) == 0 && (attributes.st_mode & 0777) == MODE, "other permissions");
    must(lstat(in_folder(SAVED_LINK), &attributes) == 0 && S_ISLNK(attributes.st_mode), "the link is replaced");
    must(files_in("saved") == 1 || status == TOLIMAN_E_WRITE, "another file is left");
}

const saved_file *saved_by(saved_file *kept, void *object, toliman_status (*save)(attempt *a)) {
    attempt a = {.object = object};
    if (kept->size != 0)
        return kept;
    put_old();
    must(save(&a) == TOLIMAN_OK, "cannot be saved");
    keep_file(SAVED, kept);
    return kept;
}

/* Without the thread's folder at the start of a path. */
static uint64_t hash_of(const char *text) {
    const size_t length = strlen(above);
    if (text == NULL)
        return 0;
    text += strncmp(text, above, length) == 0 && text[length] == '/' ? length + strlen("/0") : 0;
    return fnv1a(FNV_START, text, strlen(text));
}

void hide_text(const char **text) {
    const uint64_t hash = hash_of(*text);
    memcpy(text, &hash, sizeof hash);
}

void put_text(unsigned char *out, const char *text) {
    const uint64_t hash = hash_of(text);
    memcpy(out, &hash, sizeof hash);
}

void put_number(unsigned char *out, int64_t number) {
    memcpy(out, &number, sizeof number);
}
