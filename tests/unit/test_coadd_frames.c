/* Tests sums of short frames: places and noise of registered frames against the truth, exact sums in any order, pixels
 * that are left out, verdicts, the ends of sums, and saved sums. */
#include "asked_memory.h"
#include "coadd_frames.h"
#include "crc32.h"

#include <stdlib.h>

enum { FRAMES = 150 };
static const int64_t kStep = 10000000, kStart = INT64_C(1830297600000000000);

static toliman_fit *fit;
static uint16_t frames[FRAMES][COADD_PIXELS];
static double places[FRAMES][2], expected[FRAMES][COADD_PIXELS];

FIXTURE(make_frames) {
    uint64_t state = 9;
    fit = coadd_fit(kCoaddDetector);
    for (int k = 0; k < FRAMES; k++) {
        for (int axis = 0; axis < 2; axis++)
            places[k][axis] = 0.3 * noise(&state);
        coadd_expect(fit, places[k][0], places[k][1], expected[k]);
        coadd_draw(expected[k], &state, frames[k]);
    }
    return 0;
}

FIXTURE(destroy_frames) {
    toliman_fit_destroy(fit);
    return 0;
}

/* Residuals over their standard deviations are normal; as many places near the middle of a step of the model images as
 * elsewhere. */
TEST(frames_are_registered_within_their_noise) {
    toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){0});
    double pull = 0, square = 0, chi_square = 0, largest = 0;
    for (int k = 0; k < FRAMES; k++) {
        const toliman_coadd_outcome outcome = coadd_add(coadd, frames[k], kStart + k * kStep);
        assert_int_equal(outcome.verdict, TOLIMAN_COADD_VERDICT_ADDED);
        assert_int_equal(outcome.left_out, 0);
        const double x = (outcome.x_px - places[k][0]) / outcome.x_sigma_px,
                     y = (outcome.y_px - places[k][1]) / outcome.y_sigma_px;
        pull += x + y;
        square += x * x + y * y;
        chi_square += outcome.chi_square / FRAMES;
        largest = fmax(largest, fmax(fabs(x), fabs(y)));
        assert_close(outcome.flux, 1, 0, 0.02);
    }
    assert_at_most(fabs(pull), 4 * sqrt(2 * FRAMES));
    assert_close(square / (2 * FRAMES), 1, 0, 4 * sqrt(2.0 / (2 * FRAMES)));
    assert_at_most(largest, 5);
    assert_close(chi_square, 1, 0, 0.01);
    toliman_coadd_destroy(coadd);
}

/* Without noise, up to 3.9 px from the predicted place: rounded counts limit the places. */
TEST(frames_are_found_in_the_whole_range) {
    toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){0});
    uint64_t state = 3;
    static double image[COADD_PIXELS];
    static uint16_t counts[COADD_PIXELS];
    for (int k = 0; k < 40; k++) {
        const double x = 3.9 * uniform_signed(&state), y = 3.9 * uniform_signed(&state);
        coadd_expect(fit, x, y, image);
        for (int p = 0; p < COADD_PIXELS; p++)
            counts[p] = (uint16_t)rint(image[p]);
        const toliman_coadd_outcome outcome = coadd_add(coadd, counts, kStart + k * kStep);
        assert_int_equal(outcome.verdict, TOLIMAN_COADD_VERDICT_ADDED);
        assert_close(outcome.x_px, x, 0, 1e-3);
        assert_close(outcome.y_px, y, 0, 1e-3);
    }
    toliman_coadd_destroy(coadd);
}

