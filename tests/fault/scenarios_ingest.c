/* ingest.h: pairs of files. Four lines, of which the third is malformed and the fourth has no pixels. */
#include <stdio.h>
#include <string.h>

#include "assert_close.h"
#include "scenario.h"

enum { SIDE = 4, PIXELS = SIDE * SIDE };

static void put_pair(void) {
    char text[2000] = "";
    uint16_t pixels[3 * PIXELS];
    for (int i = 0; i < 4; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text),
                 "{\"frame_id\": %d, \"timestamp_ns\": %d, \"host_time\": 0, \"nframes_dropped\": 0, \"roi_label\": "
                 "\"a-region-with-a-long-name\", \"n_rows\": %s, \"n_cols\": 4, \"session_id\": \"day1\", "
                 "\"on_target_s\": [0, 0.25, 0.5, 1]}\n",
                 i, 5 - i, i == 2 ? "null" : "4");
    for (size_t i = 0; i < 3 * PIXELS; i++)
        pixels[i] = (uint16_t)i;
    write_file("day1_meta.jsonl", text, strlen(text));
    write_file("day1_frames.bin", pixels, sizeof pixels);
}

static toliman_status open_pair(uint32_t flags, toliman_ingest **out) {
    toliman_ingest_options options = TOLIMAN_INGEST_OPTIONS_INIT;
    options.pixel = TOLIMAN_PIXEL_U16;
    options.flags = flags;
    options.buffers = 2;
    options.exposure_s = 1;
    return toliman_ingest_create(in_folder("day1"), &options, out);
}

/* Event and frame as numbers that do not depend on addresses: out[64]. */
static toliman_status next_into(toliman_ingest *ingest, unsigned char *out) {
    toliman_frame frame = TOLIMAN_FRAME_INIT;
    toliman_ingest_event event = TOLIMAN_INGEST_EVENT_INIT;
    const toliman_status status = toliman_ingest_next(ingest, &frame, &event);
    if (status != TOLIMAN_OK)
        return status;
    const int64_t numbers[] = {event.event, event.reason, event.line, event.has_key, frame.frame_id, frame.camera_ns};
    memcpy(out, numbers, sizeof numbers);
    uint64_t hash = fnv1a(FNV_START, event.text, strlen(event.text));
    if (frame.pixels != NULL)
        hash = fnv1a(hash, frame.pixels, sizeof(uint16_t) * PIXELS);
    if (frame.intervals != NULL)
        hash = fnv1a(hash, frame.intervals, 2 * frame.interval_count * sizeof *frame.intervals);
    memcpy(out + sizeof numbers, &hash, sizeof hash);
    return status;
}

static toliman_ingest *make_after(uint32_t flags, int events) {
    toliman_ingest *ingest = NULL;
    unsigned char ignored[64];
    put_pair();
    assert_ok(open_pair(flags, &ingest));
    for (int i = 0; i < events; i++)
        assert_ok(next_into(ingest, ignored));
    return ingest;
}

static void *make(void) {
    return make_after(0, 0);
}
static void *make_second(void) { /* whose first frame was read */
    return make_after(TOLIMAN_INGEST_GROWING, 1);
}
static void *make_grown(void) { /* the pixels of the last line arrive after a NOTHING */
    toliman_ingest *const ingest = make_after(TOLIMAN_INGEST_GROWING, 4);
    uint16_t pixels[4 * PIXELS] = {0};
    write_file("day1_frames.bin", pixels, sizeof pixels);
    return ingest;
}
static void *make_finished(void) { /* with lines left over */
    toliman_ingest *const ingest = make_after(TOLIMAN_INGEST_GROWING, 5);
    assert_ok(toliman_ingest_finish(ingest));
    return ingest;
}

static void end(void *ingest) {
    toliman_ingest_destroy(ingest);
}

/* Events that were reported; lines that were read are not promised. */
static uint64_t digest(const void *ingest) {
    toliman_ingest_info info = TOLIMAN_INGEST_INFO_INIT;
    assert_ok(toliman_ingest_get_info(ingest, &info));
    const int64_t counts[] = {info.frames, info.damaged, info.warnings, info.skipped};
    return fnv1a(FNV_START, counts, sizeof counts);
}

static const object_kind readers = {end, digest};

static toliman_status create(attempt *a) {
    return open_pair(0, (toliman_ingest **)&a->made);
}
static toliman_status destroy(attempt *a) {
    toliman_ingest_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status next(attempt *a) {
    return next_into(a->object, a->out);
}
static toliman_status finish(attempt *a) {
    return toliman_ingest_finish(a->object);
}
/* The second frame is searched in a file that has lost a line: it is found elsewhere, or not at all. */
static void *make_short(void) {
    toliman_ingest *ingest = NULL;
    unsigned char ignored[64];
    put_pair();
    uint16_t pixels[4 * PIXELS];
    for (size_t i = 0; i < 4 * PIXELS; i++)
        pixels[i] = (uint16_t)(i < PIXELS || i >= 2 * PIXELS ? i % PIXELS : 7);
    write_file("day1_frames.bin", pixels, sizeof pixels - 2 * PIXELS);
    assert_ok(open_pair(0, &ingest));
    assert_ok(next_into(ingest, ignored));
    return ingest;
}
static toliman_status find_frame(attempt *a) {
    uint16_t pixels[PIXELS], found[PIXELS];
    for (size_t i = 0; i < PIXELS; i++)
        pixels[i] = (uint16_t)i;
    toliman_frame reference = TOLIMAN_FRAME_INIT;
    reference.pixel = TOLIMAN_PIXEL_U16;
    reference.rows = reference.cols = SIDE;
    reference.pixels = pixels;
    int64_t shift = -1;
    const toliman_status status =
        toliman_ingest_find_frame(a->object, 2 * PIXELS, &reference, found, sizeof found, &shift);
    must(status == TOLIMAN_OK || shift == -1, "an output of a failure");
    if (status == TOLIMAN_OK)
        memcpy(a->out, &shift, sizeof shift);
    return status;
}
static toliman_status set_shift(attempt *a) {
    return toliman_ingest_set_shift(a->object, 2);
}
static toliman_status get_info(attempt *a) {
    toliman_ingest_info info = TOLIMAN_INGEST_INFO_INIT;
    const toliman_status status = toliman_ingest_get_info(a->object, &info);
    must(strcmp(info.side_file, in_folder("day1_meta.jsonl")) == 0, "the path of the side file");
    info.side_file = info.pixel_file = NULL;
    memcpy(a->out, &info, sizeof info);
    return status;
}
static const scenario all[] = {
    {.function = "toliman_ingest_create", .call = create, .made = &readers, .stage = put_pair},
    {.function = "toliman_ingest_destroy", .call = destroy, .make = make_second, .of = &readers},
    {.function = "toliman_ingest_next", .call = next, .make = make, .of = &readers},
    {.function = "toliman_ingest_next", "warning", next, make_second, &readers},
    {.function = "toliman_ingest_next", "growth", next, make_grown, &readers},
    {.function = "toliman_ingest_next", "the end", next, make_finished, &readers},
    {.function = "toliman_ingest_finish", .call = finish, .make = make_second, .of = &readers},
    {.function = "toliman_ingest_find_frame", .call = find_frame, .make = make_short, .of = &readers},
    {.function = "toliman_ingest_set_shift", .call = set_shift, .make = make_second, .of = &readers},
    {.function = "toliman_ingest_get_info", .call = get_info, .make = make_second, .of = &readers},
};
SCENARIO_LIST(ingest_scenarios, all);
