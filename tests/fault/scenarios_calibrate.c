/* calibrate.h */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "images.h"
#include "scenario.h"

static const char kFolder[] = "calibration", kSaved[] = "calibration/fitted.json", kJournal[] = "calibration/c.part";

static toliman_status create_with(const char *names, const char *journal, void **out) {
    const toliman_calibration_options options = {.struct_size = sizeof options,
                                                 .free = names,
                                                 .threads = 2,
                                                 .capture_px = 3,
                                                 .most_iterations = 4,
                                                 .journal = journal};
    return toliman_calibration_create(small_sim(), PLAIN_IMAGE(small_frames()), 2, NULL, &options,
                                      (toliman_calibration **)out);
}

static void *make(void) {
    void *made = NULL;
    assert_ok(create_with("scale", NULL, &made));
    return made;
}

static const toliman_calibration *calibration(void) {
    static void *made;
    return made != NULL ? made : (made = make());
}

static void end(void *made) {
    toliman_calibration_destroy(made);
}

static uint64_t digest(const void *made) {
    toliman_calibration_info info = {.struct_size = sizeof info};
    toliman_calibration_value value = {.struct_size = sizeof value};
    toliman_fit_result frame = {.struct_size = sizeof frame};
    assert_ok(toliman_calibration_get_info(made, &info));
    assert_ok(toliman_calibration_get_value(made, 0, 0, &value));
    assert_ok(toliman_calibration_get_frame(made, 1, &frame));
    const double numbers[] = {value.value, value.sigma, value.prior_sigma};
    return fnv1a(fnv1a(fnv1a(FNV_START, &info, sizeof info), &frame, sizeof frame), numbers, sizeof numbers);
}

static const object_kind calibrations = {end, digest};

static toliman_status calibrate(attempt *a) {
    return create_with("scale", NULL, &a->made);
}
static toliman_status calibrate_with_journal(attempt *a) {
    return create_with("scale", in_folder(kJournal), &a->made);
}
static int32_t stop(const toliman_calibration *so_far, const toliman_calibration_step *step, void *unused) {
    (void)so_far, (void)step, (void)unused;
    return 1;
}
static toliman_status cancel(attempt *a) {
    const toliman_calibration_options options = {.struct_size = sizeof options, .free = "scale", .step = stop};
    return toliman_calibration_create(small_sim(), PLAIN_IMAGE(small_frames()), 2, NULL, &options,
                                      (toliman_calibration **)&a->made);
}
static toliman_status destroy(attempt *a) {
    toliman_calibration_destroy(a->object);
    a->object = NULL;
    return TOLIMAN_OK;
}
static toliman_status get_info(attempt *a) {
    return toliman_calibration_get_info(calibration(), (void *)a->out);
}
static toliman_status get_value(attempt *a) {
    return toliman_calibration_get_value(calibration(), 0, 0, (void *)a->out);
}
static toliman_status get_covariance(attempt *a) {
    return toliman_calibration_get_covariance(calibration(), 0, (double *)a->out);
}
static toliman_status get_frame(attempt *a) {
    return toliman_calibration_get_frame(calibration(), 1, (void *)a->out);
}
static toliman_status get_window(attempt *a) {
    return toliman_calibration_get_window(calibration(), 0, (void *)a->out);
}
static toliman_status get_opd(attempt *a) {
    return toliman_calibration_get_opd(calibration(), 0, (double *)a->out);
}
static toliman_status get_image(attempt *a) {
    return toliman_calibration_get_image(calibration(), TOLIMAN_CALIBRATION_IMAGE_AFTER, (double *)a->out, SMALL);
}
static toliman_status save_file(attempt *a) {
    (void)a;
    return toliman_calibration_save_file(calibration(), 0, in_folder(kSaved));
}