/* The sum against plain sums of counts, outcomes and times. */
TEST(sums_are_exact) {
    toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){0});
    const double light = coadd_info_of(coadd).photons;
    __extension__ typedef __int128 wide;
    wide photons = 0, weighted = 0;
    long double mean[2] = {0}, second[3] = {0};
    for (int k = 0; k < FRAMES; k++) {
        const int64_t ns = kStart + k * kStep + k * k;
        const toliman_coadd_outcome outcome = coadd_add(coadd, frames[k], ns);
        const int64_t weight = llround(outcome.flux * light);
        photons += weight;
        weighted += (wide)weight * ns;
        mean[0] += (long double)weight * outcome.x_px;
        mean[1] += (long double)weight * outcome.y_px;
        second[0] += (long double)weight * outcome.x_px * outcome.x_px;
        second[1] += (long double)weight * outcome.y_px * outcome.y_px;
        second[2] += (long double)weight * outcome.x_px * outcome.y_px;
    }
    toliman_frame frame;
    const toliman_coadd_sum sum = coadd_take(coadd, &frame);
    assert_int_equal(sum.frames, FRAMES);
    assert_int_equal(sum.mean_ns, (int64_t)((weighted + photons / 2) / photons));
    assert_int_equal(frame.camera_ns, sum.mean_ns);
    assert_int_equal(sum.first_ns, kStart - 2500000);
    assert_int_equal(sum.last_ns, kStart + (FRAMES - 1) * kStep + (FRAMES - 1) * (FRAMES - 1) + 2500000);
    const long double all = (long double)photons;
    assert_close(sum.photons, (double)all, 0, 0);
    assert_close(sum.x_px, (double)(mean[0] / all), 0, 1e-11);
    assert_close(sum.y_px, (double)(mean[1] / all), 0, 1e-11);
    const toliman_spread *const spread = frame.spread;
    assert_close(spread->frames, FRAMES, 0, 0);
    assert_close(spread->xx_px2 + sum.registration_xx_px2, (double)(second[0] / all - mean[0] * mean[0] / all / all), 0,
                 1e-10);
    assert_close(spread->yy_px2 + sum.registration_yy_px2, (double)(second[1] / all - mean[1] * mean[1] / all / all), 0,
                 1e-10);
    assert_close(spread->xy_px2 + sum.registration_xy_px2, (double)(second[2] / all - mean[0] * mean[1] / all / all), 0,
                 1e-10);
    const uint32_t *const counts = frame.pixels;
    for (int p = 0; p < COADD_PIXELS; p++) {
        uint32_t plain = 0;
        for (int k = 0; k < FRAMES; k++)
            plain += frames[k][p];
        assert_int_equal(counts[p], plain);
        assert_int_equal(sum.left_out[p], 0);
    }
    assert_int_equal(frame.interval_count, 1);
    assert_close(frame.exposure_s / 2 + (double)(frame.camera_ns - sum.last_ns) * 1e-9, 0, 0, 0.02);
    toliman_coadd_destroy(coadd);
}

static uint8_t *saved(const toliman_coadd *coadd, size_t *size) {
    assert_asks(toliman_coadd_save(coadd, NULL, 0, size));
    uint8_t *const bytes = malloc(*size);
    assert_ok(toliman_coadd_save(coadd, bytes, *size, size));
    return bytes;
}

/* promise: sums-ignore-the-order */
TEST(frames_in_any_order_give_the_same_bits) {
    uint8_t *bytes[2];
    size_t size[2];
    for (int order = 0; order < 2; order++) {
        toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){.pause_s = 0.02});
        for (int i = 0; i < FRAMES; i++) {
            const int k = order == 0 ? i : i * 37 % FRAMES;
            static uint16_t counts[COADD_PIXELS];
            memcpy(counts, frames[k], sizeof counts);
            for (int hit = 0; hit < k % 4; hit++)
                counts[(k * 131 + hit * 977) % COADD_PIXELS] = hit == 2 ? 4095 : 900;
            coadd_add(coadd, counts, kStart + (k + k / 50 * 100) * kStep);
        }
        assert_int_equal(coadd_info_of(coadd).frames, FRAMES);
        bytes[order] = saved(coadd, &size[order]);
        toliman_coadd_destroy(coadd);
    }
    assert_int_equal(size[0], size[1]);
    /* the first and last places of order-dependent motion follow the names and the sum of times */
    const size_t motion = 4 + 4 + 8 + 4 + 4 + 8 + 2 * 65 + 16;
    memset(bytes[0] + motion, 0, 32), memset(bytes[1] + motion, 0, 32);
    assert_memory_equal(bytes[0], bytes[1], size[0] - 4);
    free(bytes[0]), free(bytes[1]);
}

