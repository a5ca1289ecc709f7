/* Tests banks of networks: dates and places, training with interruptions, estimates against the truth of propagated
 * images and against the scatter of noisy ones, predictions of their accuracy, and flags. */
#include <pthread.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bank_scene.h"
#include "images.h"
#include "test_folder.h"

enum { SIDE = 256, PIXELS = SIDE * SIDE, FRAMES = 51, STEPS = 60 };

static toliman_sim *sim;
static toliman_fit *fit;
static toliman_bank *bank;            /* 2 dates, 1 place */
static double frames[FRAMES][PIXELS]; /* of the cadence, one per day, without a signal */

FIXTURE(set_up) {
    sim = bank_sim(SIDE, SIDE, BANK_ORBIT);
    fit = bank_fit(sim, 3);
    bank = bank_of(fit, 1, 2.5, STEPS);
    train_bank(bank, fit, 0);
    static const double no_signal[FRAMES];
    assert_ok(toliman_sim_frame(sim, no_signal, 7, 0, FRAMES, frames[0]));
    return 0;
}

FIXTURE(tear_down) {
    toliman_bank_destroy(bank), toliman_fit_destroy(fit), toliman_sim_destroy(sim);
    return 0;
}

static toliman_fit_prediction at(double days) {
    return (toliman_fit_prediction){.struct_size = sizeof(toliman_fit_prediction), .time_days = days};
}

static toliman_bank_result encoded(const double *frame, toliman_fit_prediction prediction) {
    toliman_bank_result result = {.struct_size = sizeof result};
    assert_ok(toliman_bank_encode(bank, fit, PLAIN_IMAGE(frame), 1, &prediction, &result, NULL));
    return result;
}

static toliman_bank_result predicted(const toliman_bank *of, const toliman_fit *with,
                                     toliman_fit_prediction prediction) {
    toliman_bank_result result = {.struct_size = sizeof result};
    assert_ok(toliman_bank_predict(of, with, &prediction, &result));
    return result;
}

TEST(plans_match_banks) {
    static const struct {
        toliman_bank_options options;
        uint32_t dates, places;
        double first, last;
    } cases[] = {{{.spacing_px = 2.5, .places = 1}, 2, 1, 0, 50},
                 {{.spacing_px = 0.5, .places = 2, .steps = 30}, 9, 4, 0, 50},
                 {{.places = 1, .first_days = -40, .last_days = -20}, 4, 1, -40, -20},
                 {{.spacing_px = 4}, 2, 9, 0, 50}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_bank_options options = cases[i].options;
        options.struct_size = sizeof options;
        toliman_bank_plan_info plan = {.struct_size = sizeof plan};
        assert_ok(toliman_bank_plan(sim, &options, &plan));
        assert_int_equal(plan.dates, cases[i].dates);
        assert_int_equal(plan.places, cases[i].places);
        assert_int_equal(plan.networks, plan.dates * plan.places);
        assert_close(plan.first_days, cases[i].first, 0, 0);
        assert_close(plan.last_days, cases[i].last, 0, 0);
        assert_true(plan.train_s > 0 && plan.bytes_half > 0);
        assert_int_equal(plan.bytes_float32, 2 * plan.bytes_half);

        toliman_bank *made = NULL;
        size_t size = 0;
        assert_ok(toliman_bank_create(fit, &options, &made));
        const toliman_bank_info info = bank_info_of(made);
        assert_int_equal(info.networks, plan.networks);
        assert_int_equal(info.dates, plan.dates);
        assert_int_equal(info.places, plan.places);
        assert_int_equal(info.trained_networks, 0);
        assert_int_equal(info.steps, options.steps != 0 ? options.steps : 600);
        assert_close(info.spacing_px, options.spacing_px > 0 ? options.spacing_px : 0.5, 0, 0);
        assert_close(info.last_days, plan.last_days, 0, 0);
        if (plan.networks < 10) {
            free(bank_bytes(made, TOLIMAN_CAE_ENCODING_FLOAT32, &size));
            assert_in_range(size, plan.bytes_float32 / 2, plan.bytes_float32 + 1000);
        }
        toliman_bank_destroy(made);
    }
}

