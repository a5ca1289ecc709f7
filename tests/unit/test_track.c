/* Tests the tracker in memory: verdicts and reasons, counts, pixels of all types, limits, memory, threads. */
#include <malloc.h>
#include <sys/resource.h>

#include "asked_memory.h"
#include "samples.h"
#include "track_frames.h"

static int32_t reason_of(toliman_track *track, const toliman_frame *frame, int64_t row, int64_t col, double pixel) {
    const toliman_track_outcome outcome = push_one(track, frame);
    assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_REJECTED);
    assert_int_equal(outcome.row, row);
    assert_int_equal(outcome.col, col);
    assert_true(outcome.pixel == pixel);
    return outcome.reason;
}

/* promise: conflicting-frames-are-quarantined */
TEST(every_verdict_is_counted) {
    const toliman_track_options options = small_options(NULL);
    toliman_track *track = make_track(&options);
    small_frame frame;
    make_frame(&frame, 1);
    const toliman_track_outcome first = push_one(track, &frame.frame);
    assert_int_equal(first.verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    assert_true(first.value == value_of_frame(&frame) && first.tai_ns == frame.frame.camera_ns);
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_DUPLICATE);
    assert_int_equal(push_number(track, 7), TOLIMAN_TRACK_VERDICT_OUTLIER);
    assert_int_equal(push_number(track, 7), TOLIMAN_TRACK_VERDICT_DUPLICATE);
    /* The same id in another session is another frame. */
    frame.frame.roi = "corner";
    frame.frame.dropped = 3;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    frame.frame.session = "pass-2";
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    /* A copy with another payload quarantines the frame permanently; so does another time. */
    frame.pixels[5]++;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
    frame.pixels[5]--;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
    make_frame(&frame, 2);
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    frame.frame.camera_ns++;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
    /* A damaged copy does not affect a valid one. */
    make_frame(&frame, 1);
    frame.pixels[9] = 4096;
    assert_int_equal(reason_of(track, &frame.frame, 1, 1, 4096), TOLIMAN_TRACK_REASON_OVER_RANGE);

    const toliman_track_info info = info_of(track);
    assert_int_equal(info.received, 11);
    assert_int_equal(info.accepted, 2);
    assert_int_equal(info.outlier, 1);
    assert_int_equal(info.quarantined, 2);
    assert_int_equal(info.repeated, 5);
    assert_int_equal(info.rejected, 1);
    assert_int_equal(info.rejected_for[TOLIMAN_TRACK_REASON_OVER_RANGE - TOLIMAN_TRACK_REASON_NONE], 1);
    assert_int_equal(info.rejected_for[TOLIMAN_TRACK_REASON_ZERO_RUN - TOLIMAN_TRACK_REASON_NONE], 0);
    assert_int_equal(info.sessions, 3);
    assert_int_equal(info.expected, 7 + 1 + 1);
    assert_int_equal(info.missing, 4);
    assert_int_equal(info.dropped, 3);
    assert_int_equal(count_of(period_of(track)), 2);
    toliman_track_destroy(track), toliman_track_destroy(NULL);
}

