/* Tests a bank of networks as the estimator of a tracker: the values of toliman_bank_encode at the frames' times, the
 * same bits for any order, number of threads and restart, covariances, other banks, and options that do not fit. */
enum { SIDE = 256, PIXELS = SIDE * SIDE, FRAMES = 24, ARRIVING = 6, NF = 20, INTERVAL_DAYS = 10 };
#include "track_moving.h"

static toliman_bank *bank, *weak; /* of two dates; weak: an efficiency of 0.6 */
static char folder[256], shard[256];

static toliman_bank *untrained(uint32_t steps) {
    toliman_bank *made = NULL;
    toliman_bank_options options = TOLIMAN_BANK_OPTIONS_INIT;
    options.places = 1;
    options.steps = steps;
    assert_ok(toliman_bank_create(fit, &options, &made));
    return made;
}

static toliman_bank *trained(uint32_t steps) {
    toliman_bank *const made = untrained(steps);
    assert_ok(toliman_bank_train(made, fit, NULL));
    return made;
}

FIXTURE(set_up) {
    char *text = EDITED(kBinaryScene,
                        {"{\"separation_arcsec\": 4, \"position_angle_deg\": 30}",
                         "{\"date\": 2027, \"orbit\": \"alpha-cen\", \"moving\": true}"},
                        {"[64, 64], \"pixel_scale_arcsec\": 0.2", "[256, 256], \"pixel_scale_arcsec\": 0.4"},
                        {"\"pupil_samples\": 96", "\"pupil_samples\": 144"},
                        {"\"frames\": 100, \"interval_days\": 2", "\"frames\": 24, \"interval_days\": 10"});
    sim = sim_of(text);
    free(text);
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, NULL, &fit));
    assert_ok(toliman_sim_frame(sim, NULL, 3, 0, FRAMES, frames));
    bank = trained(100);
    weak = trained(30);
    return 0;
}

FIXTURE(tear_down) {
    toliman_bank_destroy(weak), toliman_bank_destroy(bank), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
    return 0;
}

FIXTURE(make_places) {
    make_folder(folder, sizeof folder);
    make_folder(shard, sizeof shard);
    return 0;
}

FIXTURE(remove_places) {
    remove_folder(folder);
    remove_folder(shard);
    return 0;
}

static toliman_track_options options_of(const char *place, const toliman_bank *estimator) {
    toliman_track_options options = moving_options(place);
    options.estimator.bank = estimator;
    return options;
}

static toliman_track_record record_of(const toliman_track *track, int64_t number) {
    toliman_track_record record = {.struct_size = sizeof record};
    size_t done;
    assert_ok(toliman_track_get_records(track, number, 1, &record, &done));
    assert_int_equal(done, 1);
    return record;
}

TEST(values_are_those_of_the_bank_at_the_frames_times) {
    const toliman_track_options options = options_of(NULL, weak);
    toliman_track *const track = opened(&options);
    for (int i = 0; i < ARRIVING; i++) { /* the last one after the dates of the bank */
        const toliman_fit_prediction prediction = {.struct_size = sizeof prediction,
                                                   .time_days = (i < ARRIVING - 1 ? i : 30) * INTERVAL_DAYS};
        toliman_bank_result result = {.struct_size = sizeof result};
        toliman_fit_result fitted = {.struct_size = sizeof fitted}, same = {.struct_size = sizeof same};
        double covariance[7 * 7];
        toliman_frame frame = frame_of(i);
        toliman_track_outcome outcome = {.struct_size = sizeof outcome};
        size_t done;
        assert_ok(toliman_bank_encode(weak, fit, PLAIN_IMAGE(frame.pixels), 1, &prediction, &result, &fitted));
        assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(frame.pixels), 1, &prediction, &same, NULL, covariance));
        frame.camera_ns = EPOCH_NS + (int64_t)prediction.time_days * DAY_NS;
        assert_ok(toliman_track_push(track, &frame, 1, &outcome, &done));
        assert_int_equal(outcome.verdict, TOLIMAN_TRACK_VERDICT_ACCEPTED);
        assert_true(outcome.value == result.displacement_px && outcome.chi_square == fitted.chi_square);
        assert_true(record_of(track, i).sigma == result.sigma_px);
        assert_int_equal(result.flags & TOLIMAN_BANK_OUTSIDE, i < ARRIVING - 1 ? 0 : TOLIMAN_BANK_OUTSIDE);
        assert_true(result.flags & TOLIMAN_BANK_LOW_EFFICIENCY);
        assert_true(cell(track, "flags", i) == fitted.flags + TOLIMAN_TRACK_BANK_FLAGS * result.flags);
        assert_true(cell(track, "separation_px", i) == result.separation_px);
        assert_true(cell(track, "fit_separation_px", i) == fitted.separation_px);
        assert_true(cell(track, "x_px", i) == fitted.x_px && cell(track, "y_px", i) == fitted.y_px);
        const double variance = result.sigma_px * result.sigma_px;
        assert_true(cell(track, "cov_value_separation_px", i) == variance);
        assert_true(cell(track, "cov_separation_px_separation_px", i) == variance);
        assert_true(cell(track, "cov_value_fit_separation_px", i) == covariance[0]);
        assert_true(cell(track, "cov_fit_separation_px_fit_separation_px", i) == covariance[0]);
        assert_true(cell(track, "cov_value_y_px", i) == covariance[3]);
        assert_true(cell(track, "cov_x_px_y_px", i) == covariance[2 * 7 + 3]);
        assert_true(cell(track, "cov_x_px_fit_separation_px", i) == covariance[2 * 7]);
        assert_close(sqrt(covariance[0]) / result.sigma_px, result.efficiency, 1e-9, 0);
    }
    toliman_track_info info = {.struct_size = sizeof info};
    toliman_bank_info made = {.struct_size = sizeof made};
    toliman_fit_info of_fit = {.struct_size = sizeof of_fit};
    assert_ok(toliman_track_get_info(track, &info));
    assert_ok(toliman_bank_get_info(weak, &made));
    assert_ok(toliman_fit_get_info(fit, &of_fit));
    assert_true(info.estimator_id == made.digest && made.digest != of_fit.digest);
    toliman_track_options known = {.struct_size = sizeof known};
    assert_ok(toliman_track_get_options(track, &known));
    assert_string_equal(known.estimator.values, "separation_px x_px y_px fit_separation_px");
    assert_null(known.estimator.bank);
    toliman_track_destroy(track);
}