/* Cosmic rays and saturated pixels are left out, counted, and filled with what the model expects in their frame. */
TEST(pixels_are_left_out_and_filled) {
    toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){0});
    static double filled[COADD_PIXELS];
    static uint32_t plain[COADD_PIXELS], left_out[COADD_PIXELS];
    memset(filled, 0, sizeof filled), memset(plain, 0, sizeof plain), memset(left_out, 0, sizeof left_out);
    int64_t rays = 0, full = 0;
    uint64_t state = 21;
    for (int k = 0; k < FRAMES; k++) {
        static uint16_t counts[COADD_PIXELS];
        memcpy(counts, frames[k], sizeof counts);
        int hits[3], count = 0;
        for (int i = 0; i < k % 4; i++) {
            const int p = (int)(COADD_PIXELS * uniform(&state));
            const int is_full = i == 2;
            counts[p] = is_full ? 4095 : (uint16_t)(counts[p] + 10 + 15 * sqrt(expected[k][p]));
            rays += !is_full, full += is_full;
            hits[count++] = p;
        }
        for (int p = 0; p < COADD_PIXELS; p++) {
            int hit = 0;
            for (int i = 0; i < count; i++)
                hit |= hits[i] == p;
            plain[p] += hit ? 0 : counts[p];
            left_out[p] += (uint32_t)hit;
            filled[p] += hit ? expected[k][p] : 0;
        }
        const toliman_coadd_outcome outcome = coadd_add(coadd, counts, kStart + k * kStep);
        assert_int_equal(outcome.verdict, TOLIMAN_COADD_VERDICT_ADDED);
        assert_int_equal(outcome.left_out, count);
        assert_close(outcome.x_px, places[k][0], 0, 6 * outcome.x_sigma_px);
        assert_close(outcome.chi_square, 1, 0, 0.12);
    }
    toliman_frame frame;
    const toliman_coadd_sum sum = coadd_take(coadd, &frame);
    const uint32_t *const counts = frame.pixels;
    assert_int_equal(sum.cosmic_rays, rays);
    assert_int_equal(sum.saturated, full);
    for (int p = 0; p < COADD_PIXELS; p++) {
        assert_int_equal(sum.left_out[p], left_out[p]);
        /* the place of a frame is known to 0.004 px, a fringe of 4.7 px then to 1 % */
        assert_close(counts[p], plain[p] + filled[p], 0, 0.5 + 0.03 * (filled[p] - COADD_BIAS * left_out[p] + 10));
    }
    toliman_coadd_destroy(coadd);
}

TEST(frames_that_do_not_fit_have_a_verdict) {
    toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){.range_px = 2});
    static double image[COADD_PIXELS];
    static uint16_t counts[COADD_PIXELS];
    uint64_t state = 4;
    memcpy(counts, frames[0], sizeof counts);
    memset(counts + COADD_PIXELS / 2, 0, sizeof counts / 2);
    assert_int_equal(coadd_add(coadd, counts, 0).verdict, TOLIMAN_COADD_VERDICT_LOST);
    for (int p = 0; p < COADD_PIXELS; p++)
        counts[p] = COADD_BIAS;
    assert_int_equal(coadd_add(coadd, counts, 0).verdict, TOLIMAN_COADD_VERDICT_FAINT);
    coadd_expect(fit, 3.2, 0.4, image);
    coadd_draw(image, &state, counts);
    assert_int_equal(coadd_add(coadd, counts, 0).verdict, TOLIMAN_COADD_VERDICT_OUTSIDE);
    for (int p = 0; p < COADD_PIXELS; p++) /* as bright as the frame, but no stars */
        counts[p] = (uint16_t)(COADD_BIAS + 60 + 8 * noise(&state));
    const int32_t verdict = coadd_add(coadd, counts, 0).verdict;
    assert_true(verdict != TOLIMAN_COADD_VERDICT_ADDED);
    for (int p = 0; p < COADD_PIXELS; p++) /* a ghost over half the frame */
        counts[p] = (uint16_t)(frames[0][p] + (p % COADD_SIDE > 32 ? 12 : 0));
    assert_int_equal(coadd_add(coadd, counts, 0).verdict, TOLIMAN_COADD_VERDICT_MISFIT);
    assert_int_equal(coadd_info_of(coadd).frames, 0);
    assert_int_equal(coadd_info_of(coadd).rejected, 5);
    toliman_frame frame = {.struct_size = sizeof frame};
    toliman_coadd_sum sum = {.struct_size = sizeof sum};
    assert_refused(toliman_coadd_take(coadd, &frame, &sum), TOLIMAN_E_STATE, "coadd");
    coadd_add(coadd, frames[0], 0);
    sum = coadd_take(coadd, &frame);
    assert_true(sum.frames == 1 && sum.lost == 1 && sum.faint == 1 && sum.outside == 1 && sum.misfit >= 1 &&
                sum.misfit + sum.not_found == 2);
    assert_int_equal(coadd_info_of(coadd).rejected, 0);
    toliman_coadd_destroy(coadd);
}