TEST(every_reason_names_its_pixel) {
    toliman_track_options options = small_options(NULL);
    toliman_track *track = make_track(&options);
    small_frame frame;
    make_frame(&frame, 1);
    frame.frame.rows = 7;
    assert_int_equal(reason_of(track, &frame.frame, 7, 8, 0), TOLIMAN_TRACK_REASON_SHAPE);
    make_frame(&frame, 1);
    memset(frame.pixels + 11, 0, PIXELS - 2); /* bytes: one pixel less than the smallest zero run */
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    make_frame(&frame, 2);
    memset(frame.pixels + 11, 0, PIXELS);
    assert_int_equal(reason_of(track, &frame.frame, (11 + 31) / 8, (11 + 31) % 8, 0), TOLIMAN_TRACK_REASON_ZERO_RUN);
    make_frame(&frame, 3);
    frame.frame.camera_ns = INT64_MAX; /* 10^5 days are not too far, 2^50 cycles are */
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    toliman_track_destroy(track);

    options.frames.bit_depth = 0;
    options.flags = TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
    options.grid.f0 = 1e15;
    options.grid.nf = 1;
    track = make_track(&options);
    double image[PIXELS] = {0};
    toliman_frame wide = frame.frame;
    wide.pixel = TOLIMAN_PIXEL_F64;
    wide.pixels = image;
    wide.camera_ns = DAY_NS * 2;
    assert_int_equal(reason_of(track, &wide, 0, 0, 0), TOLIMAN_TRACK_REASON_CLOCK);
    wide.camera_ns = 0;
    image[63] = INFINITY;
    assert_int_equal(reason_of(track, &wide, 7, 7, INFINITY), TOLIMAN_TRACK_REASON_NOT_FINITE);
    image[63] = 0;
    image[62] = -INFINITY;
    assert_int_equal(reason_of(track, &wide, 7, 6, -INFINITY), TOLIMAN_TRACK_REASON_NOT_FINITE);
    image[62] = 1e308;
    image[60] = 1e308;
    assert_int_equal(reason_of(track, &wide, 0, 0, INFINITY), TOLIMAN_TRACK_REASON_ESTIMATE);
    toliman_track_destroy(track);
    assert_string_equal(toliman_constant_name(TOLIMAN_TRACK_REASON_ZERO_RUN), "zero run");
    assert_string_equal(toliman_constant_name(TOLIMAN_TRACK_REASON_ESTIMATE), "estimate");
    assert_string_equal(toliman_constant_name(TOLIMAN_TRACK_REASON_NO_INTERVALS + 1), "?");
    assert_string_equal(toliman_constant_name(-1), "?");
    assert_string_equal(toliman_constant_name(TOLIMAN_TRACK_VERDICT_ACCEPTED), "accepted");
    assert_string_equal(toliman_constant_name(TOLIMAN_TRACK_VERDICT_MERGED), "merged");
    assert_string_equal(toliman_constant_name(TOLIMAN_TRACK_VERDICT_UNREDUCED), "unreduced");
    assert_string_equal(toliman_constant_name(TOLIMAN_TRACK_VERDICT_MISFIT), "misfit");
    assert_string_equal(toliman_constant_name(TOLIMAN_TRACK_VERDICT_MISFIT + 1), "?");
    assert_string_equal(toliman_constant_name(-1), "?");
}

static int32_t refuse(const toliman_estimate_input *input, toliman_estimate *made, void *data) {
    (void)input;
    made->values[0] = 1;
    return *(int32_t *)data;
}

/* promise: bad-estimates-reject-frames */
TEST(estimators_may_refuse) {
    int32_t answer = 1;
    toliman_track_options options = small_options(NULL);
    options.estimator.estimate = refuse;
    options.estimator.estimate_data = &answer;
    toliman_track *track = make_track(&options);
    small_frame frame;
    make_frame(&frame, 1);
    assert_int_equal(push_one(track, &frame.frame).reason, TOLIMAN_TRACK_REASON_ESTIMATE);
    answer = 0;
    const toliman_track_outcome outcome = push_one(track, &frame.frame);
    assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    assert_true(outcome.value == 1);
    toliman_track_destroy(track);
    /* A value equal to the limit is within it. */
    for (int beyond = 0; beyond < 2; beyond++) {
        options.limits.value = beyond ? nextafter(1, 0) : 1;
        track = make_track(&options);
        assert_int_equal(push_one(track, &frame.frame).verdict,
                         beyond ? TOLIMAN_TRACK_VERDICT_OUTLIER : TOLIMAN_TRACK_VERDICT_ACCEPTED);
        toliman_track_destroy(track);
    }
}

/* The last arguments of the estimator. */
static double seen_image[128];
static size_t seen_rows, seen_cols;

static int32_t record_input(const toliman_estimate_input *input, toliman_estimate *made, void *unused) {
    (void)unused;
    memcpy(seen_image, input->image, input->rows * input->cols * sizeof *seen_image);
    seen_rows = input->rows;
    seen_cols = input->cols;
    made->values[0] = 0;
    return 0;
}

/* The pixel type of the same numbers in the machine's byte order. */
static int32_t native_of(int32_t kind) {
    const int32_t natives[] = {TOLIMAN_PIXEL_U16, TOLIMAN_PIXEL_U32, TOLIMAN_PIXEL_I16, TOLIMAN_PIXEL_F32};
    return kind < TOLIMAN_PIXEL_U16BE ? kind : natives[kind - TOLIMAN_PIXEL_U16BE];
}

static int width_of(int32_t kind) {
    return kind == TOLIMAN_PIXEL_U16BE || kind == TOLIMAN_PIXEL_I16BE ? 2 : 4;
}

static void reverse_bytes(unsigned char *pixel, int width) {
    for (int i = 0; i < width / 2; i++) {
        const unsigned char byte = pixel[i];
        pixel[i] = pixel[width - 1 - i];
        pixel[width - 1 - i] = byte;
    }
}

