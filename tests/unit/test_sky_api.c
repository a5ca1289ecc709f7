/* Tests the interface of predictions: arguments and their messages, sizes of structs, warnings, properties, and the
 * same bits from several threads. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>

#include <toliman/sim.h>

#include "assert_close.h"
#include "measure_arrays.h"

enum { TIMES = 64, THREADS = 8 };
static const int64_t kStart = INT64_C(1798761600000000000), kStep = INT64_C(1234567890123456); /* 2027-01-01, 14.3 d */

static toliman_sky *sky;
static int64_t times[TIMES];

FIXTURE(set_up) {
    const toliman_sky_options options = {.struct_size = sizeof options, .altitude_km = 600};
    assert_ok(toliman_sky_create("alpha-cen", &options, &sky));
    for (int i = 0; i < TIMES; i++)
        times[i] = kStart + i * kStep;
    return 0;
}

FIXTURE(tear_down) {
    toliman_sky_destroy(sky);
    return 0;
}

/* A scene of 8 x 8 px with a moving binary; `more` is added to its members. */
static toliman_sim *scene_with(const char *more) {
    char json[1000];
    const int size = snprintf(
        json, sizeof json,
        "{\"schema\": \"toliman-scene/1\", \"telescope\": {\"aperture_m\": 0.125, \"pupil_samples\": 32}, "
        "\"band\": {\"wavelength_nm\": 580}, \"stars\": {"
        "\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"relative_flux\": 3}, "
        "\"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}}}, \"binary\": {%s}, "
        "\"signal\": {\"kind\": \"sinusoid\", \"star\": \"B\", \"amplitude_px\": 1e-3, \"period_days\": 40}, "
        "\"cadence\": {\"frames\": 2, \"interval_days\": 2, \"peak_photons\": 1e5}, "
        "\"detector\": {\"shape\": [8, 8], \"pixel_scale_arcsec\": 2}, \"noise\": {\"photon\": true, \"seed\": 7}}",
        more);
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(json, (size_t)size, NULL, NULL, &sim));
    return sim;
}

/* Predictions with the orbit and the observer of a scene are those of its names. */
TEST(scenes_have_skies) {
    static const struct {
        const char *observer;
        double altitude_km, node_hours;
    } cases[] = {
        {"\"earth\"", 0, 0}, {"{\"altitude_km\": 600}", 600, 0}, {"{\"altitude_km\": 500, \"node_hours\": 9}", 500, 9}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char binary[200];
        snprintf(binary, sizeof binary, "\"date\": 2027, \"orbit\": \"alpha-cen\", \"moving\": true, \"observer\": %s",
                 cases[i].observer);
        toliman_sim *const sim = scene_with(binary);
        const toliman_sky_options of_scene = {.struct_size = sizeof of_scene, .scene = sim};
        toliman_sky *found = NULL, *named = NULL;
        assert_ok(toliman_sky_create(NULL, &of_scene, &found));
        toliman_sim_destroy(sim);
        const toliman_sky_options options = {
            .struct_size = sizeof options, .altitude_km = cases[i].altitude_km, .node_hours = cases[i].node_hours};
        assert_ok(toliman_sky_create("alpha-cen", &options, &named));
        for (int k = 0; k < TIMES; k++) {
            toliman_sky_prediction a = {.struct_size = sizeof a}, b = {.struct_size = sizeof b};
            assert_ok(toliman_sky_predict(found, &times[k], 1, &a));
            assert_ok(toliman_sky_predict(named, &times[k], 1, &b));
            assert_memory_equal(&a, &b, sizeof a);
        }
        toliman_sky_destroy(found);
        toliman_sky_destroy(named);
    }
}

TEST(scenes_without_observer_are_refused) {
    toliman_sim *const moving = scene_with("\"date\": 2027, \"orbit\": \"alpha-cen\", \"moving\": true"),
                       *const at_rest = scene_with("\"separation_arcsec\": 4, \"position_angle_deg\": 30");
    toliman_sky *made = NULL;
    const toliman_sky_options of_moving = {.struct_size = sizeof of_moving, .scene = moving},
                              of_rest = {.struct_size = sizeof of_rest, .scene = at_rest},
                              with_orbit = {.struct_size = sizeof with_orbit, .scene = moving, .altitude_km = 600};
    assert_refused(toliman_sky_create(NULL, &of_moving, &made), TOLIMAN_E_UNSUPPORTED, "options->scene");
    assert_refused(toliman_sky_create(NULL, &of_rest, &made), TOLIMAN_E_UNSUPPORTED, "options->scene");
    assert_invalid(toliman_sky_create(NULL, &with_orbit, &made), "options->observer");
    assert_invalid(toliman_sky_create("alpha-cen", &of_moving, &made), "options->scene");
    assert_null(made);
    toliman_sim_destroy(moving);
    toliman_sim_destroy(at_rest);
}

