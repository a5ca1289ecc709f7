/* Tests components of simulated frames through the public interface: the period found, the predicted threshold,
 * errors. */
#include <toliman/cae.h>
#include <toliman/components.h>
#include <toliman/linear.h>
#include <toliman/period.h>

#include "images.h"
#include "scene_text.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE, FRAMES = 100 };

static toliman_components *collection(const toliman_sim *sim, int32_t raw, uint32_t bin) {
    toliman_components *components = NULL;
    toliman_components_options options = {.struct_size = sizeof options, .raw = raw, .bin = bin};
    assert_ok(toliman_components_create(sim, &options, &components));
    return components;
}

/* Frames with the scene's signal multiplied by `times`. */
static void push_frames(toliman_components *components, const toliman_sim *sim, double times, size_t count) {
    static double displacement[FRAMES], image[PIXELS];
    assert_ok(toliman_sim_get_series(sim, 0, FRAMES, NULL, displacement));
    for (size_t f = 0; f < count; f++) {
        assert_ok(toliman_sim_frame(sim, &(double){times * displacement[f]}, 5, (int64_t)f, 1, image));
        assert_ok(toliman_components_push(components, PLAIN_IMAGE(image), 1));
    }
}

static toliman_components_info info_of(const toliman_components *components) {
    toliman_components_info info = {.struct_size = sizeof info};
    assert_ok(toliman_components_get_info(components, &info));
    return info;
}

static void train(toliman_components *components, int32_t method, uint32_t count, uint32_t threads) {
    toliman_components_train_options options = TOLIMAN_COMPONENTS_TRAIN_OPTIONS_INIT;
    options.method = method;
    options.components = count;
    options.threads = threads;
    options.seed = 3;
    assert_ok(toliman_components_train(components, &options, NULL));
}

static toliman_period_peak peak_of(const toliman_components *components, const double *times) {
    double series[FRAMES], share = 0;
    assert_ok(toliman_components_get_series(components, 0, series, &share));
    assert_true(share > 0 && share < 1);
    toliman_period *period = NULL;
    toliman_period_peak peak = {.struct_size = sizeof peak};
    const double span = times[FRAMES - 1] - times[0];
    assert_ok(toliman_period_create(1.5 / span, 0.1 / span, 400, NULL, &period));
    assert_ok(toliman_period_push_many(period, times, series, NULL, FRAMES));
    assert_ok(toliman_period_query_peak(period, &peak));
    toliman_period_destroy(period);
    return peak;
}

/* 1e-3 px are more than three times the threshold for this number of photons; a tenth of the threshold is not
 * detected. */
TEST(every_method_finds_a_period_above_the_threshold_and_none_below) {
    toliman_sim *sim = sim_with(kBinaryScene, "\"peak_photons\": 1e5", "\"peak_photons\": 1e7");
    double times[FRAMES], displacement[FRAMES];
    assert_ok(toliman_sim_get_series(sim, 0, FRAMES, times, displacement));
    for (int32_t raw = 0; raw < 2; raw++)
        for (uint32_t bin = 1; bin <= 4; bin *= 2) {
            toliman_components *const components = collection(sim, raw, bin);
            push_frames(components, sim, 1, FRAMES);
            const toliman_components_info info = info_of(components);
            assert_true(info.pixels == PIXELS / (bin * bin) && info.frames == FRAMES && info.capacity == FRAMES);
            if (!raw)
                assert_at_most(info.threshold_px, 0.3e-3);
            for (int32_t method = TOLIMAN_COMPONENTS_PCA; method <= TOLIMAN_COMPONENTS_DICTIONARY; method++) {
                train(components, method, 1, 0);
                const toliman_period_peak peak = peak_of(components, times);
                assert_close(peak.period, 40, 0.02, 0);
                assert_true(peak.log10_fap < -10);
            }
            toliman_components_destroy(components);
            if (!raw) {
                toliman_components *const weak = collection(sim, raw, bin);
                push_frames(weak, sim, 0.1 * info.threshold_px / 1e-3, FRAMES);
                train(weak, TOLIMAN_COMPONENTS_PCA, 1, 0);
                assert_true(peak_of(weak, times).log10_fap > -3);
                toliman_components_destroy(weak);
            }
        }
    toliman_sim_destroy(sim);
}

