/* Results of every header through the C interface; numbers.f90 and test_numbers.py compute the same. Usage: numbers
 * scene */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <toliman/toliman.h>

enum { N = 1095, FRAMES = 6 };

static void must(toliman_status status, int line) {
    if (status != TOLIMAN_OK) {
        fprintf(stderr, "line %d: %s\n", line, toliman_last_error());
        exit(1);
    }
}
#define MUST(call) must(call, __LINE__)
#define ASKS(call) must((call) == TOLIMAN_E_CAPACITY ? TOLIMAN_OK : TOLIMAN_E_INTERNAL, __LINE__)

static void show(const char *name, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    printf("%s %016" PRIX64 "\n", name, bits);
}

static int32_t count_calls(const char *stage, double fraction, void *calls) {
    (void)fraction;
    *(int32_t *)calls += stage[0] != '\0';
    return 0;
}

static double sum_of(const double *image, int64_t count) {
    double sum = 0;
    for (int64_t i = 0; i < count; i++)
        sum += image[i];
    return sum;
}

static void simulate(const toliman_sim *sim, int64_t rows, int64_t cols, double *image) {
    double *images = malloc((size_t)(2 * rows * cols) * sizeof *images), times[3], displacements[3];
    toliman_sim_offsets offsets = TOLIMAN_SIM_OFFSETS_INIT;
    MUST(toliman_sim_expect(sim, 1e-6, image, (size_t)cols));
    show("expect", image[120 * cols + 100]);
    MUST(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_STAR_A, image, (size_t)cols));
    show("star_a", image[120 * cols + 100]);
    MUST(toliman_sim_get_derivative(sim, "jitter_xy", image, (size_t)cols));
    show("jitter_xy", image[120 * cols + 100]);
    static toliman_sim_parameter parameters[128] = {TOLIMAN_SIM_PARAMETER_INIT};
    size_t known = 0;
    MUST(toliman_sim_get_parameters(parameters, 128, &known));
    show("parameters", (double)known);
    MUST(toliman_sim_frame(sim, NULL, 3, 5, 2, images));
    show("frames", images[rows * cols + 130 * cols + 100]);
    MUST(toliman_sim_get_series(sim, 8, 3, times, displacements));
    show("time", times[2]);
    show("displacement", displacements[2]);
    MUST(toliman_sim_get_offsets(sim, &offsets));
    show("offset", offsets.b_x_px);
    MUST(toliman_sim_frame(sim, &(double){1e-6}, 3, 7, 1, image));
    show("frame", image[130 * cols + 100]);
    show("frame_sum", sum_of(image, rows * cols));
    free(images);
}

static void encode(const toliman_sim *sim, const double *frame, int64_t cols) {
    toliman_cae *made, *cae;
    toliman_cae_train_options options;
    toliman_cae_training report = {.struct_size = sizeof report};
    int32_t calls = 0;
    size_t size;
    toliman_frame_goodness goodness = TOLIMAN_FRAME_GOODNESS_INIT;
    double latent, mmse, *image = malloc(256 * 256 * sizeof *image);
    MUST(toliman_cae_create(sim, 5, NULL, &made));
    options = (toliman_cae_train_options)TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    options.steps = 3;
    options.progress = count_calls;
    options.progress_data = &calls;
    MUST(toliman_cae_train(made, &options, &report));
    show("loss", report.loss);
    show("calls", calls);
    ASKS(toliman_cae_save(made, NULL, NULL, 0, &size));
    void *bytes = malloc(size);
    MUST(toliman_cae_save(made, NULL, bytes, size, &size));
    show("bytes", (double)size);
    MUST(toliman_cae_load(bytes, size, NULL, &cae));
    const toliman_image one = {.struct_size = sizeof one, .pixels = frame};
    MUST(toliman_cae_encode(cae, &one, 1, &latent, &goodness));
    show("latent", latent);
    show("chi_square", goodness.chi_square);
    MUST(toliman_cae_decode(cae, 1e-3, image, 256));
    show("decode", image[3 * 256 + 250]);
    MUST(toliman_cae_reconstruct(cae, frame, (size_t)cols, image, 256, &mmse, NULL, NULL));
    show("mmse", mmse);
    free(image);
    free(bytes);
    toliman_cae_destroy(cae);
    toliman_cae_destroy(made);
}

