/* Tests failures of the system: existing names, folders that cannot be opened, threads that cannot be created. */
#include <fcntl.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <toliman/period.h>

#include "scene_text.h"

static char folder[] = P_tmpdir "/toliman-system-XXXXXX";
static char path[100];
static toliman_period *first, *second; /* two objects with different states */

FIXTURE(set_up) {
    if (mkdtemp(folder) == NULL)
        return 1;
    snprintf(path, sizeof path, "%s/state.tlmp", folder);
    assert_ok(toliman_period_create(0, 0.1, 3, NULL, &first));
    assert_ok(toliman_period_create(0, 0.2, 3, NULL, &second));
    return 0;
}

FIXTURE(tear_down) {
    toliman_period_destroy(first), toliman_period_destroy(second);
    unlink(path);
    return rmdir(folder);
}

static const char *temporary(int number) {
    static char name[120];
    snprintf(name, sizeof name, "%s.%d.tmp", path, number);
    return name;
}

static void write_file(const char *name, const char *text) {
    FILE *const file = fopen(name, "wb");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* The file must hold this object's state. */
static void assert_holds(const toliman_period *period) {
    static unsigned char expected[10000], found[10000];
    size_t size;
    assert_ok(toliman_period_save(period, expected, sizeof expected, &size));
    FILE *const file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(found, 1, sizeof found, file), size);
    fclose(file);
    assert_memory_equal(found, expected, size);
}

/* Creates a temporary file as a writer that has not ended holds it; a writer that died holds no lock. */
static int begin_writing(int number) {
    write_file(temporary(number), "");
    const int file = open(temporary(number), O_RDWR);
    assert_int_equal(flock(file, LOCK_EX | LOCK_NB), 0);
    return file;
}

/* promise: files-are-replaced-atomically */
TEST(existing_names) {
    enum { NAMES = 100, DIED = 7 };
    int writers[NAMES];
    for (int number = 0; number < 3; number++)
        writers[number] = begin_writing(number);
    write_file(temporary(3), "left by a writer that died");
    write_file(temporary(DIED), "left by a writer that died");
    assert_ok(toliman_period_save_file(first, path));
    assert_holds(first);
    for (int number = 0; number < NAMES; number++)
        assert_int_equal(access(temporary(number), F_OK) == 0, number < 3);
    for (int number = 3; number < NAMES; number++)
        writers[number] = begin_writing(number);
    assert_refused(toliman_period_save_file(second, path), TOLIMAN_E_WRITE, path);
    assert_holds(first);
    close(writers[DIED]);
    assert_ok(toliman_period_save_file(second, path));
    assert_holds(second);
    for (int number = 0; number < NAMES; number++) {
        assert_int_equal(unlink(temporary(number)), number == DIED ? -1 : 0);
        if (number != DIED)
            close(writers[number]);
    }
}

static mode_t mode_of(const char *name) {
    struct stat attributes;
    assert_int_equal(stat(name, &attributes), 0);
    return attributes.st_mode & 07777;
}

TEST(permissions) {
    unlink(path);
    const mode_t mask = umask(027);
    assert_ok(toliman_period_save_file(first, path));
    assert_int_equal(mode_of(path), 0640); /* a new file: permissions by the process's umask */
    const mode_t modes[] = {0600, 0666, 0751};
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        assert_int_equal(chmod(path, modes[i]), 0);
        assert_ok(toliman_period_save_file(second, path));
        assert_int_equal(mode_of(path), modes[i]);
    }
    umask(mask);
}

/* Runs body in a child process without root's rights; the result is the child's exit code. */
static int as_nobody(int (*body)(void)) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        _exit(geteuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0) ? 99 : body());
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static int save_where_the_folder_cannot_be_opened(void) {
    if (toliman_period_save_file(second, path) != TOLIMAN_E_WRITE)
        return 1;
    return strstr(toliman_last_error(), "its folder cannot be opened: Permission denied") == NULL ? 2 : 0;
}

/* A folder that accepts files but cannot be opened for reading cannot be synced: reported before the old file is
 * replaced. */
/* promises: files-are-replaced-atomically, objects-survive-fork */
TEST(a_folder_that_cannot_be_opened) {
    assert_ok(toliman_period_save_file(first, path));
    assert_int_equal(chmod(path, 0644), 0);
    assert_int_equal(chmod(folder, 0333), 0);
    assert_int_equal(as_nobody(save_where_the_folder_cannot_be_opened), 0);
    assert_int_equal(chmod(folder, 0700), 0);
    assert_holds(first);
    assert_int_not_equal(access(temporary(0), F_OK), 0);
}

enum { kFrames = 50, kFramePixels = 32 * 32 };
static toliman_sim *sim;
static const double displacements[kFrames];
static double expected[kFrames * kFramePixels], frames[kFrames * kFramePixels];

static int make_frames_without_threads(void) {
    const struct rlimit none = {0, 0};
    if (setrlimit(RLIMIT_NPROC, &none) != 0)
        return 98;
    if (toliman_sim_frame(sim, displacements, 7, 0, kFrames, frames) != TOLIMAN_OK)
        return 1;
    return memcmp(frames, expected, sizeof frames) != 0 ? 2 : 0;
}

/* With fewer threads than requested, even with none, the frames are the same. */
/* promise: objects-survive-fork */
TEST(threads_that_cannot_be_created) {
    char *const text =
        replaced(kSingleScene, "\"peak_photons\": 1e6}", "\"peak_photons\": 1e6}, \"noise\": {\"photon\": true}");
    sim = sim_on_threads(text, 8);
    assert_ok(toliman_sim_frame(sim, displacements, 7, 0, kFrames, expected));
    assert_int_equal(as_nobody(make_frames_without_threads), 0);
    toliman_sim_destroy(sim);
    sim = sim_on_threads(text, 1);
    assert_ok(toliman_sim_frame(sim, displacements, 7, 0, kFrames, frames));
    assert_memory_equal(frames, expected, sizeof frames);
    toliman_sim_destroy(sim), free(text);
}

RUN_TESTS(set_up, tear_down)