/* Whitened frames: the signal's eigenvalue is A^2/(2 crb^2), as the Cramer-Rao bound says, within the noise of the
 * others. The bound equals the simulator's. */
TEST(eigenvalue_and_bound_match_the_scene) {
    toliman_sim *sim = sim_with(kBinaryScene, "\"peak_photons\": 1e5", "\"peak_photons\": 1e8");
    toliman_components *const components = collection(sim, 0, 1);
    push_frames(components, sim, 1, FRAMES);
    train(components, TOLIMAN_COMPONENTS_PCA, 1, 0);
    const toliman_components_info info = info_of(components);
    double series[FRAMES], eigenvalue = 0;
    assert_close(info.crb_px, sim_bounds_of(sim).crb_px, 1e-9, 0);
    assert_close(info.threshold_px, info.crb_px * sqrt(2 * sqrt((double)PIXELS / FRAMES)), 1e-12, 0);
    assert_ok(toliman_components_get_series(components, 0, series, NULL));
    double largest = 0;
    for (size_t f = 0; f < FRAMES; f++) {
        eigenvalue += series[f] * series[f] / FRAMES;
        largest = fabs(series[f]) > fabs(largest) ? series[f] : largest;
    }
    assert_true(largest > 0); /* the sign is defined */
    const double signal = 1e-6 / (2 * info.crb_px * info.crb_px), white = (double)PIXELS / FRAMES;
    assert_true(signal > 5 * sqrt(white));
    assert_close(eigenvalue, (1 + signal) * (1 + white / signal), 0.05, 0);
    toliman_components_destroy(components), toliman_sim_destroy(sim);
}

/* Frames with varying fluxes of the stars and without photon noise: the variation vanishes completely if
 * preprocess.project lists the fluxes. */
TEST(projected_nuisances_leave_nothing) {
    static double image[PIXELS], both[PIXELS], star[PIXELS];
    const char *const read = "\"read_e\": 2.5, \"seed\": 7}";
    double length[2] = {0};
    for (int project = 0; project < 2; project++) {
        toliman_sim *sim = sim_with(
            kBinaryScene, read,
            project ? "\"read_e\": 2.5, \"seed\": 7}, \"preprocess\": {\"project\": [\"flux_a\", \"flux_b\"]}" : read);
        toliman_components *const components = collection(sim, 0, 2);
        assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, both, SIDE));
        assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_STAR_A, star, SIDE));
        for (int f = 0; f < 20; f++) {
            for (size_t i = 0; i < PIXELS; i++)
                image[i] = both[i] * (1 + 0.01 * sin(f)) + star[i] * 0.02 * cos(2 * f);
            assert_ok(toliman_components_push(components, PLAIN_IMAGE(image), 1));
        }
        assert_true(info_of(components).projected == (project ? 2u : 0u));
        assert_close(info_of(components).crb_px, sim_bounds_of(sim).crb_projected_px, 0.5, 0); /* the cost of binning */
        assert_true(info_of(components).crb_px > sim_bounds_of(sim).crb_projected_px);
        train(components, TOLIMAN_COMPONENTS_PCA, 1, 0);
        double series[FRAMES];
        assert_ok(toliman_components_get_series(components, 0, series, NULL));
        for (int f = 0; f < 20; f++)
            length[project] += series[f] * series[f];
        toliman_components_destroy(components), toliman_sim_destroy(sim);
    }
    assert_at_most(length[1], 1e-12 * length[0]);
}

