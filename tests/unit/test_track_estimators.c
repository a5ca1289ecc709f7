/* Tests the network and the template as estimators of a tracker: the same values as called directly, no allocation per
 * frame, and folders that record which estimator made their values. */
#include <malloc.h>

#include "asked_memory.h"
#include "cae_scene.h"

#include <toliman/linear.h>
#include <toliman/track.h>

static toliman_track_options options_of(const toliman_cae *cae, const toliman_linear *linear) {
    toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
    options.ledger.capacity = 1000;
    options.estimator.cae = cae;
    options.estimator.linear = linear;
    options.grid.f0 = 0.001;
    options.grid.df = 0.001;
    options.grid.nf = 50;
    return options;
}

/* A frame of the scene in integer counts, inside a larger frame: crop (3, 5). */
enum { ROWS = kSide + 10, COLS = kSide + 12 };

static uint32_t *frame_in_window(const toliman_sim *sim, int64_t number, double *counts) {
    uint32_t *pixels = calloc(ROWS * COLS, sizeof *pixels);
    assert_non_null(pixels);
    assert_ok(toliman_sim_frame(sim, &(double){0}, 1, number, 1, counts));
    for (int r = 0; r < kSide; r++)
        for (int c = 0; c < kSide; c++) {
            double *count = &counts[r * kSide + c];
            *count = nearbyint(fmax(*count, 1));
            pixels[(r + 3) * COLS + c + 5] = (uint32_t)*count;
        }
    return pixels;
}

static toliman_frame frame_of(int64_t id, const uint32_t *pixels) {
    return (toliman_frame){.struct_size = sizeof(toliman_frame),
                           .pixel = TOLIMAN_PIXEL_U32,
                           .session = "s",
                           .roi = "core",
                           .frame_id = id,
                           .camera_ns = id * 86400000000000,
                           .pixels = pixels,
                           .rows = ROWS,
                           .cols = COLS};
}

/* promise: encoding-allocates-nothing */
TEST(values_match_the_estimators) {
    toliman_sim *sim = make_sim(kSide, kSide, 0, "\"flux_a\", \"flux_b\"");
    toliman_cae *cae = make_cae(sim, 1, 60, NULL);
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    double *counts = new_image(kPixels);
    for (int which = 0; which < 2; which++) {
        toliman_track_options options = options_of(which ? cae : NULL, which ? NULL : linear);
        options.frames.rows = ROWS;
        options.frames.cols = COLS;
        options.frames.crop_row = 3;
        options.frames.crop_col = 5;
        options.flags = TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
        toliman_track *track = NULL;
        assert_ok(toliman_track_create(&options, &track));
        for (int64_t id = 1; id <= 4; id++) {
            uint32_t *pixels = frame_in_window(sim, id, counts);
            const toliman_frame frame = frame_of(id, pixels);
            toliman_track_outcome outcome = {.struct_size = sizeof outcome};
            size_t done;
            double value;
            const toliman_spread spread = {.struct_size = sizeof spread, .frames = 3};
            toliman_frame sum = frame;
            sum.spread = &spread;
            assert_refused(toliman_track_push(track, &sum, 1, &outcome, &done), TOLIMAN_E_UNSUPPORTED,
                           "frames[0].spread");
            toliman_frame_goodness goodness = TOLIMAN_FRAME_GOODNESS_INIT;
            const toliman_image image = {.struct_size = sizeof image, .pixels = counts};
            assert_ok(which ? toliman_cae_encode(cae, &image, 1, &value, &goodness)
                            : toliman_linear_encode(linear, &image, 1, &value, &goodness));
            asked = 0;
            assert_ok(toliman_track_push(track, &frame, 1, &outcome, &done));
            assert_int_equal(asked, 0);
            assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
            assert_true(outcome.value == value && outcome.chi_square == goodness.chi_square);
            assert_close(goodness.chi_square, 1, 0, 5 * sqrt(2.0 / kPixels));
            free(pixels);
        }
        toliman_track_info info = {.struct_size = sizeof info};
        assert_ok(toliman_track_get_info(track, &info));
        double sigma;
        assert_ok(toliman_linear_get_sigma(linear, &sigma));
        assert_close(info.sigma, sigma, which ? 1e-5 : 0, 0);
        assert_true(info.value_limit == 1e4 * info.sigma);
        toliman_track_destroy(track);
    }
    free(counts), toliman_linear_destroy(linear), toliman_cae_destroy(cae), toliman_sim_destroy(sim);
}

