/* Series, tables and files of times: what the table `scenarios` names of period.h, measure.h, planet.h, sky.h, ingest.h
 * and series.h. */
#include <stdio.h>

#include "leap_second_rows.h"
#include "measure_arrays.h"
#include "objects.h"

void *create_measure(void);
void *create_series(void);

static double days[ARCHIVE], signal[ARCHIVE], above[SAMPLES];

static void fill(void) {
    for (int i = 0; i < ARCHIVE; i++) {
        days[i] = i + 0.3 * ((i * 7919) % 100) / 100;
        signal[i] = 1000 * sin(0.7 * days[i]) + (i * 31) % 17;
        above[i % SAMPLES] = signal[i % SAMPLES] * 1e-3 + 1e12;
    }
}

const double *times(void) {
    if (days[1] == 0)
        fill();
    return days;
}

const double *values(void) {
    times();
    return signal;
}

const double *values_above(void) {
    times();
    return above;
}

/* Periodograms of 60 samples. */
static toliman_period *empty_period(const toliman_period_options *options) {
    toliman_period *period = NULL;
    assert_ok(toliman_period_create(F0, DF, GRID, options, &period));
    return period;
}

static void *period_with(uint32_t flags, double value_offset) {
    const toliman_period_options options = {
        .struct_size = sizeof options, .flags = flags, .value_offset = value_offset};
    toliman_period *const period = empty_period(&options);
    assert_ok(toliman_period_push_many(period, times(), values(), NULL, SAMPLES));
    return period;
}

void *make_period(void) {
    return period_with(0, 0);
}
void *make_shifted(void) {
    return period_with(0, 3);
}
void *make_wide(void) {
    return period_with(TOLIMAN_PERIOD_DOUBLE_LIMB, 0);
}
void *make_wide_shifted(void) {
    return period_with(TOLIMAN_PERIOD_DOUBLE_LIMB, 3);
}

/* A trend and a column. */
void *make_rows(void) {
    const toliman_period_options options = {
        .struct_size = sizeof options, .trend = 2, .trend_end = ARCHIVE, .columns = 1, .column_bound[0] = 2000};
    toliman_period *const period = empty_period(&options);
    for (int i = 0; i < SAMPLES; i++) {
        const toliman_period_sample sample = {.struct_size = sizeof sample, .t = times()[i], .y = values()[i]};
        assert_ok(toliman_period_push_samples(period, &sample, &values()[i + 7], 1));
    }
    return period;
}

/* Series of measurements. */
const toliman_measure_data *separations(size_t n, int interval_days) {
    enum { MOST = 36 };
    static _Thread_local toliman_measure_data data;
    static _Thread_local double y[MOST], sigma[MOST];
    static _Thread_local int64_t intervals[2 * MOST];
    static _Thread_local size_t counts[MOST];
    for (size_t i = 0; i < n; i++) {
        y[i] = 9.2 + 1e-3 * interval_days * (double)i;
        sigma[i] = 1;
        counts[i] = 1;
        intervals[2 * i] = INT64_C(1800000000000000000) + (int64_t)i * interval_days * INT64_C(86400000000000);
        intervals[2 * i + 1] = intervals[2 * i] + INT64_C(60000000000);
    }
    data = (toliman_measure_data){.struct_size = sizeof data,
                                  .kind = TOLIMAN_MEASURE_SEPARATION,
                                  .n = n,
                                  .y = y,
                                  .sigma = sigma,
                                  .intervals = intervals,
                                  .interval_counts = counts,
                                  .unit = 1};
    return &data;
}

static toliman_measure *series_of(const toliman_measure_data *data) {
    toliman_measure *series = NULL;
    assert_ok(toliman_measure_create(data, &series));
    return series;
}

void *make_measure(void) {
    void *const series = create_measure();
    assert_ok(toliman_measure_add_column(series, "c", times(), POINTS, 1));
    return series;
}

