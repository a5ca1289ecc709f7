/* Tests the field of an error, which programs use instead of parsing messages. */
#include <pthread.h>
#include <unistd.h>

#include "scene_text.h"

#include <toliman/toliman.h>

static char path[] = "last_error.XXXXXX";

static toliman_period *make_period(void) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(0.01, 0.01, 10, NULL, &period));
    return period;
}

/* promise: errors-name-the-field */
TEST(files) {
    toliman_sim *sim = NULL; /* for a file that a scene names, the field is its path */
    char *scene = replaced(kSingleScene, "\"pupil_samples\": 64",
                           "\"pupil_samples\": 64, \"amplitude\": {\"file\": \"gone.npy\"}");
    assert_refused(toliman_sim_create_json(scene, strlen(scene), "/no", NULL, &sim), TOLIMAN_E_NOT_FOUND,
                   "/no/gone.npy");
    free(scene);
    toliman_period *period = make_period(), *loaded = NULL;
    assert_refused(toliman_period_load_file("no/such", NULL, &loaded), TOLIMAN_E_NOT_FOUND, "no/such");
    assert_refused(toliman_period_save_file(period, "no/such/state"), TOLIMAN_E_WRITE, "no/such/state");
    assert_ok(toliman_period_save_file(period, path));
    assert_int_equal(truncate(path, 40), 0);
    assert_refused(toliman_period_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, path);
    /* A path may contain anything: the field is the path as given, with control characters replaced by ?. */
    assert_refused(toliman_period_load_file("a = 1: {b} is NULL\n%s", NULL, &loaded), TOLIMAN_E_NOT_FOUND,
                   "a = 1: {b} is NULL?%s");
    /* A blob in memory has no path. */
    assert_refused(toliman_period_load("TLMP", 4, NULL, &loaded), TOLIMAN_E_FORMAT, "");
    assert_null(loaded);
    toliman_period_destroy(period);
}

static void *fields_of_a_new_thread(void *out) {
    *(int *)out = toliman_last_error_field()[0] == '\0';
    if (toliman_get_machine(NULL) == TOLIMAN_OK || strcmp(toliman_last_error_field(), "out") != 0)
        *(int *)out = 0;
    return NULL;
}

/* An error without a name clears the field, a success leaves it, another thread has its own. */
/* promise: messages-belong-to-threads */
TEST(field_of_the_last_failure_of_the_thread) {
    toliman_period *period = make_period();
    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    assert_invalid(toliman_period_push(period, NAN, 1, 1), "t");
    assert_ok(toliman_period_push(period, 1, 1, 1));
    assert_string_equal(toliman_last_error_field(), "t");
    pthread_t thread;
    int good = 0;
    assert_int_equal(pthread_create(&thread, NULL, fields_of_a_new_thread, &good), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_true(good);
    assert_string_equal(toliman_last_error_field(), "t");
    assert_refused(toliman_period_query_peak(period, &peak), TOLIMAN_E_STATE, "");
    toliman_period_destroy(period);
}

int main(void) {
    const int file = mkstemp(path);
    if (file < 0)
        return 1;
    close(file);
    const int failed = RUN_ALL(NULL, NULL);
    unlink(path);
    return failed;
}