/* Adds frame k of the table at this time, in a session; returns the reason for NEXT. */
static int32_t end_at(toliman_coadd *coadd, int64_t ns, const char *session) {
    toliman_frame frame = coadd_frame(frames[1], ns);
    frame.session = session;
    toliman_coadd_outcome outcome = {.struct_size = sizeof outcome};
    assert_ok(toliman_coadd_add(coadd, &frame, &outcome));
    assert_true((outcome.verdict == TOLIMAN_COADD_VERDICT_NEXT) == (outcome.reason != TOLIMAN_COADD_REASON_NONE));
    return outcome.reason;
}

TEST(sums_end_at_their_limits) {
    const int64_t second = 1000000000;
    toliman_coadd *coadd = coadd_of(fit, (toliman_coadd_options){.duration_s = 60, .flags = TOLIMAN_COADD_ALIGNED});
    assert_int_equal(end_at(coadd, 59 * second, "a"), TOLIMAN_COADD_REASON_NONE);
    assert_int_equal(end_at(coadd, 0, "a"), TOLIMAN_COADD_REASON_NONE);
    assert_int_equal(end_at(coadd, 60 * second, "a"), TOLIMAN_COADD_REASON_TIME);
    assert_int_equal(end_at(coadd, -1, "a"), TOLIMAN_COADD_REASON_TIME);
    assert_int_equal(end_at(coadd, 30 * second, "b"), TOLIMAN_COADD_REASON_SOURCE);
    assert_int_equal(coadd_info_of(coadd).frames, 2);
    toliman_frame frame;
    assert_int_equal(coadd_take(coadd, &frame).frames, 2);
    assert_true(frame.frame_id == 0 && coadd_info_of(coadd).number == 1);
    assert_int_equal(end_at(coadd, 60 * second, "b"), TOLIMAN_COADD_REASON_NONE);
    coadd_take(coadd, &frame);
    assert_int_equal(frame.frame_id, 1);
    assert_string_equal(frame.session, "b");
    toliman_coadd_destroy(coadd);
    coadd = coadd_of(fit, (toliman_coadd_options){.duration_s = 60});
    end_at(coadd, 59 * second, "a");
    assert_int_equal(end_at(coadd, 118 * second, "a"), TOLIMAN_COADD_REASON_NONE);
    assert_int_equal(end_at(coadd, 119 * second, "a"), TOLIMAN_COADD_REASON_TIME);
    toliman_coadd_destroy(coadd);
    coadd = coadd_of(fit, (toliman_coadd_options){.gap_s = 5});
    end_at(coadd, 0, "a");
    assert_int_equal(end_at(coadd, 5 * second, "a"), TOLIMAN_COADD_REASON_NONE);
    assert_int_equal(end_at(coadd, 11 * second, "a"), TOLIMAN_COADD_REASON_GAP);
    toliman_coadd_destroy(coadd);
    coadd = coadd_of(fit, (toliman_coadd_options){0});
    for (int i = 0; i < 64; i++)
        assert_int_equal(end_at(coadd, i * 20 * second, "a"), TOLIMAN_COADD_REASON_NONE);
    assert_int_equal(end_at(coadd, 1280 * second, "a"), TOLIMAN_COADD_REASON_FULL);
    assert_int_equal(end_at(coadd, 1265 * second, "a"), TOLIMAN_COADD_REASON_NONE); /* joins the last interval */
    coadd_take(coadd, &frame);
    assert_int_equal(frame.interval_count, 64);
    for (size_t i = 0; i < 64; i++)
        assert_close(frame.intervals[2 * i + 1] - frame.intervals[2 * i], i < 63 ? 0.005 : 5.005, 0, 1e-6);
    toliman_coadd_destroy(coadd);
}