/* An efficient estimate has the same covariance with itself as with any other unbiased one, so that their difference
 * has the difference of the variances. */
TEST(the_covariances_predict_how_network_and_fit_differ) {
    const toliman_track_options options = options_of(NULL, weak);
    toliman_track *const track = opened(&options);
    double sum = 0;
    for (int i = 0; i < FRAMES; i++) {
        toliman_track_outcome outcome;
        push(track, &i, 1, &outcome);
        const double difference = cell(track, "separation_px", i) - cell(track, "fit_separation_px", i);
        sum += difference * difference /
               (cell(track, "cov_separation_px_separation_px", i) - 2 * cell(track, "cov_value_fit_separation_px", i) +
                cell(track, "cov_fit_separation_px_fit_separation_px", i));
    }
    assert_close(sum / FRAMES, 1, 0, 3 * sqrt(2.0 / FRAMES));
    toliman_track_destroy(track);
}

/* promise: arrival-order-changes-no-bit */
TEST_WITH(order_threads_restarts_and_merges_change_no_bit, make_places, remove_places) {
    const int orders[][ARRIVING] = {{0, 1, 2, 3, 4, 5}, {5, 2, 0, 4, 1, 3}};
    double expected[NF], found[NF];
    toliman_track_outcome outcomes[ARRIVING];
    for (int order = 0; order < 2; order++) {
        toliman_track_options options = options_of(NULL, bank);
        options.threads = order == 0 ? 1 : 3;
        toliman_track *const track = opened(&options);
        push(track, orders[order], ARRIVING, outcomes);
        powers_of(track, order == 0 ? expected : found);
        toliman_track_destroy(track);
    }
    assert_memory_equal(found, expected, sizeof found);
    toliman_track_options options = options_of(shard, bank);
    toliman_track *track = opened(&options);
    push(track, orders[1] + 4, 2, outcomes);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    options = options_of(folder, bank);
    track = opened(&options);
    push(track, orders[1], 2, outcomes);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    options = (toliman_track_options){.struct_size = sizeof options};
    assert_ok(toliman_track_load_options(folder, &options));
    options.estimator.fit = fit;
    options.estimator.bank = bank;
    options.flags |= TOLIMAN_TRACK_REBUILD;
    track = opened(&options);
    push(track, orders[1] + 2, 2, outcomes);
    assert_ok(toliman_track_merge(track, shard, 0, NULL));
    powers_of(track, found);
    toliman_track_destroy(track);
    assert_memory_equal(found, expected, sizeof found);
}

TEST(a_frame_without_a_fit_is_rejected) {
    const toliman_track_options options = options_of(NULL, bank);
    assert_empty_rejected(&options);
}

/* promise: estimators-are-not-mixed */
TEST_WITH(other_estimators_are_refused, make_places, remove_places) {
    toliman_track_outcome outcome;
    toliman_track_options options = options_of(folder, bank);
    toliman_track *track = opened(&options), *refused = NULL;
    push(track, (int[]){1}, 1, &outcome);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);
    options.estimator.bank = weak;
    assert_fails(toliman_track_create(&options, &refused), TOLIMAN_E_MISMATCH, "ledger.tlml: ");
    options.estimator.bank = NULL;
    assert_fails(toliman_track_create(&options, &refused), TOLIMAN_E_MISMATCH, "ledger.tlml: written with ");
    options = options_of(shard, weak);
    track = opened(&options);
    assert_fails(toliman_track_merge(track, folder, 0, NULL), TOLIMAN_E_MISMATCH, "ledger.tlml: written with ");
    toliman_track_destroy(track);
    assert_null(refused);
}

TEST(options_that_do_not_fit_are_refused) {
    toliman_track *track = NULL;
    toliman_track_options options = options_of(NULL, bank);
    options.estimator.fit = NULL;
    assert_invalid(toliman_track_create(&options, &track), "options->estimator.bank");
    toliman_fit *other = NULL;
    const toliman_fit_options wider = {.struct_size = sizeof wider, .free = "scale"};
    assert_ok(toliman_fit_create((const toliman_sim *[]){sim}, NULL, 1, &wider, &other));
    options.estimator.fit = other;
    assert_refused(toliman_track_create(&options, &track), TOLIMAN_E_MISMATCH, "options->estimator.bank");
    toliman_fit_destroy(other);
    options = options_of(NULL, bank);
    strcpy(options.estimator.values, "separation_px,x_px,y_px");
    assert_invalid(toliman_track_create(&options, &track), "options->estimator.values");
    toliman_bank *const control = untrained(30);
    options = options_of(NULL, control);
    assert_fails(toliman_track_create(&options, &track), TOLIMAN_E_ARGUMENT,
                 "options->estimator.bank: network 0 of 2 ");
    toliman_bank_destroy(control);
    assert_null(track);
}

RUN_TESTS(set_up, tear_down)
