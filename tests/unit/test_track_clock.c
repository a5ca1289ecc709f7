/* Tests the conversion of camera time to TAI against exact integers. */
#include "track_frames.h"

__extension__ typedef __int128 wide;

enum { MOST_POINTS = 12 };

static toliman_track *make_clock(const int64_t *clock, size_t points) {
    toliman_track_options options = small_options(NULL);
    options.clock.pairs = clock;
    options.clock.count = points;
    options.grid.f0 = 1;
    options.grid.df = 1;
    options.grid.nf = 1;
    options.grid.unit_ns = 1e18;
    return make_track(&options);
}

static toliman_track_outcome convert(toliman_track *track, int64_t id, int64_t camera_ns) {
    small_frame frame;
    make_frame(&frame, 1);
    frame.frame.frame_id = id;
    frame.frame.camera_ns = camera_ns;
    return push_one(track, &frame.frame);
}

static wide size_of_number(wide x) {
    return x < 0 ? -x : x;
}

/* On the line through two points to half a nanosecond, for any length: the test needs no division. */
static void assert_on_line(const int64_t *from, const int64_t *to, int64_t camera_ns, int64_t tai_ns) {
    const wide camera = (wide)to[0] - from[0], tai = (wide)to[1] - from[1];
    const wide off = ((wide)tai_ns - from[1]) * camera - ((wide)camera_ns - from[0]) * tai;
    assert_true(size_of_number(off) <= camera / 2);
}

static int64_t random_bits(uint64_t *random, int bits) {
    return (int64_t)(mixed((*random)++) >> (64 - bits));
}

TEST(lines_are_exact) {
    uint64_t random = 1;
    for (int table = 0; table < 400; table++) {
        const int bits = 4 + table % 56; /* steps of nanoseconds to years */
        const size_t points = 2 + draw(&random, MOST_POINTS - 2);
        int64_t clock[MOST_POINTS][2] = {{random_bits(&random, 60) - ((int64_t)1 << 59), random_bits(&random, 60)}};
        for (size_t i = 1; i < points; i++)
            for (int k = 0; k < 2; k++)
                clock[i][k] = clock[i - 1][k] + 1 + random_bits(&random, bits < 57 ? bits : 57);
        toliman_track *track = make_clock(clock[0], points);
        for (int64_t id = 0; id < 40; id++) {
            const size_t line = draw(&random, points - 1);
            const int64_t step = clock[line + 1][0] - clock[line][0];
            const int64_t camera = clock[line][0] + (id == 0 ? 0 : id == 1 ? step : random_bits(&random, 62) % step);
            const toliman_track_outcome outcome = convert(track, id, camera);
            assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
            assert_on_line(clock[line], clock[line + 1], camera, outcome.tai_ns);
            if (id < 2)
                assert_int_equal(outcome.tai_ns, clock[line + (size_t)id][1]);
        }
        const int64_t before = clock[0][0] - 1 - random_bits(&random, bits < 50 ? bits : 50);
        const int64_t after = clock[points - 1][0] + 1 + random_bits(&random, bits < 50 ? bits : 50);
        const toliman_track_outcome early = convert(track, 98, before), late = convert(track, 99, after);
        if (early.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED)
            assert_on_line(clock[0], clock[1], before, early.tai_ns);
        if (late.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED)
            assert_on_line(clock[points - 2], clock[points - 1], after, late.tai_ns);
        toliman_track_destroy(track);
    }
}

TEST(halves_are_rounded_away_from_the_point) {
    const int64_t clock[] = {100, 1000, 104, 1002}; /* half as fast */
    toliman_track *track = make_clock(clock, 2);
    static const int64_t pairs[][2] = {{100, 1000}, {101, 1001}, {102, 1001}, {103, 1002}, {104, 1002},
                                       {105, 1003}, {99, 999},   {98, 999},   {97, 998}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++)
        assert_int_equal(convert(track, (int64_t)i, pairs[i][0]).tai_ns, pairs[i][1]);
    toliman_track_destroy(track);
}

