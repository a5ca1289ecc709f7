/* Tests the fit of a moving scene as the estimator of a tracker: the values of single fits at the frames' times, the
 * same bits for any order, number of threads and restart, columns of the ledger, and frames that are rejected. */
enum { SIDE = 64, PIXELS = SIDE * SIDE, FRAMES = 6, ARRIVING = FRAMES, NF = 20, INTERVAL_DAYS = 50 };
#include "track_moving.h"

static char folder[256];

FIXTURE(set_up) {
    char *text = EDITED(kBinaryScene,
                        {"{\"separation_arcsec\": 4, \"position_angle_deg\": 30}",
                         "{\"date\": 2027, \"orbit\": \"alpha-cen\", \"moving\": true}"},
                        {"\"pixel_scale_arcsec\": 0.2", "\"pixel_scale_arcsec\": 0.4"},
                        {"\"frames\": 100, \"interval_days\": 2", "\"frames\": 6, \"interval_days\": 50"});
    sim = sim_of(text);
    free(text);
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, NULL, &fit));
    assert_ok(toliman_sim_frame(sim, NULL, 3, 0, FRAMES, frames));
    return 0;
}

FIXTURE(tear_down) {
    toliman_fit_destroy(fit), toliman_sim_destroy(sim);
    return 0;
}

FIXTURE(make_place) {
    make_folder(folder, sizeof folder);
    return 0;
}

FIXTURE(remove_place) {
    remove_folder(folder);
    return 0;
}

static toliman_track_options options_of(const char *place, const toliman_fit *estimator) {
    toliman_track_options options = moving_options(place);
    options.estimator.fit = estimator;
    return options;
}

TEST(values_are_those_of_fits_at_the_frames_times) {
    const toliman_track_options options = options_of(NULL, fit);
    toliman_track *const track = opened(&options);
    for (int i = 0; i < FRAMES; i++) {
        const toliman_fit_prediction prediction = {.struct_size = sizeof prediction, .time_days = i * INTERVAL_DAYS};
        toliman_fit_result result = {.struct_size = sizeof result};
        double values[7], covariance[7 * 7];
        toliman_track_outcome outcome;
        toliman_track_record record = {.struct_size = sizeof record};
        size_t done;
        assert_ok(
            toliman_fit_frame(fit, PLAIN_IMAGE(frames + i * PIXELS), 1, &prediction, &result, values, covariance));
        push(track, &i, 1, &outcome);
        assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
        assert_true(outcome.value == result.displacement_px && outcome.chi_square == result.chi_square);
        assert_ok(toliman_track_get_records(track, i, 1, &record, &done));
        assert_true(record.sigma == result.separation_sigma_px);
        assert_true(cell(track, "flags", i) == result.flags);
        assert_true(cell(track, "separation_px", i) == result.separation_px);
        assert_true(cell(track, "x_px", i) == result.x_px && cell(track, "y_px", i) == result.y_px);
        assert_true(cell(track, "cov_value_separation_px", i) == covariance[0]);
        assert_true(cell(track, "cov_value_x_px", i) == covariance[2]);
        assert_true(cell(track, "cov_separation_px_separation_px", i) == covariance[0]);
        assert_true(cell(track, "cov_separation_px_y_px", i) == covariance[3]);
        assert_true(cell(track, "cov_x_px_y_px", i) == covariance[2 * 7 + 3]);
        assert_true(cell(track, "cov_y_px_y_px", i) == covariance[3 * 7 + 3]);
        assert_true(cell(track, "flux_a", i) == values[4] && cell(track, "flux_b", i) == values[5]);
        assert_true(cell(track, "background", i) == values[6]);
    }
    toliman_track_info info = {.struct_size = sizeof info};
    toliman_fit_info made = {.struct_size = sizeof made};
    double covariance[7 * 7];
    assert_ok(toliman_track_get_info(track, &info));
    assert_ok(toliman_fit_get_info(fit, &made));
    assert_ok(toliman_fit_predict(fit, NULL, NULL, 0, NULL, covariance));
    assert_close(info.sigma, sqrt(covariance[0]) / 2, 1e-6, 0);
    assert_true(info.value_limit == 1e4 * info.sigma && info.estimator_id == made.digest);
    toliman_track_options known = {.struct_size = sizeof known};
    assert_ok(toliman_track_get_options(track, &known));
    assert_string_equal(known.estimator.values, "separation_px x_px y_px");
    assert_null(known.estimator.fit);
    toliman_track_destroy(track);
}

