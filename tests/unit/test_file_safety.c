/* Tests file safety in folders that others can write to: names from the downlink that would leave the folder, links
 * placed in the library's way, and permissions. Nothing outside the folder may be created, changed or read. */
#include <sys/syscall.h>
#include <sys/wait.h>

#include "track_folder.h"

enum { NAMES = 500 };

static char outside[256], victim[300];
static int watched = 0, open_to_others = 0;

/* Replaces the C library's pwrite and write: while a temporary file is written, only its owner may have access. */
static void watch_temporary(int file) {
    char link[64], path[512];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const ssize_t size = readlink(link, path, sizeof path);
    struct stat attributes;
    if (size < 4 || memcmp(path + size - 4, ".tmp", 4) != 0 || fstat(file, &attributes) != 0)
        return;
    watched++;
    open_to_others += (attributes.st_mode & 0777) != 0600;
}

ssize_t write(int file, const void *bytes, size_t size) {
    watch_temporary(file);
    return syscall(SYS_write, file, bytes, size);
}

ssize_t pwrite(int file, const void *bytes, size_t size, off_t at) {
    watch_temporary(file);
    return syscall(SYS_pwrite64, file, bytes, size, at);
}

static int make_outside(void **state) {
    set_up(state);
    make_folder(outside, sizeof outside);
    snprintf(victim, sizeof victim, "%s/victim", outside);
    FILE *file = fopen(victim, "w");
    assert_non_null(file);
    fputs("untouched", file);
    fclose(file);
    assert_int_equal(chmod(victim, 0640), 0);
    return 0;
}

static int remove_outside(void **state) {
    remove_folder(outside);
    return tear_down(state);
}

/* The folder must contain only the victim, unchanged. */
static void assert_outside_untouched(void) {
    DIR *listed = opendir(outside);
    int others = 0;
    for (const struct dirent *entry; (entry = readdir(listed)) != NULL;)
        others +=
            strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0 && strcmp(entry->d_name, "victim");
    closedir(listed);
    assert_int_equal(others, 0);
    char text[20] = "";
    FILE *file = fopen(victim, "r");
    assert_non_null(fgets(text, sizeof text, file));
    fclose(file);
    assert_string_equal(text, "untouched");
    struct stat attributes;
    assert_int_equal(stat(victim, &attributes), 0);
    assert_int_equal(attributes.st_mode & 0777, 0640);
}

static int is_known(const char *name) {
    static const char *const known[] = {".",          "..",         "lock", "ledger.tlml", "checkpoint.tlmc",
                                        "setup.tlms", "streams.txt"};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(name, known[i]) == 0)
            return 1;
    return 0;
}

static void assert_only_known_files(void) {
    DIR *listed = opendir(folder);
    for (const struct dirent *entry; (entry = readdir(listed)) != NULL;)
        assert_true(is_known(entry->d_name));
    closedir(listed);
}

/* A name containing something that no name may contain. */
static void make_hostile(char *name, size_t capacity, uint64_t *random) {
    static const char *const parts[] = {
        "../",  "..",   "/",   "/etc/passwd",  ".", "\\", "\n",  "\x1b[2J", "%s%n", "\xc0\xaf", "a/b/", "~",
        "$(x)", "\x7f", "a b", "\xe2\x80\xae", ";", "*",  "%2e", "con:",    "|x",   "lock/",    "\t",   "\r"};
    const size_t count = sizeof parts / sizeof *parts;
    name[0] = '\0';
    const uint64_t pieces = draw(random, 5);
    for (uint64_t piece = 0; piece < pieces; piece++)
        strncat(name, draw(random, 2) ? "lock" : parts[draw(random, count)], capacity - strlen(name) - 1);
    switch (draw(random, 4)) {
    case 0: /* too long */
        memset(name, 'a', 65 + draw(random, 100));
        break;
    case 1:
        memmove(name + 1, name, strlen(name) + 1);
        name[0] = '.';
        break;
    default:
        strncat(name, draw(random, 2) ? "../x" : "\x1b]0;x", capacity - strlen(name) - 1);
    }
}

