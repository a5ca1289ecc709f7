/* Tests the columns of the ledger: additional values of frames and estimators, and the options in force. */
#include "track_folder.h"

enum { FRAMES = 30, VALUES = 3 };

/* The last arguments of the estimator. */
static toliman_estimate_input seen;
static double seen_intervals[4];

static int32_t rich_estimate(const toliman_estimate_input *input, toliman_estimate *made, void *sigma) {
    seen = *input;
    if (input->interval_count > 0)
        memcpy(seen_intervals, input->intervals, 2 * input->interval_count * sizeof *seen_intervals);
    const size_t n = made->value_count;
    for (size_t i = 0; i < n * n; i++)
        if (!isnan(made->covariance[i]) || !isnan(made->values[i / n]) || !isnan(made->chi_square))
            return 1;
    made->values[0] = value_of(input->image, input->rows * input->cols);
    for (size_t i = 1; i < n; i++)
        made->values[i] = input->image[i];
    for (size_t i = 0; i < n; i++)
        for (size_t j = i; j < n; j++)
            made->covariance[i * n + j] = (double)(10 * i + j);
    made->flags = 1u << 31 | 5;
    made->chi_square = 1 + input->exposure_s;
    made->sigma = *(const double *)sigma;
    return 0;
}

static double own_sigma;

static toliman_track_options rich_options(const char *in) {
    toliman_track_options options = small_options(in);
    options.estimator.estimate = rich_estimate;
    options.estimator.estimate_data = &own_sigma;
    strcpy(options.estimator.values, "dx,flux_2");
    return options;
}

static const double kIntervals[4] = {0.25, 0.5, 1, 2};

static void make_exposed(small_frame *frame, int64_t id) {
    make_frame(frame, id);
    frame->frame.exposure_s = 2 + (double)id;
    frame->frame.intervals = kIntervals;
    frame->frame.interval_count = 2;
    frame->frame.window_row = -7 * id;
    frame->frame.window_col = 1000 + id;
}

static void push_exposed(toliman_track *track, int64_t first, int64_t last) {
    for (int64_t id = first; id <= last; id++) {
        small_frame frame;
        make_exposed(&frame, id);
        const toliman_track_outcome outcome = push_one(track, &frame.frame);
        assert_true(outcome.chi_square == 3 + (double)id);
    }
}

/* Number of the record of the frame that arrived as number `arrival`, from 0. Intervals have records of their own. */
static int64_t record_of(const toliman_track *track, int64_t arrival) {
    for (int64_t number = 0;; number++) {
        toliman_track_record record = TOLIMAN_TRACK_RECORD_INIT;
        size_t done = 0;
        assert_ok(toliman_track_get_records(track, number, 1, &record, &done));
        assert_int_equal(done, 1);
        if (record.verdict != TOLIMAN_TRACK_VERDICT_INTERVALS && arrival-- == 0)
            return number;
    }
}

static double cell(const toliman_track *track, const char *name, int64_t arrival) {
    double value = -1;
    size_t done = 0;
    assert_ok(toliman_track_get_column(track, name, record_of(track, arrival), 1, &value, &done));
    assert_int_equal(done, 1);
    return value;
}

/* Frames 1 ... arrived in this order. */
static void assert_columns(const toliman_track *track, int64_t frames) {
    for (int64_t id = 1; id <= frames; id++) {
        small_frame frame;
        make_exposed(&frame, id);
        const double exposure = frame.frame.exposure_s;
        assert_true(cell(track, "chi_square", id - 1) == 1 + exposure);
        assert_true(cell(track, "exposure_s", id - 1) == exposure);
        assert_close(cell(track, "shift_s", id - 1), (0.25 * 0.375 + 1 * 1.5) / 1.25 - exposure / 2, 1e-15, 1e-15);
        assert_true(cell(track, "window_row", id - 1) == (double)(-7 * id));
        assert_true(cell(track, "window_col", id - 1) == (double)(1000 + id));
        assert_true(cell(track, "flags", id - 1) == 2147483653.0);
        assert_true(cell(track, "intervals", id - 1) == 2);
        assert_true(cell(track, "dx", id - 1) == frame.pixels[1]);
        assert_true(cell(track, "flux_2", id - 1) == frame.pixels[2]);
        assert_true(cell(track, "cov_value_dx", id - 1) == 1);
        assert_true(cell(track, "cov_value_flux_2", id - 1) == 2);
        assert_true(cell(track, "cov_dx_dx", id - 1) == 11);
        assert_true(cell(track, "cov_dx_flux_2", id - 1) == 12);
        assert_true(cell(track, "cov_flux_2_flux_2", id - 1) == 22);
    }
}