/* The calibration tried nothing, and left nothing out. */
static toliman_status get_attempt(attempt *a) {
    (void)a;
    toliman_calibration_attempt out = TOLIMAN_CALIBRATION_ATTEMPT_INIT;
    return toliman_calibration_get_attempt(calibration(), 0, &out);
}
static toliman_status get_left_out(attempt *a) {
    (void)a;
    toliman_calibration_left_out out = TOLIMAN_CALIBRATION_LEFT_OUT_INIT;
    return toliman_calibration_get_left_out(calibration(), 0, &out);
}
static toliman_status change_name(attempt *a) {
    (void)a;
    must(strcmp(toliman_constant_name(TOLIMAN_CALIBRATION_CHANGE_EDGES), "mask edges") == 0, "change_name");
    return TOLIMAN_OK;
}

static void put_all(void) {
    (void)small_frames();
    (void)calibration();
}

static void put_old(void) {
    put_all();
    empty_folder(kFolder);
    write_file(kSaved, "old", 3);
}

static void no_journal(void) {
    put_all();
    empty_folder(kFolder);
}

/* The journal of a calibration with fewer iterations. */
static void put_journal(void) {
    static saved_file journal;
    no_journal();
    if (journal.size == 0) {
        toliman_calibration *made = NULL;
        const toliman_calibration_options options = {.struct_size = sizeof options,
                                                     .free = "scale",
                                                     .capture_px = 3,
                                                     .most_iterations = 1,
                                                     .journal = in_folder(kJournal)};
        assert_ok(toliman_calibration_create(small_sim(), PLAIN_IMAGE(small_frames()), 2, NULL, &options, &made));
        toliman_calibration_destroy(made);
        keep_file(kJournal, &journal);
    }
    put_file_again(kJournal, &journal);
}

static void check_journal(attempt *a, toliman_status status) {
    (void)a, (void)status;
    must_begin_as_put(kJournal);
}

static void check_saved(attempt *a, toliman_status status) {
    (void)a;
    must_be_old_or_new(kFolder, kSaved, "\"calibration\"", status);
}

static const scenario all[] = {
    {.function = "toliman_calibration_create", .call = calibrate, .made = &calibrations, .stage = put_all, .slow = 1},
    {.function = "toliman_calibration_create",
     "new journal",
     calibrate_with_journal,
     .made = &calibrations,
     .stage = no_journal,
     .slow = 1},
    {.function = "toliman_calibration_create",
     "journal",
     calibrate_with_journal,
     .made = &calibrations,
     .stage = put_journal,
     .check = check_journal,
     .slow = 1},
    {.function = "toliman_calibration_create",
     "cancelled",
     cancel,
     .made = &calibrations,
     .stage = put_all,
     .refused = TOLIMAN_E_CANCELLED,
     .slow = 1},
    {.function = "toliman_calibration_destroy", .call = destroy, .make = make, .of = &calibrations},
    {.function = "toliman_calibration_get_info",
     .call = get_info,
     .stage = put_all,
     .struct_size = sizeof(toliman_calibration_info)},
    {.function = "toliman_calibration_get_value",
     .call = get_value,
     .stage = put_all,
     .struct_size = sizeof(toliman_calibration_value)},
    {.function = "toliman_calibration_get_covariance", .call = get_covariance, .stage = put_all},
    {.function = "toliman_calibration_get_frame",
     .call = get_frame,
     .stage = put_all,
     .struct_size = sizeof(toliman_fit_result)},
    {.function = "toliman_calibration_get_window",
     .call = get_window,
     .stage = put_all,
     .struct_size = sizeof(toliman_calibration_window)},
    {.function = "toliman_calibration_get_attempt", .call = get_attempt, .stage = put_all, .refused = TOLIMAN_E_RANGE},
    {.function = "toliman_calibration_get_left_out",
     .call = get_left_out,
     .stage = put_all,
     .refused = TOLIMAN_E_RANGE},
    {.function = "toliman_constant_name", .call = change_name},
    {.function = "toliman_calibration_get_opd", .call = get_opd, .stage = put_all},
    {.function = "toliman_calibration_get_image", .call = get_image, .stage = put_all},
    {.function = "toliman_calibration_save_file", .call = save_file, .stage = put_old, .check = check_saved, .slow = 1},
};
SCENARIO_LIST(calibrate_scenarios, all);