TEST(bad_options_are_refused) {
    const struct {
        toliman_sky_options options;
        const char *message;
    } cases[] = {
        {{.altitude_km = -1}, "options->altitude_km"},
        {{.altitude_km = 600, .node_hours = -1}, "options->node_hours"},
        {{.node_hours = 6}, "options->node_hours"},
        {{.observer = "none.oem", .altitude_km = 600}, "options->altitude_km"},
        {{.leap_second_count = 1}, "options->leap_seconds"},
        {{.struct_size = 4}, "options->struct_size"},
    };
    toliman_sky *made = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_sky_options options = cases[i].options;
        if (options.struct_size == 0)
            options.struct_size = sizeof options;
        assert_invalid(toliman_sky_create("alpha-cen", &options, &made), cases[i].message);
    }
    assert_invalid(toliman_sky_create(NULL, NULL, &made), "system");
    assert_invalid(toliman_sky_create("alpha-cen", NULL, NULL), "out");
    assert_invalid(toliman_sky_create("", NULL, &made), "system");
    assert_refused(toliman_sky_create("beta-cen", NULL, &made), TOLIMAN_E_NOT_FOUND, "beta-cen");
    const toliman_sky_options of_no_scene = {.struct_size = sizeof of_no_scene, .altitude_km = 600};
    assert_invalid(toliman_sky_create(NULL, &of_no_scene, &made), "system");
    const toliman_sky_options missing = {.struct_size = sizeof missing, .observer = "none.oem"};
    assert_refused(toliman_sky_create("alpha-cen", &missing, &made), TOLIMAN_E_NOT_FOUND, "none.oem");
    assert_null(made);
}

static const char kJson[] =
    " \n{\"schema\": \"toliman-system/1\", \"name\": \"a binary\", \"orbit\": {\"period_years\": 80, "
    "\"semi_major_arcsec\": 17, \"eccentricity\": 0.5, \"inclination_deg\": 79, \"node_deg\": 205, \"periastron_deg\": "
    "231, \"epoch\": 1955.5}, \"barycentre\": {\"ra_deg\": 219, \"dec_deg\": -60, \"epoch\": 2019.5, \"pm_ra_mas_yr\": "
    "-3640, \"pm_dec_mas_yr\": 700, \"parallax_mas\": 750, \"radial_velocity_km_s\": -22, \"radial_velocity_kind\": "
    "\"kinematic\"}, \"masses\": {\"A\": 1.1, \"B\": 0.9}}";

TEST(a_text_is_the_system) {
    toliman_sky *made = NULL;
    toliman_sky_info info = TOLIMAN_SKY_INFO_INIT;
    double period = 0;
    assert_ok(toliman_sky_create(kJson, NULL, &made));
    assert_ok(toliman_sky_get_info(made, &info));
    assert_ok(toliman_sky_get_element(made, TOLIMAN_SKY_ELEMENT_PERIOD, &period, NULL));
    assert_string_equal(info.name, "a binary");
    assert_true(period == 80);
    assert_true(info.parallax_arcsec == 0.75 && info.star_mass[0] == 1.1 && info.star_mass[1] == 0.9);
    toliman_sky_destroy(made);
    made = NULL;
    assert_refused(toliman_sky_create("{", NULL, &made), TOLIMAN_E_FORMAT, "system");
    assert_refused(toliman_sky_create("{\"schema\": \"toliman-system/1\"}", NULL, &made), TOLIMAN_E_SCENE, "orbit");
    assert_refused(toliman_sky_create(" alpha-cen", NULL, &made), TOLIMAN_E_NOT_FOUND, " alpha-cen");
    assert_null(made);
}