TEST(sums_end_when_the_stars_have_moved) {
    toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){.motion_px = 0.4});
    static double image[COADD_PIXELS];
    static uint16_t counts[COADD_PIXELS];
    uint64_t state = 12;
    int k = 0, reason = TOLIMAN_COADD_REASON_NONE;
    for (; k < 600 && reason == TOLIMAN_COADD_REASON_NONE; k++) {
        coadd_expect(fit, k < 200 ? 0.2 : -0.4, 0, image);
        coadd_draw(image, &state, counts);
        reason = coadd_add(coadd, counts, k * kStep).reason;
    }
    assert_int_equal(reason, TOLIMAN_COADD_REASON_MOTION);
    assert_true(k > 300 && k < 400); /* the running mean of 128 frames has moved by 0.4 of 0.6 px after 141 */
    toliman_coadd_destroy(coadd);
}

TEST(saved_sums_continue) {
    toliman_coadd *const whole = coadd_of(fit, (toliman_coadd_options){0}), *const second = coadd_of(
                                                                                fit,
                                                                                (toliman_coadd_options){.gap_s = 3});
    size_t sizes[3];
    uint8_t *half = NULL;
    for (int k = 0; k < FRAMES; k++) {
        coadd_add(whole, frames[k], kStart + k * kStep);
        if (k == FRAMES / 2 - 1)
            half = saved(whole, &sizes[0]);
    }
    assert_ok(toliman_coadd_load(second, half, sizes[0]));
    for (int k = FRAMES / 2; k < FRAMES; k++)
        coadd_add(second, frames[k], kStart + k * kStep);
    uint8_t *const one = saved(whole, &sizes[1]), *const other = saved(second, &sizes[2]);
    assert_memory_equal(one, other, sizes[1]);
    for (size_t byte = 0; byte < sizes[0]; byte += byte < 200 ? 1 : 997) {
        half[byte] ^= 0x10;
        const toliman_status status = toliman_coadd_load(second, half, sizes[0]);
        assert_true(status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_MISMATCH);
        half[byte] ^= 0x10;
    }
    for (size_t size = 0; size < sizes[0]; size += 1 + size / 3)
        assert_int_equal(toliman_coadd_load(second, half, size), TOLIMAN_E_FORMAT);
    size_t size;
    uint8_t *const unchanged = saved(second, &size);
    assert_memory_equal(one, unchanged, size);
    toliman_coadd *const narrow = coadd_of(fit, (toliman_coadd_options){.range_px = 3});
    assert_int_equal(toliman_coadd_load(narrow, half, sizes[0]), TOLIMAN_E_MISMATCH);
    free(half), free(one), free(other), free(unchanged);
    toliman_coadd_destroy(whole), toliman_coadd_destroy(second), toliman_coadd_destroy(narrow);
}

/* Numbers of a saved sum that no sum has, with the right checksum. promise: parsers-are-safe */
TEST(impossible_sums_are_refused) {
    toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){0});
    size_t size, after;
    for (int k = 0; k < FRAMES; k++)
        coadd_add(coadd, frames[k], kStart + k * kStep);
    uint8_t *const good = saved(coadd, &size);
    const size_t totals = 32, place = totals + 146, counts = place + 32,
                 intervals = size - 4 - 16 * (size_t)COADD_PIXELS - 64 * 16;
    const struct {
        size_t at;
        uint64_t bits;
    } cases[] = {
        {24, UINT64_MAX},            /* number of the sum: -1 */
        {place, 0x7ff8000000000000}, /* a place: NaN */
        {place + 24, 0x4202a05f20000000},
        {counts + 16, UINT64_MAX},     /* frames */
        {counts + 24, 0},              /* photons */
        {counts + 32, UINT64_MAX},     /* dropped */
        {counts + 40, UINT64_MAX - 8}, /* cosmic rays */
        {counts + 56, UINT64_MAX},     /* of a verdict */
        {counts + 72, UINT64_MAX >> 1},
        {intervals + 8, 0},           /* end before its start */
        {intervals + 63 * 16 + 8, 1}, /* beyond their number */
        {intervals - 8, 65},          /* their number */
        {intervals - 8, 2},           /* more than are there */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        uint8_t *const bytes = malloc(size);
        memcpy(bytes, good, size);
        memcpy(bytes + cases[i].at, &cases[i].bits, 8);
        const uint32_t crc = crc32_of(bytes, size - 4);
        memcpy(bytes + size - 4, &crc, 4);
        if (toliman_coadd_load(coadd, bytes, size) != TOLIMAN_E_FORMAT)
            fail_msg("case %zu is not refused", i);
        free(bytes);
    }
    uint8_t *const unchanged = saved(coadd, &after);
    assert_memory_equal(good, unchanged, size);
    free(good), free(unchanged);
    toliman_coadd_destroy(coadd);
}

