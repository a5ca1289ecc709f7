/* Passes NaN, infinities and extreme numbers to everything that accepts numbers. Numbers that are not finite are
 * refused and change nothing; for all others every output is finite. TOLIMAN_STORMS sets the number of rounds. */
#include <float.h>

#include "images.h"
#include "tlmw.h"
#include "track_frames.h"

#include <toliman/components.h>
#include <toliman/linear.h>
#include <toliman/period.h>
#include <toliman/period_batch.h>
#include <toliman/planet.h>

enum { SAMPLES = 30, GRID = 20 };

static uint64_t storms = 8, draws = 1, not_finite = 0, odd = 0;

static double from_bits(uint64_t bits) {
    double number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

/* NaN of either sign and any payload, quiet or signalling, or an infinity. */
static double wrong_number(void) {
    const uint64_t sign = draw(&draws, 2) << 63, payload = draw(&draws, (uint64_t)1 << 52);
    not_finite++;
    return from_bits(sign | 0x7ff0000000000000u | (draw(&draws, 3) ? payload : 0));
}

/* A subnormal number, a zero of either sign, or one of the largest or smallest numbers. */
static double odd_number(void) {
    const uint64_t sign = draw(&draws, 2) << 63;
    odd++;
    switch (draw(&draws, 4)) {
    case 0:
        return from_bits(sign);
    case 1:
        return from_bits(sign | 0x7fefffffffffffffu);
    case 2:
        return from_bits(sign | 0x0010000000000000u);
    default:
        return from_bits(sign | draw(&draws, (uint64_t)1 << 52));
    }
}

static void assert_finite(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i]))
            fail_msg("value %zu is %g", i, values[i]);
}

static void assert_rejected(int32_t status) {
    if (status != TOLIMAN_E_ARGUMENT && status != TOLIMAN_E_RANGE)
        fail_msg("%s: %s", toliman_constant_name(status), toliman_last_error());
}

static void make_samples(double *t, double *y, double *sigma) {
    for (int i = 0; i < SAMPLES; i++) {
        t[i] = i + 0.01 * (double)draw(&draws, 50);
        y[i] = 0.1 * (double)draw(&draws, 100);
        sigma[i] = 1 + 0.01 * (double)draw(&draws, 100);
    }
}

static void assert_finite_power(const toliman_period *period) {
    double power[GRID];
    for (int32_t kind = TOLIMAN_PERIOD_POWER_STANDARD; kind <= TOLIMAN_PERIOD_POWER_PSD; kind++) {
        const int32_t status = toliman_period_query_power(period, kind, 0, GRID, power);
        if (status == TOLIMAN_OK)
            assert_finite(power, GRID);
        else
            assert_true(status == TOLIMAN_E_RANGE || status == TOLIMAN_E_STATE);
    }
}

/* promises: failed-calls-change-nothing, only-finite-numbers-pass, power-is-never-nan, pushes-take-all-or-none */
TEST(periodograms) {
    static unsigned char before[STATE_CAPACITY], after[STATE_CAPACITY];
    double t[SAMPLES], y[SAMPLES], sigma[SAMPLES], power[GRID];
    double *const arrays[] = {t, y, sigma};
    for (uint64_t storm = 0; storm < 20 * storms; storm++) {
        size_t size = 0, size_after = 0;
        toliman_period *period = NULL;
        toliman_period_options options = TOLIMAN_PERIOD_OPTIONS_INIT;
        options.flags = draw(&draws, 2) ? TOLIMAN_PERIOD_DOUBLE_LIMB : 0;
        make_samples(t, y, sigma);
        assert_ok(toliman_period_create(0.01, 0.02, GRID, &options, &period));
        assert_ok(toliman_period_push_many(period, t, y, sigma, SAMPLES / 2));
        const size_t place = SAMPLES / 2 + draw(&draws, SAMPLES / 2), which = draw(&draws, 3);
        const double good = arrays[which][place];
        arrays[which][place] = wrong_number();
        assert_ok(toliman_period_save(period, before, sizeof before, &size));
        assert_rejected(toliman_period_push(period, t[place], y[place], sigma[place]));
        assert_rejected(
            toliman_period_push_many(period, t + SAMPLES / 2, y + SAMPLES / 2, sigma + SAMPLES / 2, SAMPLES / 2));
        assert_ok(toliman_period_save(period, after, sizeof after, &size_after));
        assert_int_equal(size, size_after);
        assert_memory_equal(before, after, size);
        power[0] = -7;
        assert_rejected(toliman_period_batch(0.01, 0.02, GRID, t, y, sigma, SAMPLES, NULL, power));
        assert_true(power[0] == -7);
        arrays[which][place] = odd_number();
        const int32_t status = toliman_period_push(period, t[place], y[place], sigma[place]);
        if (status != TOLIMAN_OK)
            assert_rejected(status);
        assert_finite_power(period);
        if (toliman_period_batch(0.01, 0.02, GRID, t, y, sigma, SAMPLES, NULL, power) == TOLIMAN_OK)
            assert_finite(power, GRID);
        arrays[which][place] = good;
        toliman_period_destroy(period);
    }
}