static int32_t stop_at(const char *stage, double fraction, void *user_data) {
    (void)fraction;
    return strcmp(stage, user_data) == 0;
}

/* promises: cancelled-components-remain, stopped-objects-stay-usable */
TEST(push_discards_a_training_and_cancellation_does_not) {
    static double image[PIXELS];
    double before[FRAMES], after[FRAMES], share;
    toliman_sim *sim = sim_of(kBinaryScene);
    toliman_components *const components = collection(sim, 0, 4);
    push_frames(components, sim, 1, 40);
    assert_refused(toliman_components_get_series(components, 0, before, NULL), TOLIMAN_E_STATE, "");
    train(components, TOLIMAN_COMPONENTS_PCA, 2, 0);
    assert_ok(toliman_components_get_series(components, 1, before, NULL));
    toliman_components_train_options options = TOLIMAN_COMPONENTS_TRAIN_OPTIONS_INIT;
    options.method = TOLIMAN_COMPONENTS_DICTIONARY;
    options.progress = stop_at;
    options.progress_data = "dictionary";
    toliman_components_training report = {.struct_size = sizeof report, .iterations = 77};
    assert_refused(toliman_components_train(components, &options, &report), TOLIMAN_E_CANCELLED, "");
    assert_int_equal(report.iterations, 77);
    assert_ok(toliman_components_get_series(components, 1, after, &share));
    assert_memory_equal(before, after, 40 * sizeof *before);

    options.progress = NULL;
    options.iterations = 1;
    options.lambda = 0.1;
    assert_ok(toliman_components_train(components, &options, &report));
    assert_true(report.iterations == 1 && report.converged == 0 && report.objective > 0 && report.objective < 1);
    assert_ok(toliman_sim_frame(sim, &(double){0}, 5, 40, 1, image));
    image[0] = NAN;
    assert_invalid(toliman_components_push(components, PLAIN_IMAGE(image), 1), "counts[0][0]");
    assert_ok(toliman_components_get_series(components, 0, NULL, &share));
    image[0] = 0;
    assert_ok(toliman_components_push(components, PLAIN_IMAGE(image), 1));
    assert_refused(toliman_components_get_series(components, 0, after, NULL), TOLIMAN_E_STATE, "");
    options.progress = stop_at;
    options.progress_data = "products";
    assert_refused(toliman_components_train(components, &options, NULL), TOLIMAN_E_CANCELLED, "");
    assert_true(info_of(components).components == 0 && info_of(components).frames == 41);
    toliman_components_destroy(components), toliman_sim_destroy(sim);
}