/* Order: dates, then places along y, then along x. */
TEST(networks_are_listed) {
    toliman_bank *const many = bank_of(fit, 3, 1, 1);
    const toliman_bank_info info = bank_info_of(many);
    assert_int_equal(info.networks, 9 * info.dates);
    assert_true(info.dates == 5 && info.rows == SIDE && info.cols == SIDE && info.seed == 1);
    assert_string_equal(info.layout, "flight");
    double last = info.first_days;
    for (int64_t i = 0; i < info.networks; i++) {
        const toliman_bank_network network = bank_network_of(many, i);
        assert_true(network.trained == 0);
        assert_close(network.cosine, 0, 0, 0);
        assert_close(network.x_px, (double)(i % 3) / 3 - 1.0 / 3, 0, 1e-15);
        assert_close(network.y_px, (double)(i / 3 % 3) / 3 - 1.0 / 3, 0, 1e-15);
        assert_true(network.first_days < network.days && network.days < network.last_days);
        assert_close(network.first_days, last, 0, 0);
        last = i % 9 == 8 ? network.last_days : last;
    }
    assert_close(last, info.last_days, 0, 0);
    toliman_bank_network network = {.struct_size = sizeof network};
    assert_refused(toliman_bank_get_network(many, -1, &network), TOLIMAN_E_RANGE, "index");
    assert_refused(toliman_bank_get_network(many, 45, &network), TOLIMAN_E_RANGE, "index");
    toliman_bank_destroy(many);
    assert_int_equal(bank_info_of(bank).trained_networks, 2);
    assert_true(bank_network_of(bank, 0).cosine > 0.9 && bank_network_of(bank, 1).trained == 1);
}

static int32_t stop_after_the_first(const char *stage, double fraction, void *calls) {
    assert_true(strncmp(stage, "train: ", 7) == 0 && fraction >= 0 && fraction <= 1);
    ++*(int *)calls;
    return fraction > 0;
}

/* By one or three threads, cancelled between networks and within one, and continued after saving. */
/* promises: bank-training-resumes, stopped-objects-stay-usable */
TEST(interrupted_trainings_give_the_same_bits) {
    enum { FEW = 10 };
    size_t size, again_size;
    toliman_bank *whole = bank_of(fit, 1, 1.5, FEW);
    train_bank(whole, fit, 1);
    uint8_t *const bytes = bank_bytes(whole, 0, &size);
    assert_int_equal(bank_info_of(whole).networks, 3);
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        toliman_bank *part = bank_of(fit, 1, 1.5, FEW);
        int calls = 0;
        const toliman_bank_train_options options = {.struct_size = sizeof options,
                                                    .threads = threads,
                                                    .progress = stop_after_the_first,
                                                    .progress_data = &calls};
        toliman_bank_train_options first = options;
        first.threads = 1;
        assert_refused(toliman_bank_train(part, fit, &first), TOLIMAN_E_CANCELLED, "");
        assert_int_equal(calls, FEW + 1);
        assert_int_equal(bank_info_of(part).trained_networks, 1);
        assert_refused(toliman_bank_train(part, fit, &options), TOLIMAN_E_CANCELLED, "");
        assert_true(calls > FEW + 1);
        uint8_t *const saved = bank_bytes(part, 0, &again_size);
        toliman_bank_destroy(part);
        part = bank_from(saved, again_size);
        assert_true(bank_info_of(part).trained_networks < 3);
        train_bank(part, fit, threads);
        free(saved);
        assert_bank_bytes(part, 0, bytes, size);
        assert_true(bank_info_of(part).digest == bank_info_of(whole).digest);
        toliman_bank_destroy(part);
    }
    int calls = 0; /* there is nothing left to do or to cancel */
    const toliman_bank_train_options complete = {
        .struct_size = sizeof complete, .progress = stop_after_the_first, .progress_data = &calls};
    assert_ok(toliman_bank_train(whole, fit, &complete));
    assert_int_equal(calls, 1);
    assert_bank_bytes(whole, 0, bytes, size);
    free(bytes), toliman_bank_destroy(whole);
}