/* promises: only-finite-numbers-pass, power-is-never-nan */
TEST(grids) {
    for (uint64_t storm = 0; storm < 20 * storms; storm++) {
        double grid[2] = {0.01, 0.02};
        toliman_period *period = NULL;
        grid[draw(&draws, 2)] = wrong_number();
        assert_rejected(toliman_period_create(grid[0], grid[1], GRID, NULL, &period));
        assert_null(period);
        grid[0] = 0.01, grid[1] = 0.02;
        grid[draw(&draws, 2)] = odd_number();
        if (toliman_period_create(grid[0], grid[1], GRID, NULL, &period) != TOLIMAN_OK)
            continue;
        for (int i = 0; i < 8; i++)
            if (toliman_period_push(period, i, i % 3, 1) != TOLIMAN_OK)
                assert_rejected(toliman_period_push(period, i, i % 3, 1));
        assert_finite_power(period);
        toliman_period_destroy(period);
    }
}

/* All that a result of toliman_planet_create reports. */
static void assert_finite_planets(const toliman_planet *planets) {
    toliman_planet_info info = {.struct_size = sizeof info};
    double residuals[SAMPLES], samples[8][TOLIMAN_PLANET_COLUMNS];
    assert_ok(toliman_planet_get_info(planets, &info));
    assert_finite((const double[]){info.rms, info.chi_square}, 2);
    assert_ok(toliman_planet_get_residuals(planets, SAMPLES, residuals));
    assert_finite(residuals, SAMPLES);
    for (uint32_t i = 0; i < info.candidates; i++) {
        toliman_planet_candidate planet = {.struct_size = sizeof planet};
        assert_ok(toliman_planet_get_candidate(planets, i, &planet));
        assert_finite(&planet.log10_bayes, 1);
        assert_finite(&planet.log10_fap, 1);
        assert_true(planet.log10_bayes_error >= 0); /* infinite: the odds have not converged */
        assert_finite(planet.period, 15);
        assert_finite(planet.best, 5);
        assert_finite(planet.correlation, 25);
        assert_ok(toliman_planet_get_samples(planets, i, 8, *samples));
        for (int k = 0; k < 8; k++)
            assert_finite(samples[k], 5); /* masses are NaN while the unit is unknown */
    }
}

/* With one column. On failure *out is not set. */
static toliman_status series_with(const toliman_measure_data *data, const double *rows, toliman_measure **out) {
    toliman_measure *made = NULL;
    toliman_status status = toliman_measure_create(data, &made);
    if (status == TOLIMAN_OK)
        status = toliman_measure_add_column(made, "rows", rows, data->n, 0);
    if (status == TOLIMAN_OK)
        *out = made;
    else
        toliman_measure_destroy(made);
    return status;
}