/* Other ranges of options: bind/test_options. */
TEST(errors_name_the_argument_and_change_nothing) {
    static double image[PIXELS];
    toliman_sim *sim = sim_of(kBinaryScene);
    toliman_components *components = NULL;
    toliman_components_options options = TOLIMAN_COMPONENTS_OPTIONS_INIT;
    assert_invalid(toliman_components_create(NULL, NULL, &components), "sim");
    assert_invalid(toliman_components_create(sim, NULL, NULL), "out");
    const struct {
        toliman_components_options options;
        const char *field;
    } wrong[] = {{{.struct_size = sizeof options, .bin = 3}, "options->bin"},
                 {{.struct_size = sizeof options, .raw = 2}, "options->raw"},
                 {{.struct_size = sizeof options, .capacity = 1}, "options->capacity"},
                 {{.struct_size = 3}, "options->struct_size"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_invalid(toliman_components_create(sim, &wrong[i].options, &components), wrong[i].field);
    assert_null(components);
    options.capacity = 2;
    assert_ok(toliman_components_create(sim, &options, &components));
    assert_true(isinf(info_of(components).threshold_px));

    const toliman_image narrow = {.struct_size = sizeof narrow, .pixels = image, .stride = SIDE - 1};
    assert_invalid(toliman_components_push(NULL, PLAIN_IMAGE(image), 1), "components");
    assert_invalid(toliman_components_push(components, NULL, 1), "image");
    assert_invalid(toliman_components_push(components, &narrow, 1), "image->stride");
    image[5] = 1e300;
    assert_refused(toliman_components_push(components, PLAIN_IMAGE(image), 1), TOLIMAN_E_RANGE, "counts");
    assert_true(info_of(components).frames == 0);
    image[5] = 0;

    assert_ok(toliman_components_push(components, PLAIN_IMAGE(image), 1));
    assert_refused(toliman_components_train(components, NULL, NULL), TOLIMAN_E_STATE, "");
    image[5] = 1;
    assert_ok(toliman_components_push(components, PLAIN_IMAGE(image), 1));
    assert_refused(toliman_components_push(components, PLAIN_IMAGE(image), 1), TOLIMAN_E_CAPACITY, "count");
    toliman_components_train_options training = {.struct_size = sizeof training, .reserved = 1};
    assert_invalid(toliman_components_train(components, &training, NULL), "options->reserved");
    training.reserved = 0;
    training.components = 65;
    assert_invalid(toliman_components_train(components, &training, NULL), "options->components");
    training.components = 0;
    double series[2] = {0};
    assert_ok(toliman_components_train(components, &training, NULL));
    for (int bad = -1; bad < 2; bad += 2)
        assert_refused(toliman_components_get_series(components, bad, series, NULL), TOLIMAN_E_RANGE, "component");
    assert_ok(toliman_components_get_series(components, 0, series, NULL));
    assert_true(fmax(series[0], series[1]) > 0); /* the largest is positive; two are opposite relative to their mean */
    assert_close(series[1], -series[0], 1e-12, 0);
    toliman_components_info info = {.struct_size = 1};
    assert_invalid(toliman_components_get_info(components, &info), "out->struct_size");
    toliman_components_destroy(NULL);
    toliman_components_destroy(components), toliman_sim_destroy(sim);
}

static void count_line(int32_t level, const char *text, void *lines) {
    assert_int_equal(level, TOLIMAN_LOG_WARNING);
    *(int *)lines += 1;
    assert_string_equal(text, "scene: preprocess.project: roll is a combination of shift_y (1.00): it is dropped");
}

/* The roll of a single star to the right of the centre is a shift along y. Each estimator that projects reports it. */
TEST(dependent_nuisances_are_logged) {
    char *const json = replaced_again(
        replaced_again(replaced(kSingleScene, "[0, 0]", "[4, 0]"), "[32, 32]", "[256, 256]"), "\"cadence\"",
        "\"preprocess\": {\"project\": [\"flux_a\", \"shift_y\", \"roll\"]}, \"cadence\"");
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(json, strlen(json), NULL, NULL, &sim));
    free(json);
    int lines = 0;
    toliman_linear *linear = NULL;
    const toliman_linear_options of_template = {
        .struct_size = sizeof of_template, .log = count_line, .log_data = &lines};
    assert_ok(toliman_linear_create(sim, &of_template, &linear));
    assert_int_equal(lines, 1);
    toliman_cae *cae = NULL;
    const toliman_cae_options of_network = {.struct_size = sizeof of_network, .log = count_line, .log_data = &lines};
    assert_ok(toliman_cae_create(sim, 1, &of_network, &cae));
    assert_int_equal(lines, 2);
    for (int32_t raw = 0; raw < 2; raw++) { /* raw counts are not projected */
        toliman_components *components = NULL;
        const toliman_components_options options = {
            .struct_size = sizeof options, .raw = raw, .log = count_line, .log_data = &lines};
        assert_ok(toliman_components_create(sim, &options, &components));
        assert_int_equal(lines, 3);
        toliman_components_destroy(components);
    }
    toliman_cae_destroy(cae), toliman_linear_destroy(linear), toliman_sim_destroy(sim);
}

RUN_TESTS(NULL, NULL)
