/* Files of an observer for tests: an analytic orbit, tables and Orbit Ephemeris Messages of it. */
#ifndef TOLIMAN_TESTS_EPHEMERIS_FILES_H
#define TOLIMAN_TESTS_EPHEMERIS_FILES_H

#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <time.h>

#include "test_folder.h"

const char *shim_message(void);
const char *shim_warning(void);
int32_t shim_read_ephemeris(const char *path);
int32_t shim_ephemeris_at(int64_t tai_ns, double *state);
size_t shim_segments(void);
size_t shim_segment(size_t segment, int64_t times[3]);
int32_t shim_check_states(const double *states, size_t count);
void shim_date_text(int64_t tai_ns, char *text, size_t capacity);

enum { FORMAT = 5, RANGE = 10 };

static const double kPi = 3.14159265358979323846, kGm = 3.986004418e14;
static const int64_t kNs = 1000000000, kStart = INT64_C(1830297600) * 1000000000; /* 2028-01-01 */
static char folder[256], path[300];

/* The orbit: 600 km, with wobbles of 8 km at 2 and 3 times the mean motion, as the Earth's flattening makes. */
static inline void orbit(double t, double state[6]) {
    const double a = 6.978e6, n = sqrt(kGm / a) / a, w = 8e3;
    state[0] = a * cos(n * t) + w * cos(3 * n * t);
    state[1] = a * sin(n * t) + w * sin(3 * n * t);
    state[2] = w * sin(2 * n * t);
    state[3] = -n * (a * sin(n * t) + 3 * w * sin(3 * n * t));
    state[4] = n * (a * cos(n * t) + 3 * w * cos(3 * n * t));
    state[5] = 2 * n * w * cos(2 * n * t);
}

/* A text that grows. */
static char text[4 << 20];
static size_t length;

__attribute__((format(printf, 1, 2))) static void put(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    length += (size_t)vsnprintf(text + length, sizeof text - length, format, arguments);
    va_end(arguments);
    assert_true(length < sizeof text);
}

static inline const char *saved(void) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, length, file), length);
    assert_int_equal(fclose(file), 0);
    return path;
}

static inline void assert_read(void) {
    if (shim_read_ephemeris(saved()) != 0)
        fail_msg("%s", shim_message());
}

/* The calendar is that of the C library. */
static inline const char *date(int64_t ns, bool day_of_year) {
    static char out[64];
    const time_t seconds = (time_t)(ns / kNs);
    struct tm parts;
    gmtime_r(&seconds, &parts);
    const size_t end = strftime(out, sizeof out, day_of_year ? "%Y-%jT%H:%M:%S" : "%Y-%m-%dT%H:%M:%S", &parts);
    snprintf(out + end, sizeof out - end, ".%09" PRId64, ns % kNs);
    return out;
}

/* A table in m of `count` states, `step` s apart. */
static inline void table_of(double step, int count) {
    length = 0;
    put("t_tai_ns,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s\n");
    for (int i = 0; i < count; i++) {
        double s[6];
        orbit(i * step, s);
        put("%" PRId64 ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", kStart + (int64_t)(i * step * 1e9), s[0], s[1], s[2],
            s[3], s[4], s[5]);
    }
}

static inline double distance(const double *a, const double *b) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* What a message of two segments contains. */
typedef struct Message {
    const char *system;
    int64_t ahead_ns; /* of the system, before TAI */
    bool day_of_year;
    const char *end; /* of dates: Z */
    void (*change)(double state[6], double t);
    double kick_m_s; /* of the manoeuvre */
} Message;

enum { STATES = 12, FIRST_STATE = 19, SECOND_META = 35, SECOND_STATE = 44 };

static inline void put_date(const char *before, const Message *message, int64_t tai_ns) {
    put("%s%s%s", before, date(tai_ns + message->ahead_ns, message->day_of_year), message->end);
}

static inline void put_state(const Message *message, int i, double kick) {
    double s[6];
    orbit(60 * i, s);
    for (int k = 0; k < 6; k++)
        s[k] /= 1000;
    s[2] += kick / 1000 * (60 * i - 660);
    s[5] += kick / 1000;
    if (message->change != NULL)
        message->change(s, 60 * i);
    put_date("", message, kStart + 60 * kNs * i);
    put(" %.17g %.17g  %.17g\t%.17g %.17g %.17g%s\n", s[0], s[1], s[2], s[3], s[4], s[5], i == 3 ? " 0 0 0" : "");
}

/* Line numbers: see the enumeration. */
static inline void put_message(const Message *message) {
    length = 0;
    put("CCSDS_OEM_VERS = 2.0\nCOMMENT two segments\nCREATION_DATE = 2028-01-01T00:00:00\nORIGINATOR = TEST\n\n");
    for (int segment = 0; segment < 2; segment++) {
        const int first = segment * (STATES - 1), last = first + STATES - 1;
        put("META_START\nOBJECT_NAME = SAT\nOBJECT_ID = 2028-001A\nCENTER_NAME = EARTH\nREF_FRAME = GCRF\n");
        put("TIME_SYSTEM = %s\n", message->system);
        put_date("START_TIME = ", message, kStart + 60 * kNs * first);
        if (segment == 0) {
            put_date("\nUSEABLE_START_TIME = ", message, kStart + 60 * kNs * (first + 1));
            put_date("\nUSEABLE_STOP_TIME = ", message, kStart + 60 * kNs * (last - 1));
        }
        put_date("\nSTOP_TIME = ", message, kStart + 60 * kNs * last);
        put("\n%sMETA_STOP\n", segment == 0 ? "INTERPOLATION = HERMITE\nINTERPOLATION_DEGREE = 7\n" : "");
        for (int i = first; i <= last; i++)
            put_state(message, i, segment * message->kick_m_s);
        if (segment == 0)
            put("COVARIANCE_START\nEPOCH = 2028-01-01T00:00:00\n1.0\nCOVARIANCE_STOP\n");
    }
}

static const Message kPlain = {.system = "TAI", .end = ""};

static inline int make_file(void **state) {
    (void)state;
    make_folder(folder, sizeof folder);
    snprintf(path, sizeof path, "%s/states", folder);
    return 0;
}

static inline int remove_file(void **state) {
    (void)state;
    remove_folder(folder);
    return 0;
}

#endif
