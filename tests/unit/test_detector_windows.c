/* Tests frames of windows that jump by whole pixels on the detector, as the camera's follow the stars: the bad pixels
 * that the scene knows stay at their places on the detector, for network, template, fit, bank, calibration and tracker.
 * */
#include <toliman/calibrate.h>
#include <toliman/coadd.h>
#include <toliman/linear.h>
#include <toliman/track.h>

#include "bank_scene.h"
#include "cae_scene.h"
#include "scene_files.h"
#include "tlmw.h"

enum { SIDE = 128, PIXELS = SIDE * SIDE, ROW = 912, COL = 40, BAD = 12, DOWN = 3, RIGHT = -2 };

/* Of the bad pixels, in the scene's window. In the window that jumped they are where a loss of light moves the stars
 * apart: those of the greatest effect of one sign. None is DOWN and RIGHT from another. */
static const int kBad[BAD][2] = {{68, 48}, {67, 47}, {68, 47}, {54, 92}, {66, 46}, {55, 92},
                                 {69, 49}, {78, 52}, {55, 93}, {56, 93}, {69, 48}, {53, 92}};
static toliman_sim *plain, *known, *placed; /* without bad pixels; with them; and with the window's place */

static void write_map(void) {
    static uint8_t map[PIXELS];
    for (int k = 0; k < BAD; k++)
        map[kBad[k][0] * SIDE + kBad[k][1]] = 1;
    write_npy("other.npy", "|u1", "(128, 128)", map, PIXELS);
}

/* The scene of the bank's tests, whose stars rest, with these members of the detector. */
static toliman_sim *scene_with(int side, const char *detector) {
    static char json[2048];
    const int size = snprintf(
        json, sizeof json,
        "{\"schema\": \"toliman-scene/1\", \"name\": \"windows\","
        " \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.01875, \"pupil_samples\": 96,"
        "  \"mask\": {\"kind\": \"spiral\", \"edges\": \"cell\", \"opd_nm\": 297.5,"
        "   \"terms\": [{\"a\": 0.819, \"f\": 2.918, \"m\": -7, \"p\": 4.874}, {\"a\": 0.93, \"f\": 1.829, \"m\": "
        "5}]}},"
        " \"band\": {\"min_nm\": 570, \"max_nm\": 590, \"step_nm\": 10},"
        " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"relative_flux\": 3},"
        "  \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}}},"
        " \"binary\": {%s},"
        " \"signal\": {\"kind\": \"sinusoid\", \"star\": \"B\", \"amplitude_px\": 1e-3, \"period_days\": 20},"
        " \"cadence\": {\"frames\": 51, \"interval_days\": 1, \"peak_photons\": 1e6},"
        " \"detector\": {\"shape\": [%d, %d], \"pixel_scale_arcsec\": 0.2%s},"
        " \"noise\": {\"photon\": true, \"read_e\": 2.5, \"seed\": 7},"
        " \"preprocess\": {\"project\": [\"flux_a\", \"flux_b\", \"shift_x\", \"shift_y\"]}}",
        BANK_AT_REST, side, side, detector);
    assert_in_range(size, 1, sizeof json - 1);
    return sim_of(json);
}

FIXTURE(set_up) {
    char detector[256];
    assert_int_equal(make_folder(NULL), 0);
    write_map();
    plain = scene_with(SIDE, "");
    snprintf(detector, sizeof detector, ", \"bad_pixels\": \"%s\"", path_of("other.npy"));
    known = scene_with(SIDE, detector);
    snprintf(detector, sizeof detector, ", \"bad_pixels\": \"%s\", \"window\": [%d, %d]", path_of("other.npy"), ROW,
             COL);
    placed = scene_with(SIDE, detector);
    return 0;
}

FIXTURE(tear_down) {
    toliman_sim_destroy(plain), toliman_sim_destroy(known), toliman_sim_destroy(placed);
    return remove_folder(NULL);
}

/* A frame whose window follows the stars: they are where they are in the scene's window, but the dead pixels, which
 * give `share` of their light, are (down, right) px further up and left. */