TEST(bad_arguments_are_refused) {
    toliman_sky_prediction seen[2] = {TOLIMAN_SKY_PREDICTION_INIT, TOLIMAN_SKY_PREDICTION_INIT}, untouched = seen[0];
    toliman_sky_info info = TOLIMAN_SKY_INFO_INIT;
    const int64_t late[2] = {kStart, INT64_MAX}, backwards[4] = {5, 10, 10, 5};
    assert_invalid(toliman_sky_predict(NULL, times, 1, seen), "sky");
    assert_invalid(toliman_sky_predict(sky, NULL, 1, seen), "tai_ns");
    assert_invalid(toliman_sky_predict(sky, times, 1, NULL), "predictions");
    assert_refused(toliman_sky_predict(sky, times, SIZE_MAX, seen), TOLIMAN_E_RANGE, "tai_ns");
    assert_refused(toliman_sky_predict(sky, late, 2, seen), TOLIMAN_E_RANGE, "time");
    assert_memory_equal(&seen[0], &untouched, sizeof untouched);
    assert_invalid(toliman_sky_predict_mean(sky, NULL, &(size_t){1}, 1, seen), "intervals");
    assert_invalid(toliman_sky_predict_mean(sky, times, &(size_t){1}, 1, NULL), "predictions");
    assert_invalid(toliman_sky_predict_mean(sky, times, &(size_t){0}, 1, seen), "intervals");
    assert_invalid(toliman_sky_predict_mean(sky, backwards, &(size_t){2}, 1, seen), "intervals");
    assert_refused(toliman_sky_predict_mean(sky, late, &(size_t){1}, 1, seen), TOLIMAN_E_RANGE, "time");
    assert_memory_equal(&seen[0], &untouched, sizeof untouched);
    assert_invalid(toliman_sky_get_info(sky, NULL), "out");
    assert_invalid(toliman_sky_get_info((const toliman_sky *)(const void *)&info, &info), "sky");
    assert_refused(toliman_sky_get_element(sky, TOLIMAN_SKY_ELEMENT_EPOCH + 1, NULL, NULL), TOLIMAN_E_RANGE, "element");
    assert_refused(toliman_sky_get_element(sky, 0, NULL, NULL), TOLIMAN_E_RANGE, "element");
    seen[0].struct_size = info.struct_size = 4;
    assert_invalid(toliman_sky_predict(sky, times, 1, seen), "predictions->struct_size");
    assert_invalid(toliman_sky_predict_mean(sky, times, &(size_t){1}, 1, seen), "predictions->struct_size");
    assert_invalid(toliman_sky_get_info(sky, &info), "out->struct_size");
    assert_ok(toliman_sky_predict(sky, NULL, 0, NULL));
    toliman_sky_destroy(NULL);
}

enum { MEASURED = 3 };
static const size_t kCounts[MEASURED] = {1, 2, 1};
static int64_t exposures[2 * (MEASURED + 1)]; /* [interval], two of the second measurement */

static void set_exposures(int64_t length_ns) {
    for (int i = 0; i < MEASURED + 1; i++) {
        exposures[2 * i] = times[0] + i * INT64_C(86400000000000);
        exposures[2 * i + 1] = exposures[2 * i] + length_ns;
    }
}

/* The definition, with the means of predict_mean, to the last bit. */
TEST(reduced_is_measured_over_factor_minus_geometric) {
    set_exposures(INT64_C(1800000000000));
    const double measured[MEASURED] = {9.8, 9.9, 10.1};
    double reduced[MEASURED];
    toliman_sky_prediction seen[MEASURED] = {TOLIMAN_SKY_PREDICTION_INIT}, mean = TOLIMAN_SKY_PREDICTION_INIT;
    size_t left = 0;
    assert_ok(reduce_of(sky, exposures, kCounts, measured, MEASURED, reduced, &left));
    assert_int_equal(left, MEASURED);
    assert_ok(toliman_sky_predict_mean(sky, exposures, kCounts, MEASURED, seen));
    for (size_t i = 0, next = 0; i < MEASURED; next += kCounts[i++]) {
        assert_ok(toliman_sky_predict_mean(sky, &exposures[2 * next], &kCounts[i], 1, &mean));
        assert_memory_equal(&seen[i], &mean, sizeof mean);
        assert_true(reduced[i] == measured[i] / mean.factor - mean.geometric_arcsec);
    }
    assert_ok(toliman_sky_predict_mean(sky, NULL, NULL, 0, NULL));
}