static void follow(const toliman_sim *sim, const double *frame) {
    toliman_fit *fit;
    toliman_bank *made, *bank;
    toliman_fit_options fit_options = TOLIMAN_FIT_OPTIONS_INIT;
    toliman_bank_options options = TOLIMAN_BANK_OPTIONS_INIT;
    toliman_bank_plan_info plan = TOLIMAN_BANK_PLAN_INFO_INIT;
    toliman_bank_network network = TOLIMAN_BANK_NETWORK_INIT;
    toliman_bank_result result = TOLIMAN_BANK_RESULT_INIT;
    toliman_fit_result fitted = TOLIMAN_FIT_RESULT_INIT;
    const toliman_image image = {.struct_size = sizeof image, .pixels = frame};
    size_t size;
    fit_options.capture_px = 1;
    options.places = 2;
    options.steps = 2;
    MUST(toliman_fit_create(&sim, NULL, 1, &fit_options, &fit));
    MUST(toliman_bank_plan(sim, &options, &plan));
    show("networks", (double)plan.networks);
    MUST(toliman_bank_create(fit, &options, &made));
    MUST(toliman_bank_train(made, fit, NULL));
    ASKS(toliman_bank_save(made, 0, NULL, 0, &size));
    void *bytes = malloc(size);
    MUST(toliman_bank_save(made, 0, bytes, size, &size));
    show("bank_bytes", (double)size);
    MUST(toliman_bank_load(bytes, size, NULL, &bank));
    MUST(toliman_bank_get_network(bank, 3, &network));
    show("cosine", network.cosine);
    MUST(toliman_bank_encode(bank, fit, &image, 1, NULL, &result, &fitted));
    show("bank_displacement", result.displacement_px);
    show("bank_sigma", result.sigma_px);
    show("fitted", fitted.displacement_px);
    MUST(toliman_bank_predict(bank, fit, NULL, &result));
    show("bank_efficiency", result.efficiency);
    free(bytes);
    toliman_bank_destroy(made);
    toliman_bank_destroy(bank);
    toliman_fit_destroy(fit);
}

static void fit_linear(const toliman_sim *sim, double *image) {
    toliman_linear *linear;
    toliman_components *components;
    double value, sigma, values[FRAMES], share;
    const toliman_image view = {.struct_size = sizeof view, .pixels = image};
    MUST(toliman_linear_create(sim, NULL, &linear));
    MUST(toliman_linear_encode(linear, &view, 1, &value, NULL));
    MUST(toliman_linear_get_sigma(linear, &sigma));
    show("estimate", value);
    show("sigma", sigma);
    MUST(toliman_components_create(sim, NULL, &components));
    for (int k = 0; k < FRAMES; k++) {
        MUST(toliman_sim_frame(sim, &(double){1e-3 * k}, 3, k, 1, image));
        MUST(toliman_components_push(components, &view, 1));
    }
    MUST(toliman_components_train(components, NULL, NULL));
    MUST(toliman_components_get_series(components, 0, values, &share));
    show("component", values[2]);
    show("share", share);
    toliman_components_destroy(components);
    toliman_linear_destroy(linear);
}

static void design_mask(const toliman_sim *sim) {
    toliman_mask *mask;
    toliman_mask_options options = TOLIMAN_MASK_OPTIONS_INIT;
    toliman_mask_info info = TOLIMAN_MASK_INFO_INIT;
    options.iterations = 1;
    MUST(toliman_mask_create(sim, &options, &mask));
    MUST(toliman_mask_get_info(mask, &info));
    show("mask_crb", info.crb_px);
    show("mask_peak_to_mean", info.peak_to_mean);
    show("mask_iterations", (double)info.iterations);
    show("mask_json", (double)strlen(toliman_mask_get_json(mask)));
    toliman_mask_destroy(mask);
}

static int64_t count_of(const toliman_period *period) {
    toliman_period_info info = TOLIMAN_PERIOD_INFO_INIT;
    MUST(toliman_period_get_info(period, &info));
    return info.count;
}