/* A merged folder has the parameters of its frames, a ledger without such columns goes without. */
TEST_WITH(parameters_follow_their_frames, make_place, remove_place) {
    char other[300];
    toliman_track_outcome outcomes[FRAMES];
    toliman_track_options options = options_of(folder, fit);
    toliman_track *const track = opened(&options);
    push(track, (int[]){0, 1, 2}, 3, outcomes);
    assert_ok(toliman_track_commit(track));
    const double expected = cell(track, "flux_b", 1);
    assert_true(isfinite(expected));
    for (int has_columns = 0; has_columns < 2; has_columns++) {
        options = (toliman_track_options){.struct_size = sizeof options};
        assert_ok(toliman_track_load_options(folder, &options));
        snprintf(other, sizeof other, "%s/merged%d", folder, has_columns);
        options.folder = other;
        options.ledger.setup_folder = has_columns ? folder : NULL;
        toliman_track *const merged = opened(&options);
        assert_ok(toliman_track_merge(merged, folder, 0, NULL));
        assert_true(cell(merged, "x_px", 1) == cell(track, "x_px", 1));
        double found = 0;
        size_t done = 0;
        const toliman_status status = toliman_track_get_column(merged, "flux_b", 1, 1, &found, &done);
        assert_int_equal(status, has_columns ? TOLIMAN_OK : TOLIMAN_E_NOT_FOUND);
        assert_true(!has_columns || found == expected);
        toliman_track_destroy(merged);
        remove_folder(other);
    }
    toliman_track_destroy(track);
}

/* promise: arrival-order-changes-no-bit */
TEST_WITH(order_threads_and_restarts_change_no_bit, make_place, remove_place) {
    const int orders[][FRAMES] = {{0, 1, 2, 3, 4, 5}, {5, 2, 0, 4, 1, 3}};
    double expected[20], found[20];
    toliman_track_outcome outcomes[FRAMES];
    for (int order = 0; order < 2; order++)
        for (uint32_t threads = 1; threads < 4; threads += 2) {
            toliman_track_options options = options_of(NULL, fit);
            options.threads = threads;
            toliman_track *const track = opened(&options);
            push(track, orders[order], FRAMES, outcomes);
            powers_of(track, order == 0 && threads == 1 ? expected : found);
            assert_true((order == 0 && threads == 1) || memcmp(found, expected, sizeof found) == 0);
            toliman_track_destroy(track);
        }
    /* The folder's own options, whose grid is that of its setup, and a grid that the folder provides. */
    toliman_track_options options = options_of(folder, fit);
    for (int part = 0; part < 3; part++) {
        toliman_track *const track = opened(&options);
        push(track, &orders[1][2 * part], 2, outcomes);
        assert_ok(toliman_track_save(track));
        if (part == 2)
            powers_of(track, found);
        toliman_track_destroy(track);
        if (part == 0) {
            options = (toliman_track_options){.struct_size = sizeof options};
            assert_ok(toliman_track_load_options(folder, &options));
            options.estimator.fit = fit;
        } else {
            options.grid.nf = 0;
            options.grid.time_offset_ns = 0;
        }
    }
    assert_memory_equal(found, expected, sizeof found);
}

TEST(a_frame_without_a_fit_is_rejected) {
    const toliman_track_options options = options_of(NULL, fit);
    assert_empty_rejected(&options);
}

/* promise: estimators-are-not-mixed */
TEST_WITH(other_estimators_are_refused, make_place, remove_place) {
    toliman_track_options options = options_of(folder, fit);
    toliman_track *track = opened(&options);
    toliman_track_destroy(track);
    track = NULL;
    toliman_fit *other = NULL;
    const toliman_fit_options wider = {.struct_size = sizeof wider, .free = "scale"};
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &wider, &other));
    options.estimator.fit = other;
    assert_fails(toliman_track_create(&options, &track), TOLIMAN_E_MISMATCH, "ledger.tlml: written with ");
    options = options_of(NULL, fit);
    strcpy(options.estimator.values, "dx");
    assert_invalid(toliman_track_create(&options, &track), "options->estimator.values");
    options = options_of(NULL, fit);
    options.frames.image_rows = 32;
    assert_invalid(toliman_track_create(&options, &track), "options->frames.image_rows");
    toliman_linear *linear = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    options = options_of(NULL, fit);
    options.estimator.linear = linear;
    assert_invalid(toliman_track_create(&options, &track), "options");
    assert_null(track);
    toliman_linear_destroy(linear), toliman_fit_destroy(other);
}

RUN_TESTS(set_up, tear_down)