/* promise: files-stay-in-their-folder */
TEST_WITH(names_from_the_downlink_stay_inside, make_outside, remove_outside) {
    uint64_t random = 7;
    toliman_track_options options = small_options(folder);
    options.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
    toliman_track *track = make_track(&options);
    for (int64_t i = 0; i < NAMES; i++) {
        char name[300] = "";
        make_hostile(name, sizeof name - 100, &random);
        for (int which = 0; which < 2; which++) {
            small_frame frame;
            make_frame(&frame, i + 1);
            *(which ? &frame.frame.session : &frame.frame.roi) = name;
            toliman_track_outcome outcome = {.struct_size = sizeof outcome};
            size_t done = 9;
            assert_fails(toliman_track_push(track, &frame.frame, 1, &outcome, &done), TOLIMAN_E_ARGUMENT,
                         which ? "session = \"" : "roi = \"");
            for (const char *letter = toliman_last_error(); *letter != '\0'; letter++)
                assert_true((unsigned char)*letter >= ' ' && *letter != '\x7f'); /* no terminal control characters */
        }
    }
    assert_int_equal(push_number(track, 1), TOLIMAN_TRACK_VERDICT_ACCEPTED);
    assert_int_equal(info_of(track).received, 1);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    assert_only_known_files();
    assert_outside_untouched();
}

static void make_link(const char *name, const char *to) {
    char path[600];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    unlink(path);
    assert_int_equal(symlink(to, path), 0);
}

static void use_folder(const toliman_track_options *with, int use) {
    toliman_track_options options = *with;
    toliman_track *track = NULL;
    options.flags = use == 1 ? TOLIMAN_TRACK_READ_ONLY : use == 2 ? TOLIMAN_TRACK_REBUILD : 0;
    options.folder = use == 3 ? NULL : folder;
    if (toliman_track_create(&options, &track) != TOLIMAN_OK)
        return;
    int32_t status = use == 3 ? toliman_track_merge(track, folder, 0, NULL) : TOLIMAN_OK;
    small_frame frame;
    make_frame(&frame, 200);
    frame.frame.session = "another";
    toliman_track_outcome outcome = {.struct_size = sizeof outcome};
    size_t done;
    if (status == TOLIMAN_OK && toliman_track_push(track, &frame.frame, 1, &outcome, &done) == TOLIMAN_OK)
        status = toliman_track_save(track);
    toliman_track_destroy(track);
    assert_in_range(status, TOLIMAN_OK, TOLIMAN_E_STATE);
}

/* Replaces each file of a tracker's folder and each temporary file by a link to a file, to a missing file, to a folder,
 * and to itself; then writes, reads, rebuilds and merges. */
/* promise: files-stay-in-their-folder */
TEST_WITH(links_are_not_followed, make_outside, remove_outside) {
    static const char *const names[] = {"ledger.tlml", "checkpoint.tlmc", "setup.tlms",          "streams.txt",
                                        "lock",        "ledger.tlml.tmp", "checkpoint.tlmc.tmp", "setup.tlms.tmp",
                                        NULL};
    char nothing[300];
    snprintf(nothing, sizeof nothing, "%s/new", outside);
    const char *const targets[] = {victim, nothing, outside, "ledger.tlml"};
    char copy[900];
    snprintf(copy, sizeof copy, "rm -rf '%s' && cp -r '%s.model' '%s'", folder, folder, folder);
    const toliman_track_options options = filled_folder();
    char model[300];
    snprintf(model, sizeof model, "%s.model", folder);
    assert_int_equal(rename(folder, model), 0);
    int attempts = 0;
    for (int i = 0; names[i] != NULL; i++)
        for (size_t target = 0; target < sizeof targets / sizeof *targets; target++)
            for (int use = in_long() ? 0 : (i + (int)target) % 2; use < 4; use += in_long() ? 1 : 2, attempts++) {
                assert_int_equal(system(copy), 0);
                make_link(names[i], targets[target]);
                use_folder(&options, use);
                assert_outside_untouched();
            }
    remove_folder(model);
    print_message("%d links laid\n", attempts);
}