/* promise: only-finite-numbers-pass */
TEST(series_of_planets) {
    double t[SAMPLES], y[SAMPLES], sigma[SAMPLES], rows[SAMPLES], angles[SAMPLES];
    double *const arrays[] = {t, y, sigma, rows, angles};
    static const char *const names[] = {"t", "y", "sigma", "values", "position_angle_deg"};
    for (uint64_t storm = 0; storm < storms; storm++) {
        toliman_measure_data data = {
            .struct_size = sizeof data, .n = SAMPLES, .t = t, .y = y, .sigma = sigma, .position_angle_deg = angles};
        toliman_measure *series = NULL;
        toliman_planet_options options = TOLIMAN_PLANET_OPTIONS_INIT;
        options.threads = 1;
        options.prior.period_min = 5;
        options.prior.period_max = 20;
        options.samples = 100;
        make_samples(t, y, sigma);
        for (int i = 0; i < SAMPLES; i++) {
            rows[i] = i % 4;
            angles[i] = 0.1 * i;
        }
        toliman_planet *planets = NULL;
        const size_t place = draw(&draws, SAMPLES), which = draw(&draws, 5);
        const double good = arrays[which][place];
        arrays[which][place] = wrong_number();
        assert_rejected(series_with(&data, rows, &series));
        assert_null(series);
        assert_true(strncmp(toliman_last_error_field(), names[which], strlen(names[which])) == 0);
        arrays[which][place] = odd_number();
        int32_t status = series_with(&data, rows, &series);
        if (status == TOLIMAN_OK)
            status = toliman_planet_create(series, &options, &planets);
        if (status == TOLIMAN_OK)
            assert_finite_planets(planets);
        else
            assert_rejected(status);
        toliman_planet_destroy(planets);
        planets = NULL;
        toliman_measure_destroy(series);
        series = NULL;
        arrays[which][place] = good;
        assert_ok(series_with(&data, rows, &series));
        double *const limits[] = {
            &options.prior.period_min,    &options.prior.period_max,    &options.prior.eccentricity_max,
            &options.prior.amplitude_min, &options.prior.amplitude_max, &options.prior.jitter_max,
            &options.threshold,           &options.detection_fap,       &options.star_mass[1]};
        *limits[draw(&draws, sizeof limits / sizeof *limits)] = wrong_number();
        assert_rejected(toliman_planet_create(series, &options, &planets));
        assert_null(planets);
        assert_rejected(toliman_measure_set_trend(series, 1, wrong_number(), 1));
        assert_rejected(toliman_measure_set_prior(series, 0, wrong_number()));
        toliman_measure_destroy(series);
        data.unit = wrong_number();
        assert_rejected(series_with(&data, rows, &series));
    }
}

/* A frame with some pixels that are not finite, or extreme. */
static void corrupt_pixels(double *frame, double (*number)(void)) {
    for (uint64_t left = 1 + draw(&draws, 4); left > 0; left--)
        frame[draw(&draws, kPixels)] = number();
}

/* promise: only-finite-numbers-pass */
TEST(pixels) {
    toliman_sim *sim = make_sim(kSide, kSide, 0, "\"shift_x\"");
    toliman_cae *cae = make_cae(sim, 1, 3, NULL);
    toliman_linear *linear = NULL;
    toliman_components *components = NULL;
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    assert_ok(toliman_components_create(sim, NULL, &components));
    double *good = new_image(kPixels), *frame = new_image(kPixels), *image = new_image(kPixels), value = -7;
    assert_ok(toliman_sim_frame(sim, &(double){0}, 1, 1, 1, good));
    for (uint64_t storm = 0; storm < storms; storm++) {
        memcpy(frame, good, kPixels * sizeof *frame);
        corrupt_pixels(frame, wrong_number);
        value = -7;
        assert_rejected(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &value, NULL));
        assert_rejected(toliman_cae_reconstruct(cae, frame, kSide, image, kSide, NULL, NULL, NULL));
        assert_rejected(toliman_linear_encode(linear, PLAIN_IMAGE(frame), 1, &value, NULL));
        assert_rejected(toliman_components_push(components, PLAIN_IMAGE(frame), 1));
        assert_true(value == -7);
        memcpy(frame, good, kPixels * sizeof *frame);
        corrupt_pixels(frame, odd_number);
        if (toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &value, NULL) == TOLIMAN_OK)
            assert_finite(&value, 1);
        if (toliman_cae_reconstruct(cae, frame, kSide, image, kSide, NULL, NULL, NULL) == TOLIMAN_OK)
            assert_finite(image, kPixels);
        if (toliman_linear_encode(linear, PLAIN_IMAGE(frame), 1, &value, NULL) == TOLIMAN_OK)
            assert_finite(&value, 1);
        value = wrong_number();
        assert_rejected(toliman_sim_frame(sim, &value, 1, 1, 1, image));
        assert_rejected(toliman_sim_expect(sim, value, image, kSide));
        assert_rejected(toliman_sim_propagate(sim, value, image, kSide));
        assert_rejected(toliman_cae_decode(cae, value, image, kSide));
        value = odd_number();
        if (toliman_sim_frame(sim, &value, 1, 1, 1, image) == TOLIMAN_OK)
            assert_finite(image, kPixels);
        if (toliman_cae_decode(cae, value, image, kSide) == TOLIMAN_OK)
            assert_finite(image, kPixels);
    }
    toliman_components_info info = {.struct_size = sizeof info};
    assert_ok(toliman_components_get_info(components, &info));
    assert_int_equal(info.frames, 0);
    free(good), free(frame), free(image), toliman_components_destroy(components), toliman_linear_destroy(linear);
    toliman_cae_destroy(cae), toliman_sim_destroy(sim);
}