static void search(void) {
    static double t[N], y[N], power[5461];
    toliman_period *period, *loaded;
    toliman_period_peak peak = {.struct_size = sizeof peak}, peaks[3];
    toliman_period_model model = {.struct_size = sizeof model};
    size_t size, count;
    MUST(toliman_period_create(1.5 / N, 0.1 / N, 5461, NULL, &period));
    for (int k = 0; k < N; k++) {
        t[k] = k;
        y[k] = (k * 37 % 101) / 1010.0 + (k % 365 < 182 ? 0.25 : 0.0);
    }
    MUST(toliman_period_push(period, t[0], y[0], 1));
    MUST(toliman_period_push_many(period, t + 1, y + 1, NULL, N - 1));
    MUST(toliman_period_query_peak(period, &peak));
    show("period", peak.period);
    show("log10_fap", peak.log10_fap);
    MUST(toliman_period_query_fit(period, t, y, NULL, NULL, N, &peak));
    show("period_error", peak.period_error);
    MUST(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 100, 3, power));
    show("power", power[2]);
    MUST(toliman_period_batch(1.5 / N, 0.1 / N, 5461, t, y, NULL, N, NULL, power));
    show("batch", power[102]);
    MUST(toliman_period_query_model(period, 15, &model));
    show("amplitude", model.amplitude);
    for (int k = 0; k < 3; k++)
        peaks[k].struct_size = sizeof *peaks;
    MUST(toliman_period_query_peaks(period, peaks, 3, &count));
    show("second_peak", peaks[1].frequency);
    ASKS(toliman_period_save(period, NULL, 0, &size));
    void *bytes = malloc(size);
    MUST(toliman_period_save(period, bytes, size, &size));
    MUST(toliman_period_load(bytes, size, NULL, &loaded));
    show("count", (double)count_of(loaded));
    free(bytes);
    toliman_period_destroy(loaded);
    toliman_period_destroy(period);
}

static void find_planets(void) {
    enum { SERIES = 60 };
    static double t[SERIES], y[SERIES], sigma[SERIES], rows[SERIES], signal[SERIES],
        samples[16][TOLIMAN_PLANET_COLUMNS];
    const double periods[2] = {70, 150};
    toliman_planet *planets;
    toliman_measure_data series = TOLIMAN_MEASURE_DATA_INIT;
    toliman_measure *measure;
    toliman_planet_options options = TOLIMAN_PLANET_OPTIONS_INIT;
    toliman_planet_info info = TOLIMAN_PLANET_INFO_INIT;
    toliman_planet_candidate planet = TOLIMAN_PLANET_CANDIDATE_INIT;
    toliman_planet_limit limits[2] = {TOLIMAN_PLANET_LIMIT_INIT};
    toliman_planet_cell cell = TOLIMAN_PLANET_CELL_INIT;
    uint32_t detected;
    for (int k = 0; k < SERIES; k++) {
        t[k] = 7 * k;
        y[k] = (k * 37 % 101) / 101.0 + (7 * k % 90 < 45 ? 2 : 0);
        sigma[k] = 0.5;
        rows[k] = k % 5;
    }
    series.n = SERIES;
    series.t = t;
    series.y = y;
    series.sigma = sigma;
    MUST(toliman_measure_create(&series, &measure));
    MUST(toliman_measure_add_column(measure, "rows", rows, SERIES, 0));
    options.threads = 1;
    options.prior.period_max = 200;
    options.samples = 100;
    MUST(toliman_planet_create(measure, &options, &planets));
    MUST(toliman_planet_get_info(planets, &info));
    show("planet_candidates", info.candidates);
    show("planet_residual_rms", info.rms);
    MUST(toliman_planet_get_candidate(planets, 0, &planet));
    show("planet_period", planet.period[1]);
    show("planet_bayes", planet.log10_bayes);
    MUST(toliman_planet_get_samples(planets, 0, 16, *samples));
    show("planet_sample", samples[15][4]);
    MUST(toliman_planet_get_signal(planets, 0, t, NULL, SERIES, signal));
    show("planet_signal", signal[10]);
    MUST(toliman_planet_get_residuals(planets, SERIES, y));
    show("planet_residual", y[10]);
    MUST(toliman_planet_get_limits(planets, periods, 2, 0.9, limits));
    show("planet_upper", limits[1].upper);
    cell.star = -1;
    cell.period_min = 80;
    cell.period_max = 120;
    cell.size_min = cell.size_max = 0.6;
    cell.count = 20;
    MUST(toliman_planet_inject(planets, &cell, &detected));
    show("planet_injected", detected);
    toliman_planet_destroy(planets);
    toliman_measure_destroy(measure);
}