TEST(few_points_and_far_times) {
    toliman_track *track = make_clock(NULL, 0);
    assert_int_equal(convert(track, 1, INT64_MIN).tai_ns, INT64_MIN);
    assert_int_equal(convert(track, 2, INT64_MAX).tai_ns, INT64_MAX);
    toliman_track_destroy(track);
    const int64_t one[] = {1000, 1000000};
    track = make_clock(one, 1);
    assert_int_equal(convert(track, 1, 1000).tai_ns, 1000000);
    assert_int_equal(convert(track, 2, -7).tai_ns, 998993);
    assert_int_equal(convert(track, 3, INT64_MAX - 999000).tai_ns, INT64_MAX);
    const toliman_track_outcome beyond = convert(track, 4, INT64_MAX - 998999);
    assert_int_equal(beyond.verdict, TOLIMAN_TRACK_VERDICT_REJECTED);
    assert_int_equal(beyond.reason, TOLIMAN_TRACK_REASON_CLOCK);
    toliman_track_destroy(track);
    /* Twice the rate, so that half of the range overflows. */
    const int64_t fast[] = {0, 0, (int64_t)1 << 61, (int64_t)1 << 62};
    track = make_clock(fast, 2);
    assert_int_equal(convert(track, 1, INT64_MIN / 2).tai_ns, INT64_MIN);
    assert_int_equal(convert(track, 2, INT64_MIN / 2 - 1).reason, TOLIMAN_TRACK_REASON_CLOCK);
    assert_int_equal(convert(track, 3, INT64_MAX / 2).tai_ns, INT64_MAX - 1);
    assert_int_equal(convert(track, 4, INT64_MAX / 2 + 1).reason, TOLIMAN_TRACK_REASON_CLOCK);
    assert_int_equal(convert(track, 5, INT64_MIN).reason, TOLIMAN_TRACK_REASON_CLOCK);
    toliman_track_destroy(track);
}

/* The clock in use is returned as it was given; no clock is returned as none. */
TEST(clock_can_be_queried) {
    const int64_t given[] = {5, 7, 100, 250, 1000, 1001};
    toliman_track_options options = small_options(NULL);
    options.clock.pairs = given;
    options.clock.count = 3;
    toliman_track *track = make_track(&options);
    toliman_track_options found = TOLIMAN_TRACK_OPTIONS_INIT;
    assert_ok(toliman_track_get_options(track, &found));
    assert_int_equal(found.clock.count, 3);
    assert_memory_equal(found.clock.pairs, given, sizeof given);
    toliman_track_destroy(track);
    const int64_t same[] = {77, 77, 99, 99};
    options.clock.pairs = same;
    for (options.clock.count = 1; options.clock.count <= 2; options.clock.count++) {
        track = make_track(&options);
        assert_ok(toliman_track_get_options(track, &found));
        assert_true(found.clock.count == 0 && found.clock.pairs == NULL);
        toliman_track_destroy(track);
    }
}

TEST(tables_must_increase) {
    static const int64_t bad[][4] = {{0, 0, 0, 1},
                                     {0, 0, 1, 0},
                                     {5, 5, 4, 6},
                                     {5, 5, 6, 4},
                                     {INT64_MIN, 0, INT64_MAX, 1},
                                     {0, INT64_MIN, 1, INT64_MAX}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        toliman_track_options options = small_options(NULL);
        options.clock.pairs = bad[i];
        options.clock.count = 2;
        toliman_track *track = NULL;
        assert_invalid(toliman_track_create(&options, &track), "clock");
    }
    toliman_track_options options = small_options(NULL);
    options.clock.count = 1;
    toliman_track *track = NULL;
    assert_invalid(toliman_track_create(&options, &track), "options->clock.pairs");
}

RUN_TESTS(NULL, NULL)