TEST_IN_FOLDER(columns_hold_the_given_values) {
    for (int on_disk = 0; on_disk < 2; on_disk++) {
        toliman_track_options options = rich_options(on_disk ? folder : NULL);
        toliman_track *track = make_track(&options);
        push_exposed(track, 1, FRAMES);
        assert_columns(track, FRAMES);
        static const char *const names[] = {"chi_square",
                                            "exposure_s",
                                            "shift_s",
                                            "window_row",
                                            "window_col",
                                            "flags",
                                            "intervals",
                                            "chi_square_sigma",
                                            "largest_residual",
                                            "bad_pixels",
                                            "dx",
                                            "flux_2",
                                            "cov_value_dx",
                                            "cov_value_flux_2",
                                            "cov_dx_dx",
                                            "cov_dx_flux_2",
                                            "cov_flux_2_flux_2"};
        enum { ALL = sizeof names / sizeof *names };
        toliman_track_column columns[ALL] = {TOLIMAN_TRACK_COLUMN_INIT};
        size_t count = 0, done = 9;
        assert_asks(toliman_track_get_columns(track, NULL, 0, &count));
        assert_int_equal(count, ALL);
        assert_refused(toliman_track_get_columns(track, columns, ALL - 1, &count), TOLIMAN_E_CAPACITY, "capacity");
        assert_ok(toliman_track_get_columns(track, columns, ALL, &count));
        for (int i = 0; i < ALL; i++) {
            assert_string_equal(columns[i].name, names[i]);
            assert_int_equal(columns[i].type,
                             (i > 2 && i < 7) || i == 9 ? TOLIMAN_TRACK_COLUMN_I64 : TOLIMAN_TRACK_COLUMN_F64);
        }
        double values[2 * FRAMES];
        assert_ok(toliman_track_get_column(track, "dx", record_of(track, 10), 2 * FRAMES, values, &done));
        assert_int_equal(done, on_disk ? 2 * (FRAMES - 10) - 1 : FRAMES - 10);
        assert_true(!on_disk || isnan(values[1])); /* a record of intervals has no columns */
        assert_refused(toliman_track_get_column(track, "dy", 0, 1, values, &done), TOLIMAN_E_NOT_FOUND, "name");
        assert_refused(toliman_track_get_column(track, "dx", -1, 1, values, &done), TOLIMAN_E_RANGE, "first");
        assert_invalid(toliman_track_get_column(track, "dx", 0, 1, NULL, &done), "values");
        double intervals[4] = {0};
        const int64_t number = record_of(track, 10);
        if (on_disk) {
            assert_asks(toliman_track_get_intervals(track, number, NULL, 0, &count));
            assert_int_equal(count, 2);
            assert_ok(toliman_track_get_intervals(track, number, intervals, 2, &count));
            assert_memory_equal(intervals, kIntervals, sizeof intervals);
            assert_refused(toliman_track_get_intervals(track, number, intervals, 1, &count), TOLIMAN_E_CAPACITY,
                           "capacity");
            assert_refused(toliman_track_get_intervals(track, -1, intervals, 2, &count), TOLIMAN_E_RANGE, "record");
        } else {
            assert_refused(toliman_track_get_intervals(track, number, intervals, 2, &count), TOLIMAN_E_STATE, "track");
        }
        toliman_track_destroy(track);
    }
    toliman_track_options options =
        TOLIMAN_TRACK_OPTIONS_INIT; /* unsaved, as after a crash, and opened with options that do not name the values */
    assert_ok(toliman_track_load_options(folder, &options));
    assert_string_equal(options.estimator.values, "dx flux_2");
    toliman_track *track = make_track(&options);
    const int64_t lines = info_of(track).records;
    toliman_track_destroy(track);
    options = rich_options(folder);
    track = make_track(&options);
    push_exposed(track, lines + 1, FRAMES);
    assert_columns(track, FRAMES);
    toliman_track_destroy(track);
}

