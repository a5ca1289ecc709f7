/* Trackers that reduce separations: an estimator of separations, observers, and frames of a spacecraft. */
#ifndef TOLIMAN_TESTS_TRACK_REDUCED_H
#define TOLIMAN_TESTS_TRACK_REDUCED_H

#include <inttypes.h>

#include "track_frames.h"

#define START_NS INT64_C(1798761600000000000) /* 2027-01-01 */
#define SECOND_NS INT64_C(1000000000)
#define SCALE 0.75 /* arcsec per px */
enum { CADENCE_S = 1000, EXPOSURE_S = 60, COVERED = 20, STATES = 4 * COVERED, ARCS = 3 };

static const double kArcs[2 * ARCS] = {0, 10, 15.5, 20, 40, 59.25};
static double base_px; /* separation of a frame of value 0 */

static inline int32_t measure(const toliman_estimate_input *input, toliman_estimate *made, void *unused) {
    (void)unused;
    made->values[0] = value_of(input->image, input->rows * input->cols);
    made->values[1] = base_px + made->values[0];
    return 0;
}

static inline toliman_track_options measured_options(const char *where) {
    toliman_track_options options = small_options(where);
    options.estimator.estimate = measure;
    strcpy(options.estimator.values, "separation_px");
    options.grid.time_offset_ns = START_NS;
    return options;
}

static inline toliman_track_options reduced_options(const char *where, const toliman_sky *sky) {
    toliman_track_options options = measured_options(where);
    options.reduction.sky = sky;
    options.reduction.plate_scale_arcsec = SCALE;
    return options;
}

/* Every 1000 s; every third frame has intervals. */
static inline void make_exposed(small_frame *out, int64_t id) {
    make_frame(out, id);
    out->frame.camera_ns = START_NS + id * CADENCE_S * SECOND_NS + (int64_t)(mixed((uint64_t)id) % 1000000);
    out->frame.exposure_s = EXPOSURE_S;
    if (id % 3 == 1) {
        out->frame.intervals = kArcs;
        out->frame.interval_count = ARCS;
    }
}

static inline int32_t push_exposed(toliman_track *track, int64_t id) {
    small_frame frame;
    make_exposed(&frame, id);
    return push_one(track, &frame.frame).verdict;
}

static inline void push_all_exposed(toliman_track *track, int64_t first, int64_t last) {
    for (int64_t id = first; id <= last; id++)
        push_exposed(track, id);
}

static inline toliman_sky *make_sky(const char *system, const char *observer, double altitude_km) {
    const toliman_sky_options options = {
        .struct_size = sizeof options, .observer = observer, .altitude_km = altitude_km};
    toliman_sky *sky = NULL;
    assert_ok(toliman_sky_create(system, &options, &sky));
    return sky;
}

/* alpha Centauri with a semi-major axis that is larger by 0.001 arcsec. */
static inline toliman_sky *make_other_sky(const toliman_sky *sky) {
    static const char kAxis[] = "\"semi_major_arcsec\":";
    static char text[8192];
    const toliman_track_options options = reduced_options(NULL, sky);
    toliman_track *const track = make_track(&options);
    const char *const system = info_of(track).system, *const axis = strstr(system, kAxis) + strlen(kAxis);
    char *end;
    const double arcsec = strtod(axis, &end);
    snprintf(text, sizeof text, "%.*s%.17g%s", (int)(axis - system), system, arcsec + 0.001, end);
    toliman_track_destroy(track);
    return make_sky(text, NULL, 600);
}

/* A table of a circular orbit from the start to frame COVERED. */
static inline void write_states(const char *path) {
    const double radius = 6.978e6, speed = sqrt(3.986004418e14 / radius);
    FILE *const file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s\n");
    for (int i = -4; i <= STATES; i++) {
        const double t = i * CADENCE_S / 4.0, angle = speed / radius * t;
        fprintf(file, "%" PRId64 ",%.17g,%.17g,0,%.17g,%.17g,0\n", START_NS + (int64_t)(t * 1e9), radius * cos(angle),
                radius * sin(angle), -speed * sin(angle), speed * cos(angle));
    }
    assert_int_equal(fclose(file), 0);
}

static inline void set_base(const toliman_sky *sky) {
    const int64_t start = START_NS;
    toliman_sky_prediction seen = TOLIMAN_SKY_PREDICTION_INIT;
    assert_ok(toliman_sky_predict(sky, &start, 1, &seen));
    base_px = seen.separation_arcsec / SCALE;
}

#endif