static void frame_of(int down, int right, double share, double *counts) {
    assert_ok(toliman_sim_frame(plain, &(double){0}, 1, 4, 1, counts));
    for (int k = 0; k < BAD; k++) {
        const int row = kBad[k][0] - down, col = kBad[k][1] - right;
        if (row >= 0 && row < SIDE && col >= 0 && col < SIDE)
            counts[row * SIDE + col] *= share;
    }
}

typedef struct {
    toliman_cae *cae;
    toliman_linear *linear;
    toliman_fit *fit;
    toliman_bank *bank;
} Estimators;

static Estimators estimators_of(const toliman_sim *sim) {
    Estimators made = {make_cae(sim, 1, 200, NULL), NULL, bank_fit(sim, 4), NULL};
    assert_ok(toliman_linear_create(sim, NULL, &made.linear));
    made.bank = bank_of(made.fit, 1, 0.5, 200);
    train_bank(made.bank, made.fit, 1);
    return made;
}

static void destroy(Estimators *made) {
    toliman_cae_destroy(made->cae), toliman_linear_destroy(made->linear);
    toliman_bank_destroy(made->bank), toliman_fit_destroy(made->fit);
}

enum { CAE, LINEAR, FIT, BANK, ESTIMATORS };
typedef struct {
    double value;
    uint32_t bad_pixels;
    int32_t goodness;
} Estimate;

static Estimate estimate(const Estimators *by, int which, const double *counts, const int64_t *window) {
    const toliman_image image = {.struct_size = sizeof image, .pixels = counts, .windows = window};
    toliman_frame_goodness goodness = TOLIMAN_FRAME_GOODNESS_INIT;
    toliman_fit_result fitted = {.struct_size = sizeof fitted};
    toliman_bank_result result = {.struct_size = sizeof result};
    double value = 0;
    if (which == CAE)
        assert_ok(toliman_cae_encode(by->cae, &image, 1, &value, &goodness));
    else if (which == LINEAR)
        assert_ok(toliman_linear_encode(by->linear, &image, 1, &value, &goodness));
    else if (which == FIT)
        assert_ok(toliman_fit_frame(by->fit, &image, 1, NULL, &fitted, NULL, NULL));
    else
        assert_ok(toliman_bank_encode(by->bank, by->fit, &image, 1, NULL, &result, NULL));
    if (which == FIT)
        return (Estimate){fitted.displacement_px, fitted.bad_pixels, fitted.goodness};
    if (which == BANK)
        return (Estimate){result.displacement_px, result.bad_pixels, result.goodness};
    return (Estimate){value, goodness.bad_pixels, goodness.goodness};
}

/* Pixels that lose 1.5 % of their light, 2 to 6 sigma: no residual shows them, so that they bias a value by 2.5 sigma
 * unless their places are known. */
/* promise: bad-pixels-stay-on-the-detector */
TEST(values_do_not_change_with_the_window) {
    static double still[PIXELS], jumped[PIXELS], clean[PIXELS];
    const int64_t windows[3][2] = {{ROW, COL}, {ROW + DOWN, COL + RIGHT}, {ROW + SIDE, COL}};
    toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
    assert_ok(toliman_sim_get_bounds(placed, &bounds));
    const double sigma = bounds.crb_projected_px;
    Estimators with = estimators_of(placed), without = estimators_of(known);
    frame_of(0, 0, 0.985, still), frame_of(DOWN, RIGHT, 0.985, jumped), frame_of(0, 0, 1, clean);
    for (int which = 0; which < ESTIMATORS; which++) {
        const Estimate own = estimate(&with, which, still, windows[0]), none = estimate(&with, which, still, NULL),
                       there = estimate(&with, which, jumped, windows[1]),
                       light = estimate(&with, which, clean, windows[1]),
                       stale = estimate(&without, which, jumped, windows[1]);
        assert_true(own.value == none.value && own.bad_pixels == 0);
        assert_int_equal(there.bad_pixels, BAD);
        /* The same pixels with all their light are left out, too: the value does not depend on it. */
        assert_close(there.value, light.value, 0, 0.02 * sigma);
        assert_close(there.value, own.value, 0, 0.7 * sigma);
        assert_int_equal(there.goodness, TOLIMAN_GOODNESS_GOOD);
        assert_true(fabs(stale.value - own.value) > 1.5 * sigma);
        /* A window without a pixel of the scene's: nothing is known of it. */
        assert_int_equal(estimate(&with, which, clean, windows[2]).bad_pixels, 0);
    }
    destroy(&with), destroy(&without);
}