/* The window's origin is that of the cropped frame on the detector. */
/* promise: bad-estimates-reject-frames */
TEST(estimators_receive_the_known_values) {
    toliman_track_options options = rich_options(NULL);
    const int64_t clock[] = {0, 500};
    options.clock.pairs = clock;
    options.clock.count = 1;
    options.frames.crop_row = 2;
    options.frames.crop_col = 3;
    options.frames.image_rows = 4;
    options.frames.image_cols = 5;
    toliman_track *track = make_track(&options);
    small_frame frame;
    make_exposed(&frame, 4);
    frame.frame.sigma = 3 * SIGMA;
    push_one(track, &frame.frame);
    assert_int_equal(seen.struct_size, sizeof seen);
    assert_true(seen.rows == 4 && seen.cols == 5 && seen.stride == 5);
    assert_int_equal(seen.tai_ns, frame.frame.camera_ns + 500);
    assert_true(seen.variance_scale == 9 && seen.exposure_s == 6);
    assert_int_equal(seen.interval_count, 2);
    assert_memory_equal(seen_intervals, kIntervals, sizeof kIntervals);
    assert_int_equal(seen.window_row, -28 + 2);
    assert_int_equal(seen.window_col, 1004 + 3);
    toliman_track_record line = {.struct_size = sizeof line};
    size_t done;
    assert_ok(toliman_track_get_records(track, 0, 1, &line, &done));
    assert_true(line.sigma == 3 * SIGMA && line.tai_ns == frame.frame.camera_ns + 500);
    /* A sigma given by the estimator replaces the frame's. If it is out of range or not a number, the frame is
     * rejected. */
    own_sigma = 2 * SIGMA;
    push_exposed(track, 5, 5);
    assert_ok(toliman_track_get_records(track, 1, 1, &line, &done));
    assert_true(line.sigma == 2 * SIGMA);
    const double wrong[] = {nextafter(SIGMA, 0), 33 * SIGMA, NAN, -SIGMA};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        own_sigma = wrong[i];
        make_exposed(&frame, 6);
        const toliman_track_outcome outcome = push_one(track, &frame.frame);
        assert_int_equal(outcome.reason, TOLIMAN_TRACK_REASON_ESTIMATE);
        assert_true(isnan(outcome.chi_square));
    }
    own_sigma = 0;
    make_frame(&frame, 6);
    push_one(track, &frame.frame);
    assert_true(seen.variance_scale == 1 && seen.exposure_s == 0 && seen.interval_count == 0);
    toliman_track_destroy(track);
}

/* The estimator's inputs are part of a frame's content: a copy must have the same. */
/* promise: conflicting-frames-are-quarantined */
TEST(other_exposures_are_other_contents) {
    for (int trial = 0; trial < 6; trial++) {
        toliman_track_options options = rich_options(NULL);
        toliman_track *track = make_track(&options);
        small_frame frame;
        make_exposed(&frame, 1);
        push_one(track, &frame.frame);
        const double later[] = {0.25, 0.5, 1, 1.5};
        frame.frame.exposure_s += trial == 1;
        frame.frame.window_row += trial == 2;
        frame.frame.window_col += trial == 3;
        frame.frame.interval_count -= trial == 4;
        frame.frame.intervals = trial == 5 ? later : kIntervals;
        assert_int_equal(push_one(track, &frame.frame).verdict,
                         trial == 0 ? TOLIMAN_TRACK_VERDICT_DUPLICATE : TOLIMAN_TRACK_VERDICT_QUARANTINED);
        toliman_track_destroy(track);
    }
}