/* A bank whose training was cancelled is made again: its journal has the networks that were complete. */
/* promise: bank-training-resumes */
TEST(journals_continue_trainings) {
    enum { FEW = 10 };
    char path[300], journal_folder[256];
    size_t size;
    make_folder(journal_folder, sizeof journal_folder);
    snprintf(path, sizeof path, "%s/b.part", journal_folder);
    toliman_bank *const whole = bank_of(fit, 1, 1.5, FEW);
    train_bank(whole, fit, 1);
    uint8_t *const bytes = bank_bytes(whole, 0, &size);
    toliman_bank *part = bank_of(fit, 1, 1.5, FEW);
    int calls = 0;
    toliman_bank_train_options options = {.struct_size = sizeof options,
                                          .threads = 1,
                                          .progress = stop_after_the_first,
                                          .progress_data = &calls,
                                          .journal = path};
    assert_refused(toliman_bank_train(part, fit, &options), TOLIMAN_E_CANCELLED, "");
    toliman_bank_destroy(part);

    for (int i = 0; i < 2; i++) { /* other dates, another number of steps */
        part = bank_of(fit, 1, i == 0 ? 1 : 1.5, i == 0 ? FEW : FEW + 1);
        assert_fails(toliman_bank_train(part, fit, &options), TOLIMAN_E_MISMATCH, i == 0 ? "dates" : "steps");
        assert_string_equal(toliman_last_error_field(), path);
        toliman_bank_destroy(part);
    }
    part = bank_of(fit, 1, 1.5, FEW);
    options.progress = NULL;
    assert_ok(toliman_bank_train(part, fit, &options));
    assert_bank_bytes(part, 0, bytes, size);
    assert_true(bank_info_of(part).digest == bank_info_of(whole).digest);
    toliman_bank_destroy(part);

    /* Only recalled, and with a damaged end. */
    struct stat file;
    for (int damaged = 0; damaged < 2; damaged++) {
        assert_int_equal(stat(path, &file), 0);
        assert_int_equal(truncate(path, file.st_size - damaged), 0);
        part = bank_of(fit, 1, 1.5, FEW);
        calls = 0;
        options.progress = damaged ? NULL : stop_after_the_first;
        assert_ok(toliman_bank_train(part, fit, &options));
        assert_int_equal(calls, damaged ? 0 : 1);
        assert_bank_bytes(part, 0, bytes, size);
        toliman_bank_destroy(part);
    }
    free(bytes), toliman_bank_destroy(whole);
    remove_folder(journal_folder);
}

/* Frames in one call, on any number of threads and in any order, give the bits of single calls. */
/* promise: bank-results-ignore-others */
TEST(all_calls_give_the_same_bits) {
    enum { MANY = 5 };
    static double backwards[MANY][PIXELS];
    toliman_fit_prediction predictions[MANY], reversed[MANY];
    toliman_bank_result alone[MANY], together[MANY];
    toliman_fit_result fits_alone[MANY], fits[MANY];
    for (int i = 0; i < MANY; i++) {
        predictions[i] = reversed[MANY - 1 - i] = at(10 * i);
        memcpy(backwards[MANY - 1 - i], frames[10 * i], sizeof *backwards);
        alone[i] = (toliman_bank_result){.struct_size = sizeof *alone};
        fits_alone[i] = (toliman_fit_result){.struct_size = sizeof *fits_alone};
        assert_ok(
            toliman_bank_encode(bank, fit, PLAIN_IMAGE(frames[10 * i]), 1, &predictions[i], &alone[i], &fits_alone[i]));
        toliman_fit_result plain = {.struct_size = sizeof plain};
        assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(frames[10 * i]), 1, &predictions[i], &plain, NULL, NULL));
        assert_memory_equal(&plain, &fits_alone[i], sizeof plain);
        assert_int_equal(alone[i].flags & TOLIMAN_BANK_NOT_FITTED, 0);
        assert_int_equal(alone[i].network, i > 2);
    }
    size_t size;
    uint8_t *const bytes = bank_bytes(bank, 0, &size);
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        const toliman_load_options options = {.struct_size = sizeof options, .threads = threads};
        toliman_bank *copy = NULL;
        assert_ok(toliman_bank_load(bytes, size, &options, &copy));
        memset(together, 0x5a, sizeof together);
        together[0].struct_size = sizeof *together;
        fits[0].struct_size = sizeof *fits;
        assert_ok(toliman_bank_encode(copy, fit, PLAIN_IMAGE(backwards), MANY, reversed, together, fits));
        toliman_bank_destroy(copy);
        for (int i = 0; i < MANY; i++) {
            assert_memory_equal(&together[MANY - 1 - i], &alone[i], sizeof *alone);
            assert_memory_equal(&fits[MANY - 1 - i], &fits_alone[i], sizeof *fits);
        }
    }
    free(bytes);
    together[0].struct_size = sizeof *together;
    assert_ok(toliman_bank_encode(bank, fit, PLAIN_IMAGE(frames), 1, NULL, together, NULL));
    assert_memory_equal(together, alone, sizeof *alone);
}