/* Frames that are encoded together have windows of their own. */
TEST(every_frame_has_its_window) {
    enum { FRAMES = 5 };
    static double frames[FRAMES][PIXELS];
    int64_t windows[FRAMES][2];
    double values[FRAMES];
    Estimators by = estimators_of(placed);
    for (int k = 0; k < FRAMES; k++) {
        frame_of(k, -k, 0.985, frames[k]);
        windows[k][0] = ROW + k, windows[k][1] = COL - k;
    }
    const toliman_image image = {.struct_size = sizeof image, .pixels = frames, .windows = windows[0]};
    toliman_fit_result fitted[FRAMES];
    for (int k = 0; k < FRAMES; k++)
        fitted[k] = (toliman_fit_result){.struct_size = sizeof fitted[k]};
    assert_ok(toliman_cae_encode(by.cae, &image, FRAMES, values, NULL));
    for (int k = 0; k < FRAMES; k++)
        assert_true(values[k] == estimate(&by, CAE, frames[k], windows[k]).value);
    assert_ok(toliman_linear_encode(by.linear, &image, FRAMES, values, NULL));
    for (int k = 0; k < FRAMES; k++)
        assert_true(values[k] == estimate(&by, LINEAR, frames[k], windows[k]).value);
    assert_ok(toliman_fit_frame(by.fit, &image, FRAMES, NULL, fitted, NULL, NULL));
    for (int k = 0; k < FRAMES; k++)
        assert_true(fitted[k].displacement_px == estimate(&by, FIT, frames[k], windows[k]).value);
    destroy(&by);
}

/* The blob has the place of the crop. */
TEST(networks_keep_the_window) {
    static double counts[PIXELS];
    const int64_t window[2] = {ROW + DOWN, COL + RIGHT};
    Estimators by = estimators_of(placed);
    frame_of(DOWN, RIGHT, 0.985, counts);
    const Estimate before = estimate(&by, CAE, counts, window);
    size_t size;
    uint8_t *const bytes = saved(by.cae, &size);
    assert_int_equal(get(bytes + 20, 4) & 32, 32);
    assert_true(get(bytes + 104, 8) == ROW && get(bytes + 112, 8) == COL);
    toliman_cae_destroy(by.cae);
    by.cae = NULL;
    assert_ok(toliman_cae_load(bytes, size, NULL, &by.cae));
    assert_true(estimate(&by, CAE, counts, window).value == before.value);
    assert_saved(by.cae, bytes, size);
    put(bytes + 104, (uint64_t)1 << 33, 8);
    seal(bytes, size);
    refused(bytes, size, "window = ");
    free(bytes), destroy(&by);
}