static uint64_t id_of(const toliman_track_options *options) {
    toliman_track *track = NULL;
    toliman_track_info info = {.struct_size = sizeof info};
    assert_ok(toliman_track_create(options, &track));
    assert_ok(toliman_track_get_info(track, &info));
    toliman_track_destroy(track);
    return info.estimator_id;
}

/* promise: estimators-are-not-mixed */
TEST(estimators_are_distinguished) {
    toliman_sim *sim = make_sim(kSide, kSide, 0, ""), *other_sim = make_sim(kSide, kSide, 0, "\"flux_a\"");
    toliman_cae *cae = make_cae(sim, 1, 0, NULL), *again = make_cae(sim, 1, 0, NULL),
                *other = make_cae(sim, 2, 0, NULL);
    toliman_cae *projected = make_cae(other_sim, 1, 0, NULL), *loaded = NULL;
    static unsigned char bytes[4 << 20];
    size_t size;
    assert_ok(toliman_cae_save(cae, NULL, bytes, sizeof bytes, &size));
    assert_ok(toliman_cae_load(bytes, size, NULL, &loaded));
    toliman_linear *linear = NULL, *other_linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    assert_ok(toliman_linear_create(other_sim, NULL, &other_linear));
    const toliman_cae *const networks[] = {cae, again, loaded, other, projected, NULL, NULL};
    const toliman_linear *const templates[] = {NULL, NULL, NULL, NULL, NULL, linear, other_linear};
    uint64_t ids[7];
    for (int i = 0; i < 7; i++) {
        const toliman_track_options options = options_of(networks[i], templates[i]);
        ids[i] = id_of(&options);
    }
    assert_true(ids[0] == ids[1] && ids[0] == ids[2]);
    for (int i = 2; i < 7; i++)
        for (int k = i + 1; k < 7; k++)
            assert_true(ids[i] != ids[k]);
    toliman_track_options both = options_of(cae, linear);
    toliman_track *track = NULL;
    assert_invalid(toliman_track_create(&both, &track), "options");
    both = options_of(cae, NULL);
    both.frames.image_rows = 128;
    assert_invalid(toliman_track_create(&both, &track), "options->frames.image_rows");
    toliman_linear_destroy(linear), toliman_linear_destroy(other_linear);
    toliman_cae *const made[] = {cae, again, loaded, other, projected};
    for (int i = 0; i < 5; i++)
        toliman_cae_destroy(made[i]);
    toliman_sim_destroy(sim), toliman_sim_destroy(other_sim);
}

/* Counts for which a network gives no finite value: the frame is rejected, without an error. The template's value is
 * finite, but too large. */
/* promise: bad-estimates-reject-frames */
TEST(counts_without_an_estimate) {
    static double pixels[kPixels];
    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    toliman_cae *cae = make_cae(sim, 1, 0, NULL);
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    for (int i = 0; i < kPixels; i++)
        pixels[i] = i % 2 ? 1e308 : -1e308;
    for (int which = 0; which < 2; which++) {
        const toliman_track_options options = options_of(which ? cae : NULL, which ? NULL : linear);
        toliman_track *track = NULL;
        assert_ok(toliman_track_create(&options, &track));
        toliman_frame frame = frame_of(1, NULL);
        frame.pixel = TOLIMAN_PIXEL_F64;
        frame.pixels = pixels;
        frame.rows = frame.cols = kSide;
        toliman_track_outcome outcome = {.struct_size = sizeof outcome};
        size_t done = 0;
        assert_ok(toliman_track_push(track, &frame, 1, &outcome, &done));
        assert_int_equal(outcome.verdict, which ? TOLIMAN_TRACK_VERDICT_REJECTED : TOLIMAN_TRACK_VERDICT_OUTLIER);
        assert_int_equal(outcome.reason, which ? TOLIMAN_TRACK_REASON_ESTIMATE : TOLIMAN_TRACK_REASON_NONE);
        toliman_track_destroy(track);
    }
    toliman_linear_destroy(linear), toliman_cae_destroy(cae), toliman_sim_destroy(sim);
}

RUN_TESTS(NULL, NULL)