/* An exposure in orbit must be known: neither its middle nor a whole that is longer than 600 s is enough. */
/* promise: unknown-exposures-are-refused */
TEST(unknown_exposures_are_refused) {
    const double measured[MEASURED] = {9.8, 9.9, 10.1};
    const size_t ones[MEASURED] = {1, 1, 1};
    double reduced[MEASURED] = {5, 5, 5};
    size_t left = 0;
    set_exposures(INT64_C(600000000000));
    assert_ok(reduce_of(sky, exposures, NULL, measured, MEASURED, reduced, &left));
    exposures[5]++;
    reduced[0] = 5;
    assert_fails(reduce_of(sky, exposures, NULL, measured, MEASURED, reduced, &left), TOLIMAN_E_ARGUMENT,
                 "measurement 2: intervals: 600 s: ");
    assert_true(reduced[0] == 5);
    assert_ok(reduce_of(sky, exposures, ones, measured, MEASURED, reduced, &left));
    exposures[3] = exposures[2];
    assert_invalid(reduce_of(sky, exposures, ones, measured, MEASURED, reduced, &left), "intervals");
    toliman_sky *earth = NULL;
    const toliman_sky_options options = {.struct_size = sizeof options, .without = TOLIMAN_SKY_SPACECRAFT_ABERRATION};
    assert_ok(toliman_sky_create("alpha-cen", &options, &earth));
    set_exposures(0);
    assert_ok(reduce_of(earth, exposures, NULL, measured, MEASURED, reduced, &left));
    set_exposures(INT64_C(86400000000000));
    assert_ok(reduce_of(earth, exposures, NULL, measured, MEASURED, reduced, &left));
    toliman_sky_destroy(earth);
}

/* A refit refuses what a reduction refuses, and what the observer file does not cover. */
/* promise: unknown-exposures-are-refused */
TEST(a_refit_refuses_unknown_exposures) {
    const double measured[MEASURED] = {9.8, 9.9, 10.1}, sigmas[MEASURED] = {1, 1, 1};
    const size_t ones[MEASURED] = {1, 1, 1};
    toliman_sky_refit_result result = TOLIMAN_SKY_REFIT_RESULT_INIT;
    toliman_sky *fitted = NULL;
    set_exposures(INT64_C(600000000000));
    exposures[5]++;
    assert_invalid(refit_of(sky, exposures, NULL, measured, sigmas, MEASURED, 0, &result, &fitted), "intervals");
    assert_ok(refit_of(sky, exposures, ones, measured, sigmas, MEASURED, 0, &result, &fitted));
    toliman_sky_destroy(fitted);
    fitted = NULL;
    exposures[3] = exposures[2];
    assert_fails(refit_of(sky, exposures, ones, measured, sigmas, MEASURED, 0, &result, &fitted), TOLIMAN_E_ARGUMENT,
                 "measurement 1: intervals: zero length");
    set_exposures(INT64_C(60000000000));
    exposures[4] = INT64_MAX - 2;
    exposures[5] = INT64_MAX - 1;
    assert_refused(refit_of(sky, exposures, ones, measured, sigmas, MEASURED, 0, &result, &fitted), TOLIMAN_E_RANGE,
                   "time");
    const double far[MEASURED] = {29.4, 29.7, 30.3}, exact[MEASURED] = {1e-4, 1e-4, 1e-4};
    set_exposures(INT64_C(60000000000));
    assert_invalid(refit_of(sky, exposures, ones, far, exact, MEASURED, 0, &result, &fitted), "measured");
    assert_null(fitted);
}