/* A window of frames [10][stride 13] of every pixel type, cropped and binned, against plain loops. */
TEST(pixels_of_all_kinds_are_cropped_and_binned) {
    enum { ROWS = 10, COLS = 11, STRIDE = 13 };
    static unsigned char bytes[ROWS * STRIDE * 8];
    for (int32_t kind = TOLIMAN_PIXEL_U8; kind <= TOLIMAN_PIXEL_F32BE; kind++)
        for (int bin = 1; bin <= 3; bin++) {
            double expected[ROWS][COLS];
            for (int r = 0; r < ROWS; r++)
                for (int c = 0; c < STRIDE; c++) {
                    const int at = r * STRIDE + c, number = 1 + r * 17 + c * 5;
                    const int32_t native = native_of(kind);
                    const int negative = native == TOLIMAN_PIXEL_I16 || native >= TOLIMAN_PIXEL_I32;
                    const double value = c >= COLS ? 0 : (negative && c % 3 == 0) ? -number : number;
                    switch (native) {
                    case TOLIMAN_PIXEL_U8:
                        ((uint8_t *)bytes)[at] = (uint8_t)value;
                        break;
                    case TOLIMAN_PIXEL_U16:
                        ((uint16_t *)bytes)[at] = (uint16_t)value;
                        break;
                    case TOLIMAN_PIXEL_U32:
                        ((uint32_t *)bytes)[at] = (uint32_t)value;
                        break;
                    case TOLIMAN_PIXEL_I16:
                        ((int16_t *)bytes)[at] = (int16_t)value;
                        break;
                    case TOLIMAN_PIXEL_I32:
                        ((int32_t *)bytes)[at] = (int32_t)value;
                        break;
                    case TOLIMAN_PIXEL_F32:
                        ((float *)bytes)[at] = (float)(value / 2);
                        break;
                    default:
                        ((double *)bytes)[at] = value / 2;
                        break;
                    }
                    if (kind != native)
                        reverse_bytes(bytes + at * width_of(kind), width_of(kind));
                    if (c < COLS)
                        expected[r][c] = native >= TOLIMAN_PIXEL_F32 ? value / 2 : value;
                }
            toliman_track_options options = small_options(NULL);
            options.estimator.estimate = record_input;
            options.frames.rows = ROWS;
            options.frames.cols = COLS;
            options.frames.crop_row = 1;
            options.frames.crop_col = 2;
            options.frames.bin = bin;
            toliman_track *track = make_track(&options);
            const toliman_frame frame = {.struct_size = sizeof frame,
                                         .pixel = kind,
                                         .session = "s",
                                         .roi = "r",
                                         .frame_id = 1,
                                         .pixels = bytes,
                                         .rows = ROWS,
                                         .cols = COLS,
                                         .stride = STRIDE};
            assert_int_equal(push_one(track, &frame).verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
            assert_int_equal(seen_rows, (ROWS - 1) / bin);
            assert_int_equal(seen_cols, (COLS - 2) / bin);
            for (size_t r = 0; r < seen_rows; r++)
                for (size_t c = 0; c < seen_cols; c++) {
                    double sum = 0;
                    for (int i = 0; i < bin * bin; i++)
                        sum += expected[1 + (int)r * bin + i / bin][2 + (int)c * bin + i % bin];
                    assert_true(seen_image[r * seen_cols + c] == sum);
                }
            toliman_track_destroy(track);
        }
}

/* The largest pixel below 2^depth is valid, 2^depth is not, in every pixel type. */
TEST(bit_depth_limit_is_exact) {
    static double doubles[PIXELS];
    static float floats[PIXELS];
    static uint32_t words[PIXELS];
    for (uint32_t depth = 1; depth <= 32; depth++) {
        toliman_track_options options = small_options(NULL);
        options.frames.bit_depth = depth;
        options.limits.value = 1e10;
        toliman_track *track = make_track(&options);
        const double end = ldexp(1, (int)depth);
        small_frame frame;
        int64_t id = 0;
        for (int beyond = 0; beyond < 2; beyond++) {
            const int32_t expected = beyond ? TOLIMAN_TRACK_VERDICT_REJECTED : TOLIMAN_TRACK_VERDICT_ACCEPTED;
            for (int i = 0; i < PIXELS; i++) {
                doubles[i] = beyond && i == 9 ? end : nextafter(end, 0);
                floats[i] = beyond && i == 9 ? (float)end : nextafterf((float)end, 0);
                words[i] = beyond && i == 9 && depth < 32 ? (uint32_t)end : (uint32_t)(end - 1);
            }
            const void *const pixels[] = {doubles, floats, words};
            const int32_t kinds[] = {TOLIMAN_PIXEL_F64, TOLIMAN_PIXEL_F32, TOLIMAN_PIXEL_U32};
            for (int kind = 0; kind < (beyond && depth == 32 ? 2 : 3); kind++) {
                make_frame(&frame, ++id);
                frame.frame.pixel = kinds[kind];
                frame.frame.pixels = pixels[kind];
                const toliman_track_outcome outcome = push_one(track, &frame.frame);
                assert_int_equal(outcome.verdict, expected);
                assert_true(!beyond || (outcome.reason == TOLIMAN_TRACK_REASON_OVER_RANGE && outcome.col == 1));
            }
        }
        toliman_track_destroy(track);
    }
}

/* A frame of lower weight; its sigma is part of the frame's content. */
TEST(frames_can_have_their_own_sigma) {
    const toliman_track_options options = small_options(NULL);
    toliman_track *track = make_track(&options);
    toliman_period *clean = clean_period(&options);
    small_frame frame;
    for (int64_t id = 100; id < 130; id++) {
        make_frame(&frame, id);
        frame.frame.sigma = id % 3 == 0 ? 0 : SIGMA * (double)(1 + id % 32);
        const toliman_track_outcome outcome = push_one(track, &frame.frame);
        if (outcome.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED)
            assert_ok(push_ns(clean, frame.frame.camera_ns, outcome.value, id % 3 == 0 ? SIGMA : frame.frame.sigma));
        assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_DUPLICATE);
    }
    assert_same_periods(period_of(track), clean);
    frame.frame.sigma = SIGMA;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
    toliman_period_destroy(clean), toliman_track_destroy(track);
}