/* Weights and planes with numbers that are not finite or subnormal, and a correct checksum. */
/* promise: only-finite-numbers-pass */
TEST(weights) {
    static const uint32_t bad[] = {0x7f800000u, 0xff800000u, 0x7fc00000u, 0xffc12345u,
                                   0x7f800001u, 1u,          0x807fffffu, 0x00400000u};
    enum { kPlanes = 4 }; /* reference (two), variance, target */
    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    toliman_cae *cae = make_cae(sim, 1, 0, NULL);
    size_t size;
    uint8_t *blob = saved(cae, &size);
    float *numbers = malloc(kPlanes * kPixels * sizeof *numbers);
    for (uint64_t storm = 0; storm < storms; storm++) {
        const int planes = (int)draw(&draws, 2);
        const size_t count = planes ? (size_t)kPlanes * kPixels : kParameters;
        for (size_t i = 0; i < count; i++)
            numbers[i] = 0.5f;
        memcpy(numbers + draw(&draws, count), &bad[draw(&draws, sizeof bad / sizeof *bad)], sizeof *numbers);
        size_t spoilt_size;
        uint8_t *spoilt = with_payloads(blob, planes ? NULL : numbers, planes ? numbers : NULL, kPlanes, &spoilt_size);
        refused(spoilt, spoilt_size, planes ? "planes[" : "weights[");
        free(spoilt);
    }
    free(numbers), free(blob), toliman_cae_destroy(cae), toliman_sim_destroy(sim);
}

/* promise: only-finite-numbers-pass */
TEST(frames_of_a_pass) {
    const toliman_track_options options = small_options(NULL);
    toliman_track *track = make_track(&options);
    int64_t rejected = 0;
    for (uint64_t storm = 0; storm < 20 * storms && storm < 4000; storm++) {
        small_frame frame;
        double image[PIXELS];
        make_frame(&frame, (int64_t)storm + 1);
        for (int i = 0; i < PIXELS; i++)
            image[i] = frame.pixels[i];
        const int is_wrong = (int)draw(&draws, 2);
        image[draw(&draws, PIXELS)] = is_wrong ? wrong_number() : odd_number();
        frame.frame.pixels = image;
        frame.frame.pixel = TOLIMAN_PIXEL_F64;
        const toliman_track_outcome outcome = push_one(track, &frame.frame);
        rejected += is_wrong;
        if (is_wrong)
            assert_int_equal(outcome.reason, TOLIMAN_TRACK_REASON_NOT_FINITE);
        if (outcome.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED)
            assert_finite(&outcome.value, 1);
    }
    assert_true(info_of(track).rejected >= rejected);
    assert_finite_power(period_of(track));
    toliman_track_destroy(track);
}

/* A number of the scene that JSON cannot represent, or near the limits of a double. */
/* promise: only-finite-numbers-pass */
TEST(scenes) {
    static const char *const numbers[] = {"NaN",   "Infinity", "-Infinity", "nan",    "inf",  "1e999", "-1e999",
                                          "1e308", "-1e308",   "5e-324",    "1e-320", "-0.0", "0"};
    enum { UNREAL = 7 };
    char json[4096], changed[8192];
    for (uint64_t storm = 0; storm < 10 * storms; storm++) {
        write_scene(json, sizeof json, kSide, kSide, 0, "\"shift_x\"");
        const char *place = json + 1 + draw(&draws, strlen(json) - 1);
        while (*place != '\0' && !(place[-1] == ' ' && strchr("-0123456789", *place) != NULL))
            place++;
        if (*place == '\0')
            continue;
        const size_t number = draw(&draws, sizeof numbers / sizeof *numbers);
        const size_t length = strspn(place, "-+.0123456789eE");
        snprintf(changed, sizeof changed, "%.*s%s%s", (int)(place - json), json, numbers[number], place + length);
        toliman_sim_plan_info plan = {.struct_size = sizeof plan};
        const int32_t status = toliman_sim_plan_json(changed, strlen(changed), NULL, NULL, &plan);
        if (number < UNREAL)
            assert_true(status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_SCENE);
        else if (status == TOLIMAN_OK)
            assert_finite((const double[]){plan.accuracy, plan.spectrum_error, plan.pupil_error}, 3);
    }
}

FIXTURE(print_summary) {
    print_message("%llu numbers that are not finite, %llu odd ones\n", (unsigned long long)not_finite,
                  (unsigned long long)odd);
    return 0;
}

int main(void) {
    const char *given = getenv("TOLIMAN_STORMS");
    storms = given != NULL ? (uint64_t)atoll(given) : storms;
    return RUN_ALL(NULL, print_summary);
}