TEST(impossible_exposures_are_refused) {
    toliman_track_options options = rich_options(NULL);
    toliman_track *track = make_track(&options);
    small_frame frame;
    toliman_track_outcome outcome = TOLIMAN_TRACK_OUTCOME_INIT;
    size_t done;
#define REFUSED(member, wrong, field)                                                                                  \
    do {                                                                                                               \
        make_exposed(&frame, 1);                                                                                       \
        frame.frame.member = (wrong);                                                                                  \
        assert_invalid(toliman_track_push(track, &frame.frame, 1, &outcome, &done), field);                            \
    } while (0)
    REFUSED(exposure_s, -1, "frames[0].exposure_s");
    REFUSED(exposure_s, NAN, "frames[0].exposure_s");
    REFUSED(exposure_s, 2e9, "frames[0].exposure_s");
    REFUSED(exposure_s, 1.5, "frames[0].intervals[1]");
    REFUSED(exposure_s, 0, "frames[0].intervals[0]");
    REFUSED(intervals, NULL, "frames[0].intervals");
    REFUSED(interval_count, 65537, "frames[0].interval_count");
    REFUSED(window_row, ((int64_t)1 << 31) + 1, "frames[0].window_row");
    REFUSED(window_col, INT64_MIN, "frames[0].window_col");
    const double bad[][4] = {{-1, 1, 1, 2}, {NAN, 1, 1, 2}, {0, 0, 1, 2}, {0, 1, 0.5, 2}, {0, 1, 1, INFINITY}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        REFUSED(intervals, bad[i], i < 3 ? "frames[0].intervals[0]" : "frames[0].intervals[1]");
    assert_int_equal(info_of(track).received, 0);
    toliman_track_destroy(track);
    static const char *const names[] = {
        "dx,dx", "Dx", "value", "cov_x", "flags", "a;b", "dx dx", "a,b,c,d,e,f,g,h", "abcdefghijklmnopqrstuvwxy"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        strcpy(options.estimator.values, names[i]);
        track = NULL;
        assert_invalid(toliman_track_create(&options, &track), "options->estimator.values");
    }
    memset(options.estimator.values, 'a', sizeof options.estimator.values);
    assert_invalid(toliman_track_create(&options, &track), "options->estimator.values");
}

/* Columns of a folder are merged by name, and none is dropped silently. */
TEST_IN_FOLDER(columns_are_merged) {
    char shard[300], its_ledger[320];
    snprintf(shard, sizeof shard, "%s/shard", folder);
    snprintf(its_ledger, sizeof its_ledger, "%s/ledger.tlml", shard);
    toliman_track_options options = rich_options(shard);
    toliman_track *track = make_track(&options), *none = NULL;
    push_exposed(track, 1, FRAMES);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    strcpy(options.estimator.values, "dx");
    assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_MISMATCH, its_ledger);
    options.folder = NULL;
    track = make_track(&options);
    assert_refused(toliman_track_merge(track, shard, 0, NULL), TOLIMAN_E_MISMATCH, its_ledger);
    assert_int_equal(info_of(track).received, 0);
    toliman_track_destroy(track);
    for (int salvage = 0; salvage < 2; salvage++) {
        options = rich_options(NULL);
        strcpy(options.estimator.values, salvage ? "dx,flux_2" : "flux_2,dx,more"); /* found by name */
        track = make_track(&options);
        if (!salvage) {
            assert_refused(toliman_track_merge(track, shard, 0, NULL), TOLIMAN_E_MISMATCH, its_ledger);
        } else {
            assert_ok(toliman_track_merge(track, shard, TOLIMAN_TRACK_SALVAGE, NULL));
            assert_columns(track, FRAMES);
        }
        toliman_track_destroy(track);
    }
    options = small_options(NULL);
    strcpy(options.estimator.values, "dx,flux_2");
    options.estimator.estimate = NULL;
    track = make_track(&options);
    assert_ok(toliman_track_merge(track, shard, 0, NULL));
    assert_columns(track, FRAMES);
    toliman_track_destroy(track);
    remove_folder(shard);
}

/* A ledger with a column that this version does not fill keeps it: a later version may have created it. */
TEST_IN_FOLDER(unknown_columns_are_left_empty) {
    enum { MADE = COLUMNS + 2, HEAD = 124 + 64 * MADE };
    toliman_track_options options = small_options(folder);
    strcpy(options.estimator.values,
           "later"); /* renamed to belong to the library: a later column, and its two covariances */
    toliman_track_destroy(make_track(&options));
    unsigned char header[HEAD + 64];
    read_at(ledger, 0, header, HEAD + 64);
    for (int i = COLUMNS; i <= MADE; i++)
        header[120 + 64 * i + 60] = 1;
    const uint32_t crc = crc32(0, header, HEAD + 60);
    memcpy(header + HEAD + 60, &crc, 4);
    write_at(ledger, 0, header, HEAD + 64);
    unlink(checkpoint);
    options.estimator.values[0] = 0;
    toliman_track *track = make_track(&options);
    push_range(track, 1, 3);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    track = make_track(&options);
    assert_int_equal(info_of(track).accepted, 3);
    assert_true(isnan(cell(track, "later", 2)) && cell(track, "exposure_s", 2) == 0);
    toliman_track_destroy(track);
}

/* promise: other-versions-are-refused */
TEST_IN_FOLDER(old_ledgers_are_refused) {
    const toliman_track_options options = filled_folder();
    toliman_track *none = NULL;
    const uint32_t one = 1, three = 3;
    write_at(ledger, 4, &one, 4);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, "version 1");
    write_at(ledger, 4, &three, 4);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, "version 3");
}