/* Replacing a file through a temporary file must not touch an existing file of the temporary's name. */
/* promise: files-stay-in-their-folder */
TEST_WITH(temporaries_are_not_followed, make_outside, remove_outside) {
    char path[300], name[64];
    snprintf(path, sizeof path, "%s/sums", folder);
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.1, 0.1, 10, NULL, &period));
    for (int i = 0; i < 100; i++) {
        snprintf(name, sizeof name, "sums.%d.tmp", i);
        make_link(name, victim);
        if (i < 99)
            assert_ok(toliman_period_save_file(period, path));
        else
            assert_fails(toliman_period_save_file(period, path), TOLIMAN_E_WRITE, ".99.tmp");
        assert_outside_untouched();
    }
    toliman_period_destroy(period);
}

/* Folders and pipes in place of files. Opening a pipe would block until the other end is opened. */
/* promise: files-stay-in-their-folder */
TEST_WITH(non_regular_files_are_refused, make_outside, remove_outside) {
    const char *const places[] = {ledger, setup, checkpoint};
    for (int place = 0; place < 3; place++)
        for (int pipe = 0; pipe < 2; pipe++) {
            const toliman_track_options options = filled_folder();
            toliman_track *track = NULL;
            assert_int_equal(unlink(places[place]), 0);
            assert_int_equal(pipe ? mkfifo(places[place], 0666) : mkdir(places[place], 0777), 0);
            const int32_t status = toliman_track_create(&options, &track);
            assert_int_equal(status, TOLIMAN_E_FORMAT);
            assert_non_null(strstr(toliman_last_error(), pipe ? "is a pipe or a device" : "is a folder"));
            assert_non_null(strstr(toliman_last_error(), places[place]));
            assert_int_equal(pipe ? unlink(places[place]) : rmdir(places[place]), 0);
            remove_folder(folder);
            assert_int_equal(mkdir(folder, 0777), 0);
        }
}

TEST_WITH(bare_names_are_files_of_the_working_directory, make_outside, remove_outside) {
    char before[4096];
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.1, 0.1, 10, NULL, &period));
    assert_non_null(getcwd(before, sizeof before));
    assert_int_equal(chdir(folder), 0);
    assert_ok(toliman_period_save_file(period, "sums"));
    toliman_period_destroy(period);
    assert_ok(toliman_period_load_file("sums", NULL, &period));
    assert_int_equal(chdir(before), 0);
    toliman_period_destroy(period);
}

static mode_t mode_of(const char *path) {
    struct stat attributes;
    assert_int_equal(stat(path, &attributes), 0);
    return attributes.st_mode & 0777;
}

/* promise: files-stay-in-their-folder */
TEST_WITH(temporaries_are_private_to_their_owner, make_outside, remove_outside) {
    const mode_t masks[] = {022, 002, 027, 077, 0};
    char path[300];
    snprintf(path, sizeof path, "%s/sums", folder);
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.1, 0.1, 10, NULL, &period));
    watched = open_to_others = 0;
    for (size_t i = 0; i < sizeof masks / sizeof *masks; i++) {
        const mode_t before = umask(masks[i]);
        assert_ok(toliman_period_save_file(period, path));
        assert_int_equal(mode_of(path), 0666 & ~masks[i]); /* permissions of a new file */
        assert_int_equal(chmod(path, 0604), 0);
        assert_ok(toliman_period_save_file(period, path));
        assert_int_equal(mode_of(path), 0604); /* permissions of the file it replaces */
        unlink(path);
        filled_folder();
        assert_int_equal(mode_of(ledger), 0666 & ~masks[i]);
        assert_int_equal(mode_of(checkpoint), 0666 & ~masks[i]);
        assert_int_equal(mode_of(setup), 0666 & ~masks[i]);
        assert_int_equal(chmod(checkpoint, 0604), 0);
        use_folder(&(toliman_track_options){0}, 0); /* refused */
        toliman_track_options options = small_options(folder);
        toliman_track *track = make_track(&options);
        push_number(track, 70);
        assert_ok(toliman_track_save(track));
        toliman_track_destroy(track);
        assert_int_equal(mode_of(checkpoint), 0604);
        umask(before);
        remove_folder(folder);
        assert_int_equal(mkdir(folder, 0777), 0);
    }
    toliman_period_destroy(period);
    assert_true(watched >= 20);
    assert_int_equal(open_to_others, 0);
}