uint64_t digest_measure(const void *series) {
    toliman_measure_info info = {.struct_size = sizeof info};
    double numbers[64];
    assert_ok(toliman_measure_get_info(series, &info));
    info.instrument_names = info.name = NULL;
    assert_true(info.n <= 64);
    assert_ok(toliman_measure_get_values(series, "y", numbers, (size_t)info.n));
    uint64_t hash = fnv1a(fnv1a(FNV_START, &info, sizeof info), numbers, (size_t)info.n * sizeof *numbers);
    for (int64_t f = 0; f < info.functions; f++) {
        toliman_measure_function function = {.struct_size = sizeof function};
        assert_ok(toliman_measure_get_function(series, f, &function));
        hash = fnv1a(hash, &function, sizeof function);
    }
    return hash;
}

void put_separations(void) {
    static const char text[] = "mjd,y,sigma\n61041.5,9.8,1e-6\n61042.5,9.9,1e-6\n61043.5,9.8,2e-6\n";
    write_file("separations.csv", text, sizeof text - 1);
}

void *make_noise_series(void) {
    toliman_measure *const series = measure_of(times(), values(), NULL, SAMPLES);
    assert_ok(toliman_measure_add_column(series, "c", times() + SAMPLES, SAMPLES, 0));
    return series;
}

/* A circular orbit of 90 d, a linear trend, a column, and position angles that turn 3 degrees. */
void *make_planet_series(void) {
    double t[PLANET_POINTS], y[PLANET_POINTS], sigma[PLANET_POINTS], rows[PLANET_POINTS], angles[PLANET_POINTS];
    for (int i = 0; i < PLANET_POINTS; i++) {
        t[i] = 8 * i + i % 3;
        y[i] = 5 * sin(2 * M_PI * t[i] / 90) + 0.01 * (i * 37 % 101);
        sigma[i] = 0.5 + 0.01 * (i % 7);
        rows[i] = cos(0.02 * t[i]);
        angles[i] = 30 + 0.01 * t[i];
    }
    toliman_measure *const series = series_of(&(const toliman_measure_data){.struct_size = sizeof(toliman_measure_data),
                                                                            .n = PLANET_POINTS,
                                                                            .t = t,
                                                                            .y = y,
                                                                            .sigma = sigma,
                                                                            .position_angle_deg = angles});
    assert_ok(toliman_measure_set_trend(series, 1, 0, 0));
    assert_ok(toliman_measure_add_column(series, "rows", rows, PLANET_POINTS, 2));
    return series;
}

/* Sky: a system, and ten states, one per minute, of a circular orbit of 7000 km. */
#define MINUTE INT64_C(60000000000)
const int64_t kSkyTimes[3] = {1800000000000000000, 1800050000000000000, 1900000000000000000};
const int64_t kSkyIntervals[4] = {1800000000000000000, 1800000000000000060, 1800000000000000600, 1800000000000000700};

void put_system(void) {
    static const char system[] =
        "{\"schema\": \"toliman-system/1\", \"name\": \"a binary\", \"orbit\": {\"period_years\": 80, "
        "\"semi_major_arcsec\": 17, \"eccentricity\": 0.5, \"inclination_deg\": 79, \"node_deg\": 205, "
        "\"periastron_deg\": 231, \"epoch\": 1955.5, \"source\": \"a catalogue\"}, \"barycentre\": {\"ra_deg\": 219, "
        "\"dec_deg\": -60, \"epoch\": 2019.5, \"pm_ra_mas_yr\": -3640, \"pm_dec_mas_yr\": 700, \"parallax_mas\": 750, "
        "\"radial_velocity_km_s\": -22, \"radial_velocity_kind\": \"kinematic\"}, \"masses\": {\"A\": 1.1, \"B\": "
        "0.9}}";
    char text[4000] = "t_tai_ns,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s\n";
    size_t used = strlen(text);
    for (int i = 0; i < 10; i++) {
        const double angle = 0.00107801 * 60 * i, c = cos(angle), s = sin(angle);
        used += (size_t)snprintf(text + used, sizeof text - used, "%lld,%.6f,%.6f,0,%.9f,%.9f,0\n",
                                 (long long)(kSkyTimes[0] + (i - 5) * MINUTE), 7000 * c, 7000 * s, -7.54607 * s,
                                 7.54607 * c);
    }
    write_file("orbit.csv", text, used);
    write_file("binary.json", system, sizeof system - 1);
}

