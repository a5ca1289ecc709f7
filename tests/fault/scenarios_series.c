/* series.h */
#include <string.h>

#include "assert_close.h"
#include "scenario.h"

static toliman_status create_into(toliman_series **out) {
    const toliman_leap_second table[] = {{sizeof table[0], 10, 41317}};
    toliman_series_options options = TOLIMAN_SERIES_OPTIONS_INIT;
    options.name = "a-series-of-samples-with-a-long-name";
    options.columns = "t,a-column-with-a-long-name";
    options.leap_seconds = table;
    options.leap_second_count = 1;
    return toliman_series_create(&options, out);
}

static void *make_empty(void) {
    toliman_series *series = NULL;
    assert_ok(create_into(&series));
    return series;
}
static void *make(void) { /* whose line of names was parsed */
    static const char line[] = "t,another-column-with-a-long-name,a-column-with-a-long-name\n";
    toliman_series *const series = make_empty();
    toliman_series_sample sample = TOLIMAN_SERIES_SAMPLE_INIT;
    assert_ok(toliman_series_parse(series, line, strlen(line), &sample));
    return series;
}

static void end(void *series) {
    toliman_series_destroy(series);
}

/* Without the format of the times, which every line determines until the first sample. */
static uint64_t digest(const void *series) {
    toliman_series_info info = TOLIMAN_SERIES_INFO_INIT;
    assert_ok(toliman_series_get_info(series, &info));
    const int64_t numbers[] = {info.lines, info.truncated};
    return fnv1a(FNV_START, numbers, sizeof numbers);
}

static const object_kind parsers = {end, digest};

static toliman_status create(attempt *a) {
    return create_into((toliman_series **)&a->made);
}
static toliman_status destroy(attempt *a) {
    toliman_series_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status parse(attempt *a, const char *line) {
    return toliman_series_parse(a->object, line, strlen(line), (toliman_series_sample *)a->out);
}
static toliman_status columns(attempt *a) {
    return parse(a, "2028-03-01T12:00:00.25,a-field-of-more-than-sixteen-bytes,2.5000000000000000\n");
}
static toliman_status object(attempt *a) {
    return parse(a, "{\"t\": \"2028-03-01T12:00:00.25\", \"a-column-with-a-long-name\": 2.5}\n");
}
static toliman_status names(attempt *a) {
    return parse(a, "another-column-with-a-long-name,t\n");
}
static toliman_status get_info(attempt *a) {
    return toliman_series_get_info(a->object, (toliman_series_info *)a->out);
}
#define PARSE .function = "toliman_series_parse", .of = &parsers, .struct_size = sizeof(toliman_series_sample)

static const scenario all[] = {
    {.function = "toliman_series_create", .call = create, .made = &parsers},
    {.function = "toliman_series_destroy", .call = destroy, .make = make, .of = &parsers},
    {PARSE, .variant = "columns", .call = columns, .make = make},
    {PARSE, .variant = "object", .call = object, .make = make_empty},
    {PARSE, .variant = "names", .call = names, .make = make_empty, .refused = TOLIMAN_E_MISMATCH},
    {.function = "toliman_series_get_info",
     .call = get_info,
     .make = make,
     .of = &parsers,
     .struct_size = sizeof(toliman_series_info)},
};
SCENARIO_LIST(series_scenarios, all);