/* The tracker takes the window of each frame, and adds its crop. */
TEST(trackers_place_their_frames) {
    enum { LARGE = SIDE + 6 };
    static double counts[PIXELS];
    static float pixels[LARGE * LARGE];
    Estimators by = estimators_of(placed);
    frame_of(DOWN, RIGHT, 0.985, counts);
    for (int i = 0; i < LARGE * LARGE; i++)
        pixels[i] = 1;
    for (int i = 0; i < PIXELS; i++)
        counts[i] = pixels[(i / SIDE + 2) * LARGE + i % SIDE + 4] = (float)counts[i];
    const int64_t window[2] = {ROW + DOWN, COL + RIGHT};
    for (int which = 0; which < ESTIMATORS; which++) {
        toliman_track_options options = TOLIMAN_TRACK_OPTIONS_INIT;
        options.estimator.cae = which == CAE ? by.cae : NULL;
        options.estimator.linear = which == LINEAR ? by.linear : NULL;
        options.estimator.fit = which >= FIT ? by.fit : NULL;
        options.estimator.bank = which == BANK ? by.bank : NULL;
        options.frames.rows = options.frames.cols = LARGE;
        options.ledger.capacity = 10;
        options.grid.f0 = options.grid.df = 0.001;
        options.grid.nf = 10;
        options.frames.crop_row = 2;
        options.frames.crop_col = 4;
        toliman_track *track = NULL;
        assert_ok(toliman_track_create(&options, &track));
        toliman_frame frame = {.struct_size = sizeof frame, .pixel = TOLIMAN_PIXEL_F32, .session = "s", .roi = "core"};
        frame.pixels = pixels;
        frame.rows = frame.cols = LARGE;
        frame.frame_id = 1;
        frame.window_row = window[0] - 2;
        frame.window_col = window[1] - 4;
        toliman_track_outcome outcome = {.struct_size = sizeof outcome};
        size_t done;
        assert_ok(toliman_track_push(track, &frame, 1, &outcome, &done));
        assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
        assert_int_equal(outcome.bad_pixels, BAD);
        assert_true(outcome.value == estimate(&by, which, counts, window).value);
        toliman_track_destroy(track);
    }
    destroy(&by);
}

static void sums_refuse_what_moves(const toliman_sim *sim, const uint16_t *pixels) {
    toliman_fit *fit = NULL;
    toliman_coadd *coadd = NULL;
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, NULL, &fit));
    assert_ok(toliman_coadd_create(fit, NULL, NULL, &coadd));
    const int64_t rows[] = {0, ROW, ROW + 1}, cols[] = {0, COL, COL};
    for (int k = 0; k < 3; k++) {
        toliman_frame frame = {.struct_size = sizeof frame,
                               .pixel = TOLIMAN_PIXEL_U16,
                               .session = "s",
                               .roi = "r",
                               .pixels = pixels,
                               .rows = SIDE,
                               .cols = SIDE,
                               .window_row = rows[k],
                               .window_col = cols[k]};
        toliman_coadd_outcome outcome = TOLIMAN_COADD_OUTCOME_INIT;
        if (k < 2)
            assert_ok(toliman_coadd_add(coadd, &frame, &outcome)); /* unknown, and that of the scene */
        else
            assert_refused(toliman_coadd_add(coadd, &frame, &outcome), TOLIMAN_E_UNSUPPORTED, "frame->window_row");
    }
    toliman_coadd_destroy(coadd);
    toliman_fit_destroy(fit);
}

TEST(sums_refuse_pixels_that_move) {
    static uint16_t pixels[PIXELS];
    static uint8_t response[PIXELS];
    char detector[256];
    for (int i = 0; i < PIXELS; i++)
        response[i] = (uint8_t)(1 + i % 2);
    write_npy("other.npy", "|u1", "(128, 128)", response, PIXELS);
    snprintf(detector, sizeof detector, ", \"response\": \"%s\", \"window\": [%d, %d]", path_of("other.npy"), ROW, COL);
    toliman_sim *const uneven = scene_with(SIDE, detector);
    sums_refuse_what_moves(placed, pixels), sums_refuse_what_moves(uneven, pixels);
    toliman_sim_destroy(uneven);
}

/* Window [SIDE][SIDE] of a frame [WIDE][WIDE]. */
enum { MARGIN = 4, WIDE = SIDE + 2 * MARGIN };

static void cut(const double *wide, int row, int col, double *counts) {
    for (int r = 0; r < SIDE; r++)
        memcpy(counts + r * SIDE, wide + (row + r) * WIDE + col, SIDE * sizeof *counts);
}

/* Of stars that rest while the window jumps, the fit finds the same separation at another place; also without a
 * prediction of it. */