uint64_t digest_sky(const void *sky) {
    toliman_sky_info info = {.struct_size = sizeof info};
    toliman_sky_prediction seen[3] = {{.struct_size = sizeof *seen}};
    double numbers[2 * TOLIMAN_SKY_ELEMENTS];
    assert_ok(toliman_sky_get_info(sky, &info));
    assert_ok(toliman_sky_predict(sky, kSkyTimes, info.observer == TOLIMAN_SKY_OBSERVER_FILE ? 1 : 3, seen));
    for (int32_t i = 0; i < (int32_t)TOLIMAN_SKY_ELEMENTS; i++)
        assert_ok(toliman_sky_get_element(sky, TOLIMAN_SKY_ELEMENT_PERIOD + i, &numbers[2 * i], &numbers[2 * i + 1]));
    return fnv1a(fnv1a(fnv1a(FNV_START, &info, sizeof info), seen, sizeof seen), numbers, sizeof numbers);
}

void *make_sky_series(void) {
    int64_t intervals[6];
    for (int i = 0; i < 3; i++) {
        intervals[2 * i] = kSkyTimes[0] + (i == 1 ? 1440 * MINUTE : 0);
        intervals[2 * i + 1] = intervals[2 * i] + MINUTE;
    }
    toliman_measure *series = NULL;
    assert_ok(measure_separations(intervals, NULL, (const double[]){9.8, 9.9, 10}, NULL, 3, &series));
    return series;
}
void *make_sky_dates(void) {
    return series_of(separations(12, 93));
}
void *make_sky_months(void) {
    return series_of(separations(36, 30));
}

/* Clock tables, on-target windows, leap seconds. */
const toliman_leap_second kLeapSeconds[2] = {{sizeof *kLeapSeconds, 10, 41317}, {0, 11, 41499}};

void put_tables(void) {
    static const char clock[] = "camera_ns,tai_ns\n0,5\n1000,2005\n",
                      list[] = "#@ 3928521600\n" LEAP_SECOND_ROWS LAST_LEAP_SECOND,
                      windows[] = "start_utc,end_utc\n2016-12-31T23:59:59,2017-01-01T00:00:00\n"
                                  "2017-001T00:00:00,2017-001T00:00:01\n";
    write_file("clock", clock, sizeof clock - 1);
    write_file("list", list, sizeof list - 1);
    write_file("windows", windows, sizeof windows - 1);
}

/* Pairs of files. Four lines, of which the third is malformed and the fourth has no pixels. */
enum { PAIR_SIDE = 4 };

void put_pair(void) {
    char text[2000] = "";
    uint16_t pixels[3 * PAIR_PIXELS];
    for (int i = 0; i < 4; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text),
                 "{\"frame_id\": %d, \"timestamp_ns\": %d, \"host_time\": 0, \"nframes_dropped\": 0, \"roi_label\": "
                 "\"a-region-with-a-long-name\", \"n_rows\": %s, \"n_cols\": 4, \"session_id\": \"day1\", "
                 "\"on_target_s\": [0, 0.25, 0.5, 1]}\n",
                 i, 5 - i, i == 2 ? "null" : "4");
    for (size_t i = 0; i < 3 * PAIR_PIXELS; i++)
        pixels[i] = (uint16_t)i;
    write_file("day1_meta.jsonl", text, strlen(text));
    write_file("day1_frames.bin", pixels, sizeof pixels);
}

static toliman_status next_of(toliman_ingest *ingest, toliman_frame *frame, toliman_ingest_event *event) {
    *frame = (toliman_frame)TOLIMAN_FRAME_INIT;
    *event = (toliman_ingest_event)TOLIMAN_INGEST_EVENT_INIT;
    return toliman_ingest_next(ingest, frame, event);
}

static void *pair_after(uint32_t flags, int events) {
    const toliman_ingest_options options = {
        .struct_size = sizeof options, .pixel = TOLIMAN_PIXEL_U16, .flags = flags, .buffers = 2, .exposure_s = 1};
    toliman_ingest *ingest = NULL;
    toliman_frame frame;
    toliman_ingest_event event;
    assert_ok(toliman_ingest_create(in_folder("day1"), &options, &ingest));
    for (int i = 0; i < events; i++)
        assert_ok(next_of(ingest, &frame, &event));
    return ingest;
}