/* The fit must equal that of a periodogram with the accepted values; the order of arrival changes no bit. */
TEST(fit_includes_accepted_frames) {
    enum { N = 300 };
    const toliman_track_options options = small_options(NULL);
    double t[N], y[N];
    size_t n = 0;
    for (int64_t id = 1; id <= N; id++) {
        small_frame frame;
        make_frame(&frame, id);
        const double value = value_of_frame(&frame);
        if (fabs(value) > VALUE_LIMIT || id == 77)
            continue;
        t[n] = (double)frame.frame.camera_ns / (double)DAY_NS;
        y[n++] = value;
    }
    toliman_period_peak expected = {.struct_size = sizeof expected}, fits[3];
    for (int order = 0; order < 3; order++) {
        toliman_track *track = make_track(&options);
        fits[order].struct_size = sizeof *fits;
        assert_refused(toliman_track_query_fit(track, &fits[order]), TOLIMAN_E_STATE, "");
        for (int64_t i = 0; i < N; i++)
            push_number(track, order == 0 ? i + 1 : order == 1 ? N - i : i * 77 % N + 1);
        small_frame frame;
        make_frame(&frame, 77);
        frame.pixels[0]++;
        assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_VERDICT_QUARANTINED);
        assert_ok(toliman_track_query_fit(track, &fits[order]));
        if (order == 0)
            assert_ok(toliman_period_query_fit(period_of(track), t, y, NULL, NULL, n, &expected));
        toliman_track_destroy(track);
        assert_memory_equal(&fits[order], &fits[0], sizeof *fits);
    }
    const double *const a = &fits[0].frequency, *const b = &expected.frequency;
    for (size_t i = 0; a + i <= &fits[0].period_error; i++)
        assert_close(a[i], b[i], 1e-9, 1e-12);
    assert_true(fits[0].period_error > 0 && fits[0].amplitude > 0);
    assert_invalid(toliman_track_query_fit(NULL, &expected), "track");
}