typedef struct {
    int frame;
    toliman_status status;
    toliman_bank_result result;
} encoding;

static void *encode_alone(void *given) {
    encoding *const job = given;
    const toliman_fit_prediction prediction = at(job->frame);
    job->result.struct_size = sizeof job->result;
    job->status = toliman_bank_encode(bank, fit, PLAIN_IMAGE(frames[job->frame]), 1, &prediction, &job->result, NULL);
    return NULL;
}

/* On one bank and one fit at the same time. */
/* promises: bank-results-ignore-others, const-calls-run-together */
TEST(calls_of_several_threads_give_the_same_bits) {
    enum { THREADS = 4 };
    pthread_t threads[THREADS];
    encoding jobs[THREADS];
    for (int i = 0; i < THREADS; i++) {
        jobs[i].frame = 12 * i;
        assert_int_equal(pthread_create(&threads[i], NULL, encode_alone, &jobs[i]), 0);
    }
    for (int i = 0; i < THREADS; i++) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
        assert_int_equal(jobs[i].status, TOLIMAN_OK);
        const toliman_bank_result alone = encoded(frames[12 * i], at(12 * i));
        assert_memory_equal(&jobs[i].result, &alone, sizeof alone);
    }
}

static int32_t use_while_trained(const char *stage, double fraction, void *trained) {
    toliman_bank_info info = {.struct_size = sizeof info};
    (void)stage, (void)fraction;
    assert_refused(toliman_bank_get_info(trained, &info), TOLIMAN_E_STATE, "bank");
    return 1;
}

TEST(training_needs_exclusive_use) {
    toliman_bank *const other = bank_of(fit, 1, 4, 1);
    const toliman_bank_train_options options = {
        .struct_size = sizeof options, .threads = 1, .progress = use_while_trained, .progress_data = other};
    assert_refused(toliman_bank_train(other, fit, &options), TOLIMAN_E_CANCELLED, "");
    assert_int_equal(bank_info_of(other).trained_networks, 0);
    toliman_bank_destroy(other);
}

/* Propagated images of a displaced star, without noise. */
TEST(displacements_are_measured) {
    static const double truths[] = {0, 1e-5, -3e-3, 0.01, 0.05};
    static double image[PIXELS];
    const toliman_bank_result expected = predicted(bank, fit, at(0));
    assert_close(expected.displacement_px, 0, 0, 0);
    for (size_t i = 0; i < sizeof truths / sizeof *truths; i++) {
        assert_ok(toliman_sim_propagate(sim, truths[i], image, SIDE));
        const toliman_bank_result result = encoded(image, at(0));
        assert_close(result.displacement_px, truths[i], 1e-4, 1e-8);
        assert_close(result.separation_px, 13.5 + truths[i], 0, 1e-8 + 1e-4 * fabs(truths[i]));
        assert_int_equal(result.network, expected.network);
        assert_close(result.efficiency, expected.efficiency, 0.01, 0);
        assert_close(result.sigma_px, expected.sigma_px, 0.01, 0);
    }
}

/* The efficiency relates sigma_px to the Cramer-Rao bound of the fit. */
TEST(sigma_is_the_bound_over_the_efficiency) {
    for (int i = 0; i < FRAMES; i += 5) {
        double covariance[7 * 7];
        const toliman_fit_prediction prediction = at(i);
        assert_ok(toliman_fit_predict(fit, &prediction, NULL, 0, NULL, covariance));
        const toliman_bank_result expected = predicted(bank, fit, prediction);
        assert_true(expected.efficiency > 0.3 && expected.efficiency <= 1);
        assert_close(expected.sigma_px, sqrt(covariance[0]) / expected.efficiency, 1e-9, 0);
    }
    const toliman_bank_network network = bank_network_of(bank, 0);
    const toliman_bank_result there = predicted(bank, fit, at(network.days));
    assert_close(there.distance_px, 0, 0, 1e-9);
    assert_close(there.efficiency, network.cosine, 5e-3, 0);
}