/* The 30 measurements that a diagnosis needs at least. */
TEST(bad_diagnoses_are_refused) {
    enum { LEAST = 30 };
    int64_t pairs[2 * LEAST];
    double measured[LEAST], sigmas[LEAST];
    toliman_sky_diagnosis result = TOLIMAN_SKY_DIAGNOSIS_INIT, untouched = result;
    toliman_sky_hypothesis rows[TOLIMAN_SKY_HYPOTHESES] = {TOLIMAN_SKY_HYPOTHESIS_INIT};
    for (int i = 0; i < LEAST; i++) {
        toliman_sky_prediction seen = TOLIMAN_SKY_PREDICTION_INIT;
        pairs[2 * i] = times[i];
        pairs[2 * i + 1] = times[i] + 60 * INT64_C(1000000000);
        assert_ok(toliman_sky_predict_mean(sky, &pairs[2 * i], NULL, 1, &seen));
        measured[i] = seen.separation_arcsec;
        sigmas[i] = 1e-6;
    }
    assert_invalid(diagnose_of(sky, pairs, NULL, measured, sigmas, LEAST, 0, NULL, rows), "result");
    assert_invalid(diagnose_of(sky, NULL, NULL, measured, sigmas, LEAST, 0, &result, rows), "data->t");
    assert_invalid(diagnose_of(sky, pairs, NULL, measured, sigmas, LEAST, 1, &result, rows), "scale_sigma");
    sigmas[3] = 0;
    assert_invalid(diagnose_of(sky, pairs, NULL, measured, sigmas, LEAST, 0, &result, rows), "sigma[3]");
    sigmas[3] = 1e-6;
    rows[0].struct_size = 4;
    assert_invalid(diagnose_of(sky, pairs, NULL, measured, sigmas, LEAST, 0, &result, rows), "hypotheses->struct_size");
    pairs[7] = pairs[6];
    assert_fails(diagnose_of(sky, pairs, NULL, measured, sigmas, LEAST, 0, &result, NULL), TOLIMAN_E_ARGUMENT,
                 "measurement 3: intervals: zero length");
    assert_memory_equal(&result, &untouched, sizeof result);
    pairs[7] = pairs[6] + 60 * INT64_C(1000000000);
    assert_ok(diagnose_of(sky, pairs, NULL, measured, sigmas, LEAST, 0, &result, NULL));
    assert_int_equal(result.used, LEAST);
    assert_int_equal(result.cause, TOLIMAN_SKY_CAUSE_NONE);
    assert_int_equal(result.goodness, TOLIMAN_GOODNESS_TOO_GOOD); /* there is no noise */
    assert_string_equal(toliman_constant_name(TOLIMAN_SKY_CAUSE_CENTRE), "centre");
    assert_string_equal(toliman_constant_name(TOLIMAN_SKY_CAUSE_CENTRE + 1), "?");
}

TEST(bad_measurements_are_refused) {
    set_exposures(INT64_C(60000000000));
    double reduced = 5;
    size_t left = 7;
    const double good = 9.8, bad[] = {0, -9.8, INFINITY, NAN};
    const size_t none = 0;
    const int64_t late[2] = {INT64_MAX - 1, INT64_MAX}, backwards[2] = {INT64_MAX, INT64_MIN};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_invalid(reduce_of(sky, exposures, NULL, &bad[i], 1, &reduced, &left), "y[0]");
    assert_invalid(reduce_of(sky, exposures, &none, &good, 1, &reduced, &left), "data->interval_counts[0]");
    assert_refused(reduce_of(sky, late, NULL, &good, 1, &reduced, &left), TOLIMAN_E_RANGE, "time");
    assert_invalid(reduce_of(sky, backwards, NULL, &good, 1, &reduced, &left), "intervals");
    assert_invalid(reduce_of(sky, NULL, NULL, &good, 1, &reduced, &left), "data->t");
    assert_invalid(reduce_of(sky, exposures, NULL, NULL, 1, &reduced, &left), "data->y");
    assert_invalid(toliman_sky_reduce(sky, NULL, NULL, NULL), "measured");
    toliman_measure *const values = measure_of(&good, &good, NULL, 1);
    toliman_measure *made = NULL;
    assert_invalid(toliman_sky_reduce(sky, values, NULL, &made), "measured");
    toliman_sky_prediction seen = {.struct_size = 4};
    assert_invalid(toliman_sky_predict_mean(sky, exposures, NULL, 1, &seen), "predictions->struct_size");
    toliman_measure_destroy(values);
    assert_null(made);
    assert_true(reduced == 5);
}