/* The gaps between rows are not part of a frame. */
TEST(gaps_between_rows_are_ignored) {
    const toliman_track_options options = small_options(NULL);
    toliman_track *track = make_track(&options);
    small_frame packed;
    make_frame(&packed, 1);
    assert_int_equal(push_one(track, &packed.frame).verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
    uint16_t loose[SIDE * 11];
    memset(loose, 0xff, sizeof loose);
    for (int r = 0; r < SIDE; r++)
        memcpy(loose + r * 11, packed.pixels + r * SIDE, SIDE * sizeof *loose);
    packed.frame.pixels = loose;
    packed.frame.stride = 11;
    assert_int_equal(push_one(track, &packed.frame).verdict, TOLIMAN_TRACK_VERDICT_DUPLICATE);
    toliman_track_destroy(track);
}

TEST(impossible_frames_and_options_are_refused) {
    static const char *const bad[] = {
        "",    ".hidden", "../up",       "a/b",
        "a b", "a\n",     "caf\xc3\xa9", "0123456789012345678901234567890123456789012345678901234567890123456789"};
    toliman_track_options options = small_options(NULL);
    toliman_track *track = make_track(&options);
    small_frame frames[2];
    toliman_track_outcome outcomes[2] = {{.struct_size = sizeof *outcomes}};
    toliman_frame both[2];
    size_t done = 9;
    make_frame(&frames[0], 1);
    make_frame(&frames[1], 2);
#define REFUSED(member, wrong)                                                                                         \
    do {                                                                                                               \
        both[0] = frames[0].frame;                                                                                     \
        both[1] = frames[1].frame;                                                                                     \
        both[1].member = (wrong);                                                                                      \
        assert_invalid(toliman_track_push(track, both, 2, outcomes, &done), "frames[1]." #member);                     \
        assert_int_equal(done, 0);                                                                                     \
    } while (0)
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        REFUSED(session, bad[i]);
        REFUSED(roi, bad[i]);
    }
    REFUSED(session, NULL);
    REFUSED(pixels, NULL);
    REFUSED(pixel, 7);
    REFUSED(rows, 0);
    REFUSED(cols, -1);
    REFUSED(stride, 7);
    REFUSED(dropped, -1);
    REFUSED(restarts, -1);
    REFUSED(restarts, (INT64_C(1) << 31) + 1);
    REFUSED(sigma, nextafter(SIGMA, 0));
    REFUSED(sigma, 33 * SIGMA);
    REFUSED(sigma, NAN);
    REFUSED(pixels, (const char *)frames[1].pixels + 1);
    REFUSED(struct_size, 8);
    assert_int_equal(info_of(track).received, 0);
    toliman_track_destroy(track);
#define NOT_MADE(member, wrong, field)                                                                                 \
    ;                                                                                                                  \
    do {                                                                                                               \
        options = small_options(NULL);                                                                                 \
        options.member = (wrong);                                                                                      \
        track = NULL;                                                                                                  \
        assert_invalid(toliman_track_create(&options, &track), field);                                                 \
        assert_null(track);                                                                                            \
    } while (0)
    NOT_MADE(ledger.capacity, -1, "options->ledger.capacity");
    NOT_MADE(estimator.sigma, 0, "options->estimator.sigma");
    NOT_MADE(frames.crop_row, 8, "options->frames.rows");
    NOT_MADE(frames.crop_col, 9, "options->frames.cols");
    NOT_MADE(frames.bin, 9, "options->frames.rows");
    NOT_MADE(frames.image_rows, 9, "options->frames.crop_row");
    NOT_MADE(grid.nf, 0, "options->grid.nf");
    NOT_MADE(grid.flags, 64, "options->grid.flags");
    NOT_MADE(flags, 64, "options->flags");
    NOT_MADE(flags, TOLIMAN_TRACK_REBUILD, "options->folder");
    NOT_MADE(struct_size, 8, "options->struct_size");
    assert_invalid(toliman_track_create(NULL, &track), "options");
    options = small_options(NULL);
    options.estimator.estimate = NULL;
    track = make_track(&options);
    assert_refused(toliman_track_push(track, &frames[0].frame, 1, outcomes, &done), TOLIMAN_E_STATE, "");
    toliman_track_destroy(track);
}

TEST(full_tracker_keeps_its_frames) {
    enum { CAPACITY = 500 };
    toliman_track_options options = small_options(NULL);
    options.ledger.capacity = CAPACITY;
    toliman_track *track = make_track(&options);
    for (int64_t id = 1; id <= CAPACITY; id++)
        assert_true(push_number(track, id) != TOLIMAN_TRACK_VERDICT_DUPLICATE);
    small_frame frames[3];
    toliman_frame three[3];
    toliman_track_outcome outcomes[3] = {{.struct_size = sizeof *outcomes}};
    for (int i = 0; i < 3; i++) {
        make_frame(&frames[i], CAPACITY - 1 + i);
        three[i] = frames[i].frame;
    }
    size_t done = 9;
    assert_refused(toliman_track_push(track, three, 3, outcomes, &done), TOLIMAN_E_CAPACITY, "");
    assert_int_equal(done, 2);
    assert_int_equal(outcomes[1].verdict, TOLIMAN_TRACK_VERDICT_DUPLICATE);
    assert_holds(track, &options, 1, CAPACITY);
    assert_int_equal(info_of(track).received, CAPACITY + 2);
    toliman_track_destroy(track);
}

/* A batch equals one push after the other, for any split and number of threads. */
/* promise: threads-change-no-bit */
TEST(threads_and_batches_change_no_bit) {
    enum { N = 700 };
    static small_frame frames[N];
    static toliman_frame all[N];
    static toliman_track_outcome outcomes[N], first[N];
    for (int i = 0; i < N; i++) {
        make_frame(&frames[i], 1 + (i * 37) % 650); /* some are duplicates, within a batch and beyond */
        if (i % 97 == 5)
            frames[i].pixels[3] = 5000;
        if (i >= 650 && i % 3 == 0)
            frames[i].pixels[4] ^= 1;
        all[i] = frames[i].frame;
        all[i].pixels = frames[i].pixels;
    }
    toliman_period *expected = NULL;
    const uint32_t threads[] = {1, 2, 3, 8, 0};
    for (size_t t = 0; t < sizeof threads / sizeof *threads; t++) {
        toliman_track_options options = small_options(NULL);
        options.threads = threads[t];
        toliman_track *track = make_track(&options);
        size_t done = 0;
        memset(outcomes, 0, sizeof outcomes);
        outcomes[0].struct_size = sizeof *outcomes;
        if (t == 0)
            for (int i = 0; i < N; i++)
                outcomes[i] = push_one(track, &all[i]);
        else
            assert_ok(toliman_track_push(track, all, N, outcomes, &done));
        assert_int_equal(done, t == 0 ? 0 : N);
        if (t == 0) {
            memcpy(first, outcomes, sizeof first);
            assert_ok(toliman_period_copy(period_of(track), &expected));
        }
        assert_memory_equal(first, outcomes, sizeof first);
        assert_same_periods(period_of(track), expected);
        toliman_track_destroy(track);
    }
    toliman_period_destroy(expected);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
static long touched_pages(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_minflt;
}

/* Memory: 1.5 slots of 18 bytes and a bit per frame in the index, 131 kB for the distribution of chi-squares; without a
 * folder, 64 more and 8 for each of 10 columns. Creation touches no page of the index (28 MB are 6900), and a push
 * allocates nothing, whatever its verdict. */
/* promise: trackers-allocate-at-creation */
TEST(memory_is_allocated_at_creation) {
    enum { MANY = 1 << 20 };
    static const int64_t clock[2] = {0, 1000};
    char folder[256];
    make_folder(folder, sizeof folder);
    for (int on_disk = 0; on_disk < 2; on_disk++) {
        toliman_track_options options = small_options(on_disk ? folder : NULL);
        options.ledger.capacity = MANY;
        options.ledger.group = 65536;
        options.clock.pairs = clock;
        options.clock.count = 1;
        asked = 0;
        const long before = touched_pages();
        toliman_track *track = make_track(&options);
        assert_in_range(touched_pages() - before, 0, 3300);
        const double rest =
            65536 * 32 * 1.5 + (on_disk ? 65536 * 144 : 0) + 5e5; /* streams, group, grid, chi-squares */
        assert_close((double)asked, (1.5 * (18 + 1. / 8) + (on_disk ? 0 : 144)) * MANY + rest, 0, 3e5);
        asked = 0;
        small_frame frame;
        for (int64_t i = 0; i < 3000; i++) {
            make_frame(&frame, i / 3);
            frame.pixels[7] = (uint16_t)(i % 3 == 2 && i % 2 ? 5000 : 1 + i % 3 / 2);
            push_one(track, &frame.frame);
        }
        make_frame(&frame, 5000);
        frame.frame.camera_ns = INT64_MAX; /* beyond 64-bit TAI */
        assert_int_equal(push_one(track, &frame.frame).reason, TOLIMAN_TRACK_REASON_CLOCK);
        assert_int_equal(asked, 0);
        const toliman_track_info info = info_of(track);
        assert_true(info.quarantined == 500 && info.rejected == 501 && info.repeated == 1500);
        assert_int_equal(asked, 0);
        toliman_track_destroy(track);
    }
    remove_folder(folder);
}
#else
TEST(memory_is_allocated_at_creation) {}
#endif

RUN_TESTS(NULL, NULL)