/* Headers with correct checksums and impossible columns. */
TEST_IN_FOLDER(impossible_columns_are_refused) {
    const toliman_track_options options = small_options(folder);
    toliman_track *none = NULL;
    toliman_track_destroy(make_track(&options));
    const struct {
        off_t at;
        unsigned char byte;
    } bad[] = {{112, 62}, {112, 5}, {116, 128}, {120, 0}, {120, 'C'}, {120 + 56, 2}, {120 + 60, 4}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        unsigned char header[HEADER];
        read_at(ledger, 0, header, HEADER);
        const unsigned char good = header[bad[i].at];
        header[bad[i].at] = bad[i].byte;
        uint32_t crc = crc32(0, header, HEADER - 4);
        memcpy(header + HEADER - 4, &crc, 4);
        write_at(ledger, 0, header, HEADER);
        assert_refused(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, ledger);
        header[bad[i].at] = good;
        crc = crc32(0, header, HEADER - 4);
        memcpy(header + HEADER - 4, &crc, 4);
        write_at(ledger, 0, header, HEADER);
    }
    toliman_track_destroy(make_track(&options));
}

/* Zeros are replaced by defaults, and the options in force are reported. */
/* promise: zero-is-the-default */
TEST_IN_FOLDER(options_in_force) {
    toliman_track_options zeros = TOLIMAN_TRACK_OPTIONS_INIT, made;
    made = (toliman_track_options)TOLIMAN_TRACK_OPTIONS_INIT;
    assert_memory_equal(&zeros, &made, sizeof made);
    const toliman_track_options small = rich_options(folder);
    zeros.estimator.estimate = rich_estimate;
    zeros.estimator.estimate_data = &own_sigma;
    zeros.estimator.sigma = SIGMA;
    zeros.frames.rows = zeros.frames.cols = SIDE;
    zeros.grid.nf = 5;
    zeros.grid.f0 = zeros.grid.df = 0.01;
    toliman_track *track = make_track(&zeros);
    toliman_track_options reported = TOLIMAN_TRACK_OPTIONS_INIT;
    assert_ok(toliman_track_get_options(track, &reported));
    assert_null(reported.folder);
    assert_null(reported.clock.pairs);
    assert_true(reported.flags == 0 && reported.ledger.capacity == 1 << 20 && reported.frames.zero_run_bytes == 4096 &&
                reported.grid.unit_ns == DAY_NS);
    assert_true(reported.threads == 1 && reported.ledger.group == 64 &&
                reported.ledger.sync == TOLIMAN_TRACK_SYNC_GROUP && reported.frames.bin == 1);
    assert_true(reported.limits.value == 1e4 * SIGMA && reported.frames.image_rows == SIDE &&
                reported.estimator.estimate == NULL);
    toliman_track_destroy(track);

    toliman_track_options rich = small;
    const int64_t clock[] = {0, 500, 1000, 1501};
    rich.flags = TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
    rich.clock.pairs = clock;
    rich.clock.count = 2;
    rich.ledger.group = 7;
    rich.ledger.sync = TOLIMAN_TRACK_SYNC_NONE;
    rich.grid.time_offset_ns = 5;
    rich.grid.flags = TOLIMAN_PERIOD_FIXED_MEAN;
    char path[256];
    strcpy(path, folder);
    rich.folder = path;
    track = make_track(&rich);
    memset(path, 0, sizeof path); /* the caller's */
    assert_ok(toliman_track_get_options(track, &reported));
    assert_string_equal(reported.folder, folder);
    assert_int_equal(reported.clock.count, 2);
    assert_memory_equal(reported.clock.pairs, clock, sizeof clock);
    assert_string_equal(reported.estimator.values, "dx flux_2");
    assert_true(reported.flags == TOLIMAN_TRACK_ALLOW_ZERO_RUNS && reported.frames.zero_run_bytes == 0 &&
                reported.ledger.group == 7);
    assert_true(reported.ledger.sync == TOLIMAN_TRACK_SYNC_NONE && reported.ledger.capacity == rich.ledger.capacity &&
                reported.grid.nf == FREQUENCIES);
    assert_true(reported.grid.f0 == rich.grid.f0 && reported.grid.df == rich.grid.df &&
                reported.grid.time_offset_ns == 5 && reported.estimator.id == 77);
    assert_true(reported.grid.flags == TOLIMAN_PERIOD_FIXED_MEAN && reported.frames.bit_depth == 12);
    toliman_track_destroy(track);
    assert_ok(toliman_track_load_options(folder, &reported)); /* and these options create it again */
    assert_true(reported.flags == TOLIMAN_TRACK_ALLOW_ZERO_RUNS && reported.frames.zero_run_bytes == 0);
    toliman_track_destroy(make_track(&reported));
}

RUN_TESTS(NULL, NULL)