/* Against the elements and the partial derivatives themselves, 1900 to 2100. */
TEST(columns_are_the_partials_of_uncertain_elements) {
    static const int32_t known[7] = {0, 1, 2, 3, 4, 5, 6};
    const double scale = 0.05, scale_sigma = 1e-3;
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    int32_t elements[7];
    options.trend = 1;
    options.prior_precision[0] = 7;
    options.value_bound = 3;
    assert_ok(toliman_sky_set_columns(sky, scale, scale_sigma, &options, elements));
    assert_memory_equal(elements, known, sizeof known);
    assert_int_equal(options.columns, 7);
    assert_int_equal(options.trend, 1);
    assert_true(options.prior_precision[0] == 7 && options.prior_precision[1] == 0 && options.value_bound == 3);
    for (int c = 0; c < 7; c++) {
        double value, sigma;
        assert_ok(toliman_sky_get_element(sky, TOLIMAN_SKY_ELEMENT_PERIOD + elements[c], &value, &sigma));
        if (elements[c] == 1)
            sigma = hypot(sigma, value * scale_sigma);
        const double expected = scale * scale / (sigma * sigma);
        assert_close(options.prior_precision[2 + c], expected, 1e-13, 0);
    }
    double largest[7] = {0};
    for (int64_t i = -800; i <= 1500; i++) { /* months about 1970 */
        const int64_t tai_ns = i * INT64_C(2629800000000000);
        toliman_sky_prediction seen = TOLIMAN_SKY_PREDICTION_INIT;
        assert_ok(toliman_sky_predict(sky, &tai_ns, 1, &seen));
        for (int element = 0; element < 7; element++)
            largest[element] = fmax(largest[element], fabs(seen.partials[element]));
    }
    for (int c = 0; c < 7; c++) {
        assert_true(options.column_bound[c] >= largest[elements[c]]);
        assert_true(elements[c] == 4 || options.column_bound[c] <= 32 * largest[elements[c]]);
    }
}

TEST(bad_columns_are_refused) {
    toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
    int32_t elements[7];
    assert_invalid(toliman_sky_set_columns(NULL, 1, 0, &options, elements), "sky");
    assert_invalid(toliman_sky_set_columns(sky, 0, 0, &options, elements), "unit_arcsec");
    assert_invalid(toliman_sky_set_columns(sky, NAN, 0, &options, elements), "unit_arcsec");
    assert_invalid(toliman_sky_set_columns(sky, 1, 1, &options, elements), "scale_sigma");
    assert_invalid(toliman_sky_set_columns(sky, 1, 0, NULL, elements), "options");
    assert_invalid(toliman_sky_set_columns(sky, 1, 0, &options, NULL), "elements");
    options.trend = 9;
    assert_invalid(toliman_sky_set_columns(sky, 1, 0, &options, elements), "options->trend");
}

TEST(properties_are_those_of_the_options) {
    toliman_sky_info info = TOLIMAN_SKY_INFO_INIT;
    assert_ok(toliman_sky_get_info(sky, &info));
    assert_int_equal(info.observer, TOLIMAN_SKY_OBSERVER_CIRCULAR);
    assert_int_equal(info.without, 0);
    assert_int_equal(info.segments, 0);
    assert_true(info.first_ns == 0 && info.last_ns == 0 && info.orbit_digest != 0);
    assert_string_equal(info.name, "alpha Centauri AB");
    assert_string_equal(toliman_constant_name(info.observer), "circular orbit");
    assert_string_equal(toliman_constant_name(TOLIMAN_SKY_OBSERVER_EARTH), "Earth");
    assert_string_equal(toliman_constant_name(TOLIMAN_SKY_OBSERVER_FILE), "file");
    assert_string_equal(toliman_constant_name(700), "?");
    assert_string_equal(toliman_constant_name(704), "?");
    double value = 0, sigma = 0;
    assert_ok(toliman_sky_get_element(sky, TOLIMAN_SKY_ELEMENT_ECCENTRICITY, &value, &sigma));
    assert_true(value == 0.51947 && sigma == 0.00015);
    assert_ok(toliman_sky_get_element(sky, TOLIMAN_SKY_ELEMENT_EPOCH, &value, NULL));
    assert_true(value == 1955.564);
    assert_string_equal(toliman_constant_name(TOLIMAN_SKY_ELEMENT_PERIOD), "period_years");
    assert_string_equal(toliman_constant_name(TOLIMAN_SKY_ELEMENT_EPOCH), "epoch");
}

static void keep_text(int32_t level, const char *text, void *data) {
    assert_int_equal(level, TOLIMAN_LOG_WARNING);
    snprintf(data, 400, "%s", text);
}

