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

/* The message begins with the field, or contains it after "...: ". */
#define assert_field(call, code, field)                                                                                \
    do {                                                                                                               \
        assert_fails(call, code, field);                                                                               \
        assert_string_equal(toliman_last_error_field(), field);                                                        \
    } while (0)

TEST(arguments_and_members) {
    toliman_period *period = NULL, *made = make_period();
    double power;
    assert_field(toliman_get_machine(NULL), TOLIMAN_E_ARGUMENT, "out");
    assert_field(toliman_period_create(0.01, -1, 10, NULL, &period), TOLIMAN_E_ARGUMENT, "df");
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    options.value_bound = -1;
    assert_field(toliman_period_create(0.01, 0.01, 10, &options, &period), TOLIMAN_E_ARGUMENT, "value_bound");
    options.struct_size = 3;
    assert_field(toliman_period_create(0.01, 0.01, 10, &options, &period), TOLIMAN_E_ARGUMENT, "options->struct_size");
    assert_field(toliman_period_push(made, 1, NAN, 1), TOLIMAN_E_ARGUMENT, "y");
    assert_field(toliman_period_push(made, 1, 1, 1e9), TOLIMAN_E_RANGE, "sigma");
    const double t[] = {1, INFINITY}, y[] = {1, 2};
    assert_field(toliman_period_push_many(made, t, y, NULL, 2), TOLIMAN_E_ARGUMENT, "t");
    assert_field(toliman_period_query_power(made, TOLIMAN_PERIOD_POWER_STANDARD, 10, 1, &power), TOLIMAN_E_RANGE,
                 "first");
    assert_field(toliman_period_query_fap(made, 7, -1, &power), TOLIMAN_E_ARGUMENT, "method");
    toliman_period_destroy(made);
    assert_null(period);
}

TEST(keys_of_scenes) {
    static const char *const cases[][3] = {
        {"\"aperture_m\": 0.125", "\"aperture_m\": -1", "telescope.aperture_m"},
        {"\"aperture_m\": 0.125", "\"aperture_km\": 1", "telescope.aperture_km"},
        {"\"frames\": 10, \"peak_photons\": 1e6", "\"frames\": 10", "cadence.peak_photons"},
        {"\"frames\": 10", "\"frames\": [10]", "cadence.frames"},
        {"\"wavelength_nm\": 550", "", "band.min_nm"},
    };
    toliman_sim *sim = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char *scene = replaced(kSingleScene, cases[i][0], cases[i][1]);
        assert_field(toliman_sim_create_json(scene, strlen(scene), NULL, NULL, &sim), TOLIMAN_E_SCENE, cases[i][2]);
        free(scene);
    }
    /* For a file named by a scene, the field is its path. */
    char *scene = replaced(kSingleScene, "\"pupil_samples\": 64",
                           "\"pupil_samples\": 64, \"amplitude\": {\"file\": \"gone.npy\"}");
    assert_field(toliman_sim_create_json(scene, strlen(scene), "/no", NULL, &sim), TOLIMAN_E_NOT_FOUND, "/no/gone.npy");
    free(scene);
    assert_null(sim);
}

TEST(files) {
    toliman_period *period = make_period(), *loaded = NULL;
    assert_field(toliman_period_load_file("no/such", NULL, &loaded), TOLIMAN_E_NOT_FOUND, "no/such");
    assert_field(toliman_period_save_file(period, "no/such/state"), TOLIMAN_E_WRITE, "no/such/state");
    assert_ok(toliman_period_save_file(period, path));
    assert_int_equal(truncate(path, 40), 0);
    assert_field(toliman_period_load_file(path, NULL, &loaded), TOLIMAN_E_FORMAT, path);
    /* A path may contain anything: the field is the path as given, with control characters replaced by ?. */
    assert_refused(toliman_period_load_file("a = 1: {b} is NULL\n%s", NULL, &loaded), TOLIMAN_E_NOT_FOUND,
                   "a = 1: {b} is NULL?%s");
    assert_string_equal(toliman_last_error_field(), "a = 1: {b} is NULL?%s");
    /* A blob in memory has no path. */
    assert_fails(toliman_period_load("TLMP", 4, NULL, &loaded), TOLIMAN_E_FORMAT, "truncated");
    assert_string_equal(toliman_last_error_field(), "");
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
TEST(field_of_the_last_failure_of_the_thread) {
    toliman_period *period = make_period();
    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    assert_field(toliman_period_push(period, NAN, 1, 1), TOLIMAN_E_ARGUMENT, "t");
    assert_ok(toliman_period_push(period, 1, 1, 1));
    assert_string_equal(toliman_last_error_field(), "t");
    pthread_t thread;
    int good = 0;
    assert_int_equal(pthread_create(&thread, NULL, fields_of_a_new_thread, &good), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_true(good);
    assert_string_equal(toliman_last_error_field(), "t");
    assert_refused(toliman_period_query_peak(period, &peak), TOLIMAN_E_STATE, "");
    assert_string_equal(toliman_last_error_field(), "");
    toliman_period_destroy(period);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arguments_and_members),
        cmocka_unit_test(keys_of_scenes),
        cmocka_unit_test(files),
        cmocka_unit_test(field_of_the_last_failure_of_the_thread),
    };
    const int file = mkstemp(path);
    if (file < 0)
        return 1;
    close(file);
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(path);
    return failed;
}