/* Runs the test in a child process, as user nobody if started as root, since permissions do not restrict root. */
static void as_nobody(void (*act)(void)) {
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        if (getuid() != 0 || setuid(65534) == 0)
            act();
        _exit(1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

static int is_error(int32_t status, int32_t expected, const char *words) {
    if (status == expected && strstr(toliman_last_error(), words) != NULL)
        return 1;
    fprintf(stderr, "status %d: %s\n", status, toliman_last_error());
    return 0;
}

static void read_and_try_to_write(void) {
    toliman_track_options options = small_options(folder);
    toliman_track *track = NULL;
    toliman_period *period = NULL;
    char path[300];
    snprintf(path, sizeof path, "%s/sums", folder);
    int good = is_error(toliman_track_create(&options, &track), TOLIMAN_E_WRITE, "Permission denied");
    options.flags = TOLIMAN_TRACK_READ_ONLY;
    good &= toliman_track_create(&options, &track) == TOLIMAN_OK;
    toliman_track_destroy(track);
    good &= toliman_period_create(0.1, 0.1, 10, NULL, &period) == TOLIMAN_OK &&
            is_error(toliman_period_save_file(period, path), TOLIMAN_E_WRITE, "Permission denied");
    toliman_period_destroy(period);
    _exit(good ? 0 : 2);
}

static void fail_to_read(void) {
    toliman_track_options options = small_options(folder);
    options.flags = TOLIMAN_TRACK_READ_ONLY;
    toliman_track *track = NULL;
    _exit(is_error(toliman_track_create(&options, &track), TOLIMAN_E_NOT_FOUND, "Permission denied") ? 0 : 2);
}

/* A read-only folder can be read, and is reported as not writable. A folder without permissions cannot be read
 * either. */
TEST_WITH(permission_errors_are_reported, make_outside, remove_outside) {
    const toliman_track_options options = filled_folder();
    assert_int_equal(chmod(folder, 0555), 0);
    for (int i = 0; i < 2; i++)
        assert_int_equal(chmod(i ? ledger : checkpoint, 0444), 0);
    as_nobody(read_and_try_to_write);
    assert_int_equal(chmod(folder, 0), 0);
    as_nobody(fail_to_read);
    assert_int_equal(chmod(folder, 0777), 0);
    for (int i = 0; i < 2; i++)
        assert_int_equal(chmod(i ? ledger : checkpoint, 0666), 0);
    toliman_track *track = make_track(&options);
    assert_filled(track, &options);
    toliman_track_destroy(track);
}

static void save_twice(void) {
    toliman_period *period = NULL;
    int good = toliman_period_create(0.1, 0.1, 10, 0, &period) == TOLIMAN_OK;
    for (int i = 0; i < 2; i++)
        good &= is_error(toliman_period_save_file(period, "sums"), TOLIMAN_OK, "");
    toliman_period_destroy(period);
    _exit(good ? 0 : 2);
}

/* A file is replaced through its relative name, although a parent folder is not readable. */
TEST_WITH(parent_folders_may_deny_access, make_outside, remove_outside) {
    char inside[300], here[1000];
    snprintf(inside, sizeof inside, "%s/in", folder);
    assert_int_equal(mkdir(inside, 0777), 0);
    assert_int_equal(chmod(inside, 0777), 0);
    assert_non_null(getcwd(here, sizeof here));
    assert_int_equal(chdir(inside), 0);
    assert_int_equal(chmod(folder, 0), 0);
    as_nobody(save_twice);
    assert_int_equal(chmod(folder, 0777), 0);
    assert_int_equal(chdir(here), 0);
    remove_folder(inside);
}

RUN_TESTS(NULL, NULL)