TEST(the_centre_of_the_earth_is_a_warning) {
    char text[400] = "";
    toliman_sky_options options = {.struct_size = sizeof options, .log = keep_text, .log_data = text};
    toliman_sky *made = NULL;
    assert_ok(toliman_sky_create("alpha-cen", &options, &made));
    assert_non_null(strstr(text, "no observer given: predictions are for the Earth's centre"));
    toliman_sky_destroy(made);
    text[0] = '\0';
    options.without = TOLIMAN_SKY_SPACECRAFT_ABERRATION;
    assert_ok(toliman_sky_create("alpha-cen", &options, &made));
    assert_string_equal(text, "");
    toliman_sky_destroy(made);
}

/* A caller with a shorter struct gets the members that it knows. */
TEST(rows_have_the_caller_s_size) {
    toliman_sky_prediction whole = TOLIMAN_SKY_PREDICTION_INIT;
    assert_ok(toliman_sky_predict(sky, times, 1, &whole));
    assert_close(whole.separation_arcsec / whole.geometric_arcsec, whole.factor, 0, 0);
    assert_close(whole.geometric_arcsec, 9.765, 0, 1e-3);
    assert_int_equal(whole.struct_size, sizeof whole);
    assert_int_equal(whole.reserved, 0);
    assert_true(fabs(whole.partials[4]) > 0 &&
                fabs(whole.partials[4]) < 1e-3); /* by the node: through the factor alone */
    const int64_t exposure[2] = {times[0] - 1, times[0] + 1};
    toliman_sky_prediction mean = TOLIMAN_SKY_PREDICTION_INIT;
    assert_ok(toliman_sky_predict_mean(sky, exposure, NULL, 1, &mean));
    assert_close(mean.separation_arcsec, whole.separation_arcsec, 1e-15, 0);
    assert_close(mean.position_angle_deg, whole.position_angle_deg, 1e-13, 0);
    assert_close(mean.partials[1], whole.partials[1], 1e-14, 0);
}

typedef struct {
    const toliman_sky *sky;
    int order;
    toliman_status status, mean_status;
    toliman_sky_prediction seen[TIMES], mean;
} job;

/* Every thread in another order, so that all fill the table of the Earth at the same time. */
static void *predict_in_order(void *given) {
    job *const own = given;
    for (int i = 0; i < TIMES && own->status == TOLIMAN_OK; i++) {
        const int k = (own->order * 7 + (own->order % 2 ? TIMES - i : i)) % TIMES;
        own->seen[k].struct_size = sizeof own->seen[k];
        own->status = toliman_sky_predict(own->sky, &times[k], 1, &own->seen[k]);
    }
    own->mean.struct_size = sizeof own->mean;
    own->mean_status = toliman_sky_predict_mean(own->sky, (const int64_t[]){kStart, kStart + 3600000000000},
                                                &(size_t){1}, 1, &own->mean);
    return NULL;
}

/* promise: const-calls-run-together */
TEST(threads_give_the_bits_of_one) {
    static job alone, jobs[THREADS];
    const toliman_sky_options options = {.struct_size = sizeof options, .altitude_km = 600};
    toliman_sky *shared = NULL;
    assert_ok(toliman_sky_create("alpha-cen", &options, &shared));
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; i++) {
        jobs[i].sky = shared;
        jobs[i].order = i;
        assert_int_equal(pthread_create(&threads[i], NULL, predict_in_order, &jobs[i]), 0);
    }
    alone.sky = sky;
    predict_in_order(&alone);
    for (int i = 0; i < THREADS; i++) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
        assert_int_equal(jobs[i].status, TOLIMAN_OK);
        assert_int_equal(jobs[i].mean_status, TOLIMAN_OK);
        assert_memory_equal(jobs[i].seen, alone.seen, sizeof alone.seen);
        assert_memory_equal(&jobs[i].mean, &alone.mean, sizeof alone.mean);
    }
    toliman_sky_destroy(shared);
    static toliman_sky_prediction together[TIMES];
    together[0].struct_size = sizeof *together;
    assert_ok(toliman_sky_predict(sky, times, TIMES, together));
    for (int i = 0; i < TIMES; i++)
        assert_memory_equal(&together[i].separation_arcsec, &alone.seen[i].separation_arcsec,
                            sizeof *together - offsetof(toliman_sky_prediction, separation_arcsec));
}

RUN_TESTS(set_up, tear_down)