/* A prediction that is 5e-3 or 0.3 px off changes the value of a noisy frame by little of its sigma. */
TEST(values_do_not_depend_on_the_prediction) {
    double shown = 0;
    for (int i = 0; i < FRAMES; i += 10) {
        double values[7];
        toliman_fit_prediction prediction = at(i);
        const toliman_bank_result plain = encoded(frames[i], prediction);
        assert_ok(toliman_fit_predict(fit, &prediction, NULL, 0, values, NULL));
        prediction.position_angle_deg = values[1];
        static const double offs[] = {-0.3, -5e-3, 5e-3, 0.3};
        for (size_t k = 0; k < sizeof offs / sizeof *offs; k++) {
            prediction.separation_px = values[0] + offs[k];
            const toliman_bank_result other = encoded(frames[i], prediction);
            assert_close(other.displacement_px, plain.displacement_px - offs[k], 0, 0.05 * plain.sigma_px);
            assert_close(other.separation_px, plain.separation_px, 0, 0.05 * plain.sigma_px);
            shown = fmax(shown, fabs(other.separation_px - plain.separation_px) / plain.sigma_px);
        }
    }
    print_message("a prediction 0.3 px off changes the value by %.3f sigma\n", shown);
}

/* Errors of noisy frames at all dates: mean and mean square against the stated sigma. */
TEST(errors_have_the_stated_size) {
    double squares = 0, sum = 0;
    toliman_bank_result results[FRAMES] = {{.struct_size = sizeof *results}};
    toliman_fit_prediction predictions[FRAMES];
    for (int k = 0; k < FRAMES; k++)
        predictions[k] = at(k);
    assert_ok(toliman_bank_encode(bank, fit, PLAIN_IMAGE(frames), FRAMES, predictions, results, NULL));
    for (int k = 0; k < FRAMES; k++) {
        const double error = results[k].displacement_px / results[k].sigma_px;
        squares += error * error;
        sum += error;
    }
    print_message("mean %.2f, mean square %.2f of errors in sigma\n", sum / FRAMES, squares / FRAMES);
    assert_close(squares / FRAMES, 1, 0, 4 * sqrt(2.0 / FRAMES));
    assert_close(sum / FRAMES, 0, 0, 4 / sqrt(FRAMES));
}

TEST(flags_are_set) {
    static double empty[PIXELS];
    toliman_fit_result fitted = {.struct_size = sizeof fitted};
    toliman_bank_result result = {.struct_size = sizeof result};
    assert_ok(toliman_bank_encode(bank, fit, PLAIN_IMAGE(empty), 1, NULL, &result, &fitted));
    assert_int_equal(result.flags, TOLIMAN_BANK_NOT_FITTED);
    assert_int_equal(fitted.flags, TOLIMAN_FIT_NOT_CONVERGED);
    assert_int_equal(result.network, -1);
    for (const double *number = &result.displacement_px; number <= &result.distance_px; number++)
        assert_true(isnan(*number));
    assert_int_equal(predicted(bank, fit, at(50.5)).flags & TOLIMAN_BANK_OUTSIDE, TOLIMAN_BANK_OUTSIDE);
    assert_int_equal(predicted(bank, fit, at(-0.5)).flags & TOLIMAN_BANK_OUTSIDE, TOLIMAN_BANK_OUTSIDE);
    int low = 0;
    for (int i = 0; i < FRAMES; i++) {
        const toliman_bank_result expected = predicted(bank, fit, at(i));
        assert_int_equal(expected.flags, expected.efficiency < 0.95 ? TOLIMAN_BANK_LOW_EFFICIENCY : 0);
        low += expected.flags != 0;
    }
    assert_in_range(low, 1, FRAMES);
}

/* The more is asked of a bank, the sooner it must be renewed; the day before, it still has the efficiency. */
TEST(renewals_precede_lower_efficiencies) {
    double last = INFINITY;
    for (double least = 0.1; least < 1; least += 0.2) {
        double days = 0;
        assert_ok(toliman_bank_get_renewal(bank, fit, least, &days));
        assert_true(days > 50 && days <= last);
        assert_close(days, nearbyint(days), 0, 0);
        if (days > 51)
            assert_true(predicted(bank, fit, at(days - 1)).efficiency >= least);
        last = days;
    }
    assert_close(last, 51, 0, 0);
}