TEST(fits_follow_stars_that_the_window_leaves) {
    static double wide[WIDE * WIDE], still[PIXELS], jumped[PIXELS];
    toliman_sim *const detector = scene_with(WIDE, "");
    Estimators by = estimators_of(placed);
    assert_ok(toliman_sim_frame(detector, &(double){0}, 1, 4, 1, wide));
    for (int k = 0; k < BAD; k++)
        wide[(MARGIN + kBad[k][0]) * WIDE + MARGIN + kBad[k][1]] *= 0.985;
    cut(wide, MARGIN, MARGIN, still), cut(wide, MARGIN + DOWN, MARGIN + RIGHT, jumped);
    toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
    assert_ok(toliman_sim_get_bounds(placed, &bounds));
    const Estimate own = estimate(&by, FIT, still, NULL);
    const toliman_image image = {
        .struct_size = sizeof image, .pixels = jumped, .windows = (int64_t[]){ROW + DOWN, COL + RIGHT}};
    const toliman_fit_prediction prediction = {.struct_size = sizeof prediction, .x_px = -RIGHT, .y_px = -DOWN};
    for (int predicted = 0; predicted < 2; predicted++) {
        toliman_fit_result result = {.struct_size = sizeof result};
        assert_ok(toliman_fit_frame(by.fit, &image, 1, predicted ? &prediction : NULL, &result, NULL, NULL));
        assert_close(result.y_px, -DOWN, 0, 0.01);
        assert_close(result.x_px, -RIGHT, 0, 0.01);
        assert_close(result.displacement_px, own.value, 0, 0.5 * bounds.crb_projected_px);
        assert_int_equal(result.bad_pixels, BAD);
        assert_int_equal(result.goodness, TOLIMAN_GOODNESS_GOOD);
    }
    /* A network has its stars at one place: the chi-square tells. */
    assert_int_equal(estimate(&by, CAE, jumped, NULL).goodness, TOLIMAN_GOODNESS_POOR);
    destroy(&by), toliman_sim_destroy(detector);
}

TEST(calibrations_refuse_bad_pixels_that_move) {
    enum { FRAMES = 2 };
    static double counts[FRAMES][PIXELS];
    int64_t windows[FRAMES][2] = {{ROW, COL}, {ROW, COL + 1}};
    for (int k = 0; k < FRAMES; k++)
        assert_ok(toliman_sim_frame(plain, &(double){0}, 1, k, 1, counts[k]));
    const toliman_image image = {.struct_size = sizeof image, .pixels = counts, .windows = windows[0]};
    toliman_calibration *made = NULL;
    const toliman_calibration_options options = {
        .struct_size = sizeof options, .free = "focus", .capture_px = 2, .most_iterations = 1};
    assert_refused(toliman_calibration_create(placed, &image, FRAMES, NULL, &options, &made), TOLIMAN_E_UNSUPPORTED,
                   "image->windows");
    assert_null(made);
    for (int has_place = 0; has_place < 2; has_place++) { /* a response is fitted in the scene's window */
        toliman_calibration_options response = options;
        response.flags = TOLIMAN_CALIBRATION_DETECTOR;
        assert_refused(toliman_calibration_create(has_place ? placed : plain, &image, FRAMES, NULL, &response, &made),
                       TOLIMAN_E_UNSUPPORTED, "image->windows");
    }
    for (int moves = 1; moves >= 0; moves--) {
        windows[1][1] = COL + moves; /* of a scene without bad pixels, it may */
        assert_ok(toliman_calibration_create(moves ? plain : placed, &image, FRAMES, NULL, &options, &made));
        toliman_calibration_destroy(made);
    }
}

TEST(impossible_windows_are_refused) {
    static double counts[PIXELS];
    frame_of(0, 0, 1, counts);
    Estimators by = estimators_of(placed);
    const toliman_image image = {
        .struct_size = sizeof image, .pixels = counts, .windows = (int64_t[]){0, ((int64_t)1 << 31) + 1}};
    double value;
    assert_invalid(toliman_linear_encode(by.linear, &image, 1, &value, NULL), "image->windows");
    destroy(&by);
}

RUN_TESTS(set_up, tear_down)