static void track(const toliman_sim *sim, int64_t rows, int64_t cols) {
    static const int64_t clock[4] = {0, 1000, 1000000000, 1000001000};
    toliman_linear *linear;
    toliman_track *track;
    const toliman_period *period;
    toliman_track_stream streams[2] = {{.struct_size = sizeof *streams}};
    toliman_track_options options;
    toliman_track_info info = TOLIMAN_TRACK_INFO_INIT;
    toliman_track_outcome outcome = {.struct_size = sizeof outcome};
    size_t done, many;
    double *image = malloc((size_t)(rows * cols) * sizeof *image);
    MUST(toliman_linear_create(sim, NULL, &linear));
    options = (toliman_track_options)TOLIMAN_TRACK_OPTIONS_INIT;
    options.estimator.linear = linear;
    options.grid.nf = 5461;
    options.grid.f0 = 1.5 / N;
    options.grid.df = 0.1 / N;
    options.clock.pairs = clock;
    options.clock.count = 2;
    MUST(toliman_track_create(&options, &track));
    for (int k = 0; k < FRAMES; k++) {
        toliman_frame frame = {.struct_size = sizeof frame, .pixel = TOLIMAN_PIXEL_F64, .session = "s1", .roi = "full"};
        MUST(toliman_sim_frame(sim, &(double){1e-6}, 3, k, 1, image));
        if (k == 3)
            image[7 * cols + 9] = NAN;
        frame.frame_id = k;
        frame.camera_ns = k * INT64_C(86400000000000);
        frame.pixels = image;
        frame.rows = rows;
        frame.cols = cols;
        MUST(toliman_track_push(track, &frame, 1, &outcome, &done));
        show("verdict", outcome.verdict);
        if (k == 3)
            show("bad_pixel", (double)(1000 * outcome.row + outcome.col));
    }
    show("tracked", outcome.value);
    show("tai", (double)outcome.tai_ns);
    MUST(toliman_track_get_info(track, &info));
    show("rejected", (double)info.rejected_for[TOLIMAN_TRACK_REASON_NOT_FINITE - TOLIMAN_TRACK_REASON_NONE]);
    MUST(toliman_track_get_streams(track, streams, 2, &many));
    show("streams", (double)many);
    show("frames", (double)streams[0].frames);
    printf("session %s\n", streams[0].session);
    MUST(toliman_track_get_period(track, &period));
    show("in_period", (double)count_of(period));
    free(image);
    toliman_track_destroy(track);
    toliman_linear_destroy(linear);
}

int main(int argc, char **argv) {
    toliman_sim *sim;
    toliman_sim_info info = {.struct_size = sizeof info};
    toliman_sim_bounds bounds = TOLIMAN_SIM_BOUNDS_INIT;
    if (argc != 2)
        return 2;
    printf("version %s\n", toliman_version());
    MUST(toliman_sim_create_file(argv[1], NULL, &sim));
    MUST(toliman_sim_get_info(sim, &info));
    show("rows", (double)info.rows);
    MUST(toliman_sim_get_bounds(sim, &bounds));
    show("crb", bounds.crb_px);
    show("photons", info.total_photons);
    printf("name %s\n", info.name);
    double *image = malloc((size_t)(info.rows * info.cols) * sizeof *image);
    simulate(sim, info.rows, info.cols, image);
    encode(sim, image, info.cols);
    follow(sim, image);
    fit_linear(sim, image);
    design_mask(sim);
    search();
    find_planets();
    track(sim, info.rows, info.cols);
    free(image);
    toliman_sim_destroy(sim);
    return 0;
}