/* Maximum pooling loses information, but not the scale. */
TEST(layout_paper_has_a_low_efficiency) {
    const toliman_bank_options options = {.struct_size = sizeof options,
                                          .layout = TOLIMAN_CAE_LAYOUT_PAPER,
                                          .places = 1,
                                          .spacing_px = 4,
                                          .steps = 10,
                                          .first_days = 0,
                                          .last_days = 1};
    static double image[PIXELS];
    toliman_bank *paper = NULL;
    assert_ok(toliman_bank_create(fit, &options, &paper));
    train_bank(paper, fit, 1);
    const toliman_bank_info info = bank_info_of(paper);
    assert_string_equal(info.layout, "paper");
    assert_int_equal(info.networks, 1);
    const toliman_bank_result expected = predicted(paper, fit, at(0));
    assert_true(expected.efficiency > 1e-3 && expected.efficiency < 0.5);
    assert_true((expected.flags & TOLIMAN_BANK_LOW_EFFICIENCY) != 0);
    assert_ok(toliman_sim_propagate(sim, 0, image, SIDE));
    toliman_bank_result result = {.struct_size = sizeof result};
    assert_ok(toliman_bank_encode(paper, fit, PLAIN_IMAGE(image), 1, NULL, &result, NULL));
    assert_close(result.sigma_px, expected.sigma_px, 1e-3, 0);
    assert_ok(toliman_bank_encode(paper, fit, PLAIN_IMAGE(frames[0]), 1, NULL, &result, NULL));
    assert_at_most(fabs(result.displacement_px), 6 * result.sigma_px);
    toliman_bank_destroy(paper);
}

/* Frames larger than a network: it reads a crop around the stars. */
TEST(larger_frames_are_cropped) {
    enum { ROWS = 300, COLS = 280, STRIDE = COLS + 3 };
    static double image[ROWS * STRIDE];
    toliman_sim *const large = bank_sim(ROWS, COLS, "\"offsets_px\": {\"A\": [9.75, 63], \"B\": [21, 55.5]}");
    toliman_fit *const with = bank_fit(large, 3);
    toliman_bank *const cropped = bank_of(with, 1, 0, 40);
    train_bank(cropped, with, 1);
    const toliman_bank_info info = bank_info_of(cropped);
    assert_true(info.dates == 1 && info.networks == 1 && info.rows == ROWS && info.cols == COLS);
    assert_ok(toliman_sim_propagate(large, 2e-3, image, STRIDE));
    toliman_bank_result result = {.struct_size = sizeof result};
    const toliman_image strided = {.struct_size = sizeof strided, .pixels = image, .stride = STRIDE};
    assert_ok(toliman_bank_encode(cropped, with, &strided, 1, NULL, &result, NULL));
    assert_close(result.displacement_px, 2e-3, 0, 1e-6);
    assert_true(result.efficiency > 0.7);
    /* Elsewhere by pointing, and further apart. */
    toliman_sim *const moved = bank_sim(ROWS, COLS, "\"offsets_px\": {\"A\": [12.05, 61.6], \"B\": [23.31, 54.1]}");
    const toliman_fit_prediction pointing = {.struct_size = sizeof pointing, .x_px = 2.3, .y_px = -1.4};
    assert_ok(toliman_sim_propagate(moved, 0, image, STRIDE));
    assert_ok(toliman_bank_encode(cropped, with, &strided, 1, &pointing, &result, NULL));
    assert_close(result.displacement_px, hypot(11.26, 7.5) - hypot(11.25, 7.5), 0, 1e-6);
    assert_close(result.distance_px, hypot(0.3, 0.4), 0.05, 0);
    toliman_sim_destroy(moved);
    double days = 0;
    assert_ok(toliman_bank_get_renewal(cropped, with, 0.1, &days)); /* stars at rest */
    assert_close(days, 50 + 4096, 0, 0);
    toliman_bank_destroy(cropped), toliman_fit_destroy(with), toliman_sim_destroy(large);
}

RUN_TESTS(set_up, tear_down)