void *make_pair(void) {
    put_pair();
    return pair_after(0, 0);
}
void *make_second(void) { /* whose first frame was read */
    put_pair();
    return pair_after(TOLIMAN_INGEST_GROWING, 1);
}
void *make_grown(void) { /* the pixels of the last line arrive after a NOTHING */
    const uint16_t pixels[4 * PAIR_PIXELS] = {0};
    put_pair();
    void *const ingest = pair_after(TOLIMAN_INGEST_GROWING, 4);
    write_file("day1_frames.bin", pixels, sizeof pixels);
    return ingest;
}
void *make_finished(void) { /* with lines left over */
    put_pair();
    toliman_ingest *const ingest = pair_after(TOLIMAN_INGEST_GROWING, 5);
    assert_ok(toliman_ingest_finish(ingest));
    return ingest;
}
/* The second frame is searched in a file that has lost a line: it is found elsewhere, or not at all. */
void *make_short(void) {
    uint16_t pixels[4 * PAIR_PIXELS];
    put_pair();
    for (size_t i = 0; i < 4 * PAIR_PIXELS; i++)
        pixels[i] = (uint16_t)(i < PAIR_PIXELS || i >= 2 * PAIR_PIXELS ? i % PAIR_PIXELS : 7);
    write_file("day1_frames.bin", pixels, sizeof pixels - 2 * PAIR_PIXELS);
    return pair_after(0, 1);
}

const toliman_frame *ramp(void) {
    static _Thread_local uint16_t pixels[PAIR_PIXELS];
    static _Thread_local toliman_frame frame;
    for (size_t i = 0; i < PAIR_PIXELS; i++)
        pixels[i] = (uint16_t)i;
    frame = (toliman_frame){.struct_size = sizeof frame,
                            .pixel = TOLIMAN_PIXEL_U16,
                            .rows = PAIR_SIDE,
                            .cols = PAIR_SIDE,
                            .pixels = pixels};
    return &frame;
}

/* Event and frame as numbers that do not depend on addresses. */
toliman_status next_event(attempt *a) {
    toliman_frame frame;
    toliman_ingest_event event;
    const toliman_status status = next_of(a->object, &frame, &event);
    if (status != TOLIMAN_OK)
        return status;
    int64_t numbers[] = {event.event, event.reason, event.line, event.has_key, frame.frame_id, frame.camera_ns, 0};
    uint64_t hash = fnv1a(FNV_START, event.text, strlen(event.text));
    if (frame.pixels != NULL)
        hash = fnv1a(hash, frame.pixels, sizeof(uint16_t) * PAIR_PIXELS);
    if (frame.intervals != NULL)
        hash = fnv1a(hash, frame.intervals, 2 * frame.interval_count * sizeof *frame.intervals);
    numbers[6] = (int64_t)hash;
    memcpy(a->out, numbers, sizeof numbers);
    return status;
}

/* Events that were reported; lines that were read are not promised. */
uint64_t digest_ingest(const void *ingest) {
    toliman_ingest_info info = TOLIMAN_INGEST_INFO_INIT;
    assert_ok(toliman_ingest_get_info(ingest, &info));
    const int64_t counts[] = {info.frames, info.damaged, info.warnings, info.skipped};
    return fnv1a(FNV_START, counts, sizeof counts);
}

void *make_named_series(void) { /* whose line of names was parsed */
    static const char line[] = "t,another-column-with-a-long-name,a-column-with-a-long-name\n";
    toliman_series *const series = create_series();
    toliman_series_sample sample = TOLIMAN_SERIES_SAMPLE_INIT;
    assert_ok(toliman_series_parse(series, line, strlen(line), &sample));
    return series;
}

/* Without the format of the times, which every line determines until the first sample. */
uint64_t digest_series(const void *series) {
    toliman_series_info info = TOLIMAN_SERIES_INFO_INIT;
    assert_ok(toliman_series_get_info(series, &info));
    const int64_t numbers[] = {info.lines, info.truncated};
    return fnv1a(FNV_START, numbers, sizeof numbers);
}