TEST(adding_allocates_nothing) {
    toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){0});
    static uint32_t wide[COADD_PIXELS];
    toliman_frame frame = coadd_frame(frames[0], kStart), taken;
    toliman_coadd_outcome outcome = {.struct_size = sizeof outcome};
    for (int p = 0; p < COADD_PIXELS; p++)
        wide[p] = frames[0][p];
    asked = 0;
    for (int k = 0; k < 20; k++) {
        frame.pixel = k % 2 == 0 ? TOLIMAN_PIXEL_U16 : TOLIMAN_PIXEL_U32;
        frame.pixels = k % 2 == 0 ? (const void *)frames[0] : wide;
        assert_ok(toliman_coadd_add(coadd, &frame, &outcome));
        assert_int_equal(outcome.verdict, TOLIMAN_COADD_VERDICT_ADDED);
        if (k == 9)
            coadd_take(coadd, &taken);
    }
    coadd_take(coadd, &taken);
    assert_int_equal(asked, 0);
    const uint32_t *const counts = taken.pixels;
    for (int p = 0; p < COADD_PIXELS; p++)
        assert_int_equal(counts[p], 10u * frames[0][p]);
    toliman_coadd_destroy(coadd);
}

TEST(mistakes_are_refused) {
    static const struct {
        toliman_coadd_options options;
        const char *field;
    } kOptions[] = {{{.flags = 2}, "options->flags"},
                    {{.range_px = 8}, "options->range_px"},
                    {{.duration_s = -1}, "options->duration_s"},
                    {{.flags = TOLIMAN_COADD_ALIGNED}, "options->duration_s"},
                    {{.pause_s = -1}, "options->pause_s"}};
    for (size_t i = 0; i < sizeof kOptions / sizeof *kOptions; i++) {
        toliman_coadd_options options = kOptions[i].options;
        options.struct_size = sizeof options;
        toliman_coadd *made = NULL;
        assert_invalid(toliman_coadd_create(fit, NULL, &options, &made), kOptions[i].field);
        assert_null(made);
    }
    toliman_coadd *const coadd = coadd_of(fit, (toliman_coadd_options){0});
    const double interval[2] = {0, 0.001};
    const toliman_spread spread = {.struct_size = sizeof spread};
    toliman_coadd_outcome outcome = {.struct_size = sizeof outcome};
    toliman_frame frame;
#define REFUSED(member, value)                                                                                         \
    frame = coadd_frame(frames[0], 0), frame.member = value;                                                           \
    assert_invalid(toliman_coadd_add(coadd, &frame, &outcome), "frame->" #member)
    REFUSED(rows, 63);
    REFUSED(cols, 65);
    REFUSED(stride, 63);
    REFUSED(pixel, TOLIMAN_PIXEL_F32);
    REFUSED(pixel, 0);
    REFUSED(pixels, NULL);
    REFUSED(pixels, (const char *)frames[0] + 1);
    REFUSED(session, NULL);
    REFUSED(session, "a b");
    REFUSED(roi, "");
    REFUSED(dropped, -1);
    REFUSED(exposure_s, -1);
    REFUSED(camera_ns, INT64_MIN);
    REFUSED(spread, &spread);
    frame = coadd_frame(frames[0], 0), frame.intervals = interval, frame.interval_count = 1;
    assert_invalid(toliman_coadd_add(coadd, &frame, &outcome), "frame->interval_count");
    assert_int_equal(coadd_info_of(coadd).frames + coadd_info_of(coadd).rejected, 0);
    frame = coadd_frame(frames[0], 0), frame.dropped = 72000; /* 12 minutes at 100 Hz */
    assert_ok(toliman_coadd_add(coadd, &frame, &outcome));
    toliman_coadd_destroy(coadd);
}

RUN_TESTS(make_frames, destroy_frames)
