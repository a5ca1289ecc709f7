/* Tests the fit of the OPD map: prior against slow sums, derivatives against differences of propagated frames, adjoint
 * against derivatives, and a fit that finds an unknown map. */
#include <complex.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

void *shim_map_make(const char *json, const char *free, size_t frames, const double *own, const double *truth,
                    unsigned workers);
void shim_map_destroy(void *made);
void shim_map_image(const void *made, size_t frame, const double *opd_m, double h, double *image);
void shim_map_derivative(const void *made, const double *opd_m, double *images);
void shim_map_adjoint(const void *made, const double *opd_m, double (*random)(void), double *numbers);
void shim_map_product(const void *made, const double *opd_m, double *product);
double shim_map_matrices(const void *made);
double shim_map_solver(const void *made, double (*random)(void));
void shim_map_fit(void *made, size_t steps, double *errors, double *numbers, double *map_m);
void shim_map_step(const void *made, size_t windows, double *map_m, double *amplitude, double *numbers);
void shim_map_prior(size_t n, double rms_m, const double *unknown, const double *curvature, double *const *out);

enum { N = 64, CELLS = N * N, SIDE = 64, PIXELS = SIDE * SIDE, FRAMES = 3, STEPS = 3 };

/* The mission telescope in small: three struts, a spiral mask of few edges, three wavelengths. */
static const char *const kScene =
    "{\"schema\": \"toliman-scene/1\","
    " \"telescope\": {\"aperture_m\": 0.125, \"secondary_m\": 0.032, \"pupil_samples\": 64,"
    "  \"struts\": {\"count\": 3, \"width_m\": 0.003, \"angle_deg\": 20},"
    "  \"mask\": {\"kind\": \"spiral\", \"opd_nm\": 292.5, \"edges\": \"area\","
    "   \"terms\": [{\"a\": 1, \"f\": 1.2, \"m\": -5, \"p\": 1}]}},"
    " \"band\": {\"min_nm\": 530, \"max_nm\": 640, \"step_nm\": 55},"
    " \"stars\": {\"A\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5790}, \"photons_per_s\": 7e11},"
    "  \"B\": {\"spectrum\": {\"kind\": \"blackbody\", \"temperature_k\": 5260}, \"photons_per_s\": 3e11}},"
    " \"binary\": {\"offsets_px\": {\"A\": [-6.4, 8.3], \"B\": [7.1, -9.6]}},"
    " \"cadence\": {\"frames\": 4, \"interval_days\": 30, \"exposure_s\": 1},"
    " \"detector\": {\"shape\": [64, 64], \"pixel_scale_arcsec\": 0.375},"
    " \"accuracy\": 1e-9}";

/* Changes of the places of the scene, relative fluxes, background. */
static const double kOwn[FRAMES][7] = {{0.31, -0.12, 0.28, -0.1, 1e-3, -2e-3, 1e4},
                                       {-0.4, 0.25, -0.1, 0.31, -1e-3, 1e-3, 2e4},
                                       {0.05, 0.44, 0.5, 0.2, 2e-3, 0, 1.5e4}};

static double truth[CELLS], opd[2][CELLS];

static uint64_t numbers_state;

static double random_number(void) {
    return uniform_signed(&numbers_state);
}

/* Waves of 4 to 20 cycles per aperture with the prior's spectrum, `rms` m together. */
static void random_map(double rms, double *map) {
    memset(map, 0, CELLS * sizeof *map);
    for (int wave = 0; wave < 200; wave++) {
        const double frequency = 4 + 8 * (random_number() + 1), angle = acos(-1) * random_number(),
                     phase = acos(-1) * random_number(), turn = 2 * acos(-1) / N * frequency, x = turn * cos(angle),
                     y = turn * sin(angle);
        /* as many waves of each frequency as the plane has: proportional to it */
        const double amplitude = pow(frequency, -0.75);
        for (int i = 0; i < CELLS; i++)
            map[i] += amplitude * cos(x * (i % N) + y * (i / N) + phase);
    }
    double sum = 0;
    for (int i = 0; i < CELLS; i++)
        sum += map[i] * map[i];
    for (int i = 0; i < CELLS; i++)
        map[i] *= rms / sqrt(sum / CELLS);
}

static int set_up(void **unused) {
    numbers_state = 3;
    random_map(1e-9, truth);
    for (int i = 0; i < 2; i++)
        random_map(1e-9, opd[i]);
    return 0;
}

static void *make_case(unsigned workers) {
    double own[FRAMES][7];
    const double places[7] = {-6.4, 8.3, 7.1, -9.6, 0, 0, 0};
    for (int k = 0; k < FRAMES; k++)
        for (int i = 0; i < 7; i++)
            own[k][i] = kOwn[k][i] + places[i];
    return shim_map_make(kScene, "scale mask_rotation temperature_a focus zernike_5-11", FRAMES, own[0], truth,
                         workers);
}

/* Unknowns of one wave have the spectrum's amplitude at its frequency; of white noise, the map has the variance. */
TEST(prior_filters) {
    enum { SIZE = 24 };
    static double unknown[SIZE * SIZE], map[SIZE * SIZE], back[SIZE * SIZE], filtered[SIZE * SIZE];
    double *const out[] = {map, back, filtered};
    const double rms = 3e-9, curvature[3] = {2e17, 5e18, 3};
    double power[SIZE * SIZE], mean = 0;
    for (int i = 0; i < SIZE * SIZE; i++) {
        const int y = i / SIZE <= SIZE / 2 ? i / SIZE : SIZE - i / SIZE,
                  x = i % SIZE <= SIZE / 2 ? i % SIZE : SIZE - i % SIZE;
        power[i] = hypot(x, y) <= 4 ? 1 : pow(hypot(x, y) / 4, -2.5);
        mean += power[i] / (SIZE * SIZE);
    }
    const int waves[][2] = {{0, 0}, {1, 2}, {4, 0}, {5, 3}, {12, 12}, {20, 7}};
    for (size_t w = 0; w < sizeof waves / sizeof *waves; w++)
        for (int odd = 0; odd < 2; odd++) {
            const double gain = power[waves[w][0] * SIZE + waves[w][1]] * rms * rms / mean;
            for (int i = 0; i < SIZE * SIZE; i++) { /* even or odd about the centre between the cells */
                const double phase =
                    2 * acos(-1) / SIZE *
                    (waves[w][0] * (i / SIZE - 0.5 * (SIZE - 1)) + waves[w][1] * (i % SIZE - 0.5 * (SIZE - 1)));
                unknown[i] = odd ? sin(phase) : cos(phase);
            }
            shim_map_prior(SIZE, rms, unknown, curvature, out);
            for (int i = 0; i < SIZE * SIZE; i++) {
                assert_close(map[i], sqrt(gain) * unknown[i], 0, 1e-14 * rms);
                assert_close(back[i], unknown[i], 0, 1e-12);
                assert_close(filtered[i], unknown[i] / (3 + curvature[odd] * gain), 0, 1e-14);
            }
        }
}

TEST(derivatives_predict_frames) {
    static double images[FRAMES][PIXELS], at[4][PIXELS];
    void *const made = make_case(1);
    shim_map_derivative(made, opd[0], images[0]);
    for (size_t k = 0; k < FRAMES; k++) {
        const double steps[] = {-1, 1, -0.5, 0.5};
        double error = 0, largest = 0;
        for (int i = 0; i < 4; i++)
            shim_map_image(made, k, opd[0], steps[i], at[i]);
        for (int i = 0; i < PIXELS; i++) {
            const double slope = (8 * (at[3][i] - at[2][i]) - (at[1][i] - at[0][i])) / 6;
            error = fmax(error, fabs(images[k][i] - slope));
            largest = fmax(largest, fabs(slope));
        }
        print_message("frame %zu: error %.2g of the largest derivative\n", k, error / largest);
        assert_at_most(error, 1e-3 * largest);
    }
    shim_map_destroy(made);
}

TEST(adjoint_transposes) {
    static double images[2][FRAMES * PIXELS], products[2][CELLS], frame[PIXELS];
    void *const made = make_case(2);
    double numbers[3];
    shim_map_adjoint(made, opd[0], random_number, numbers);
    print_message("adjoint: difference %.2g\n", (numbers[0] - numbers[1]) / numbers[2]);
    assert_close(numbers[0], numbers[1], 0, 1e-13 * numbers[2]);
    double by_cells[2] = {0}, by_pixels = 0;
    for (int i = 0; i < 2; i++) {
        shim_map_derivative(made, opd[i], images[i]);
        shim_map_product(made, opd[i], products[i]);
    }
    for (int i = 0; i < CELLS; i++) {
        by_cells[0] += opd[1][i] * products[0][i];
        by_cells[1] += opd[0][i] * products[1][i];
    }
    for (size_t k = 0; k < FRAMES; k++) {
        shim_map_image(made, k, opd[0], 0, frame);
        for (size_t i = 0; i < PIXELS; i++)
            by_pixels += images[0][k * PIXELS + i] * images[1][k * PIXELS + i] / frame[i];
    }
    assert_close(by_cells[0], by_cells[1], 1e-12, 0);
    print_message("normal matrix: difference %.2g\n", by_cells[0] / by_pixels - 1);
    assert_close(by_cells[0], by_pixels, 1e-3, 0);
    const double difference = shim_map_matrices(made);
    print_message("matrices: difference %.2g\n", difference);
    assert_at_most(difference, 1e-3);
    shim_map_destroy(made);
}

/* Without noise, a map of 1 nm is found by its effect on the separations: from a fit of Zernike polynomials. */
TEST(fit_finds_the_map) {
    static double map[CELLS];
    double errors[STEPS + 1][FRAMES], numbers[STEPS][4], rms[STEPS + 1];
    void *const made = make_case(2);
    shim_map_fit(made, STEPS, errors[0], numbers[0], map);
    shim_map_destroy(made);
    for (int s = 0; s <= STEPS; s++) {
        rms[s] = 0;
        for (int k = 0; k < FRAMES; k++)
            rms[s] += errors[s][k] * errors[s][k] / FRAMES;
        rms[s] = sqrt(rms[s]);
        print_message("separations wrong by %.3g px rms", rms[s]);
        if (s < STEPS)
            print_message("; chi-square %.4g, %g iterations, residual %.2g, step %.3g nm", numbers[s][0], numbers[s][1],
                          numbers[s][2], 1e9 * numbers[s][3]);
        print_message("\n");
    }
    assert_at_most(rms[STEPS], 3e-6);
    assert_at_most(rms[STEPS], rms[0] / 30);
    assert_at_most(numbers[STEPS - 1][0], 1e-3 * numbers[0][0]);
}

/* The part of the map that is odd about the centre, without tilts, which places contain, and without what no frame
 * shows: light that the highest frequencies scatter outside. */
static double odd_error(const double *map, const double *amplitude, double *size) {
    double error = 0, sums[5] = {0};
    *size = 0;
    static double difference[CELLS];
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < CELLS; i++) {
            const double x = i % N - 0.5 * (N - 1), y = (double)(i / N) - 0.5 * (N - 1),
                         odd = 0.5 * (truth[i] - truth[CELLS - 1 - i]);
            if (pass == 0) {
                difference[i] = 0.5 * (map[i] - map[CELLS - 1 - i]) - odd;
                sums[0] += amplitude[i] * x * x;
                sums[1] += amplitude[i] * y * y;
                sums[2] += amplitude[i] * x * y;
                sums[3] += amplitude[i] * x * difference[i];
                sums[4] += amplitude[i] * y * difference[i];
                continue;
            }
            const double determinant = sums[0] * sums[1] - sums[2] * sums[2],
                         tilt_x = (sums[3] * sums[1] - sums[4] * sums[2]) / determinant,
                         tilt_y = (sums[4] * sums[0] - sums[3] * sums[2]) / determinant;
            error += amplitude[i] * pow(difference[i] - tilt_x * x - tilt_y * y, 2);
            *size += amplitude[i] * odd * odd;
        }
    return error;
}

/* A step from the true parameters finds most of the odd part of the map; threads change no bit of it, and two windows
 * little. */
TEST(step_finds_the_odd_part) {
    static double maps[3][CELLS], amplitude[CELLS];
    double numbers[3][3];
    for (int run = 0; run < 3; run++) {
        void *const made = make_case(run == 0 ? 1 : 2);
        shim_map_step(made, run == 2 ? 2 : 1, maps[run], amplitude, numbers[run]);
        shim_map_destroy(made);
        double size;
        const double error = odd_error(maps[run], amplitude, &size);
        print_message("odd part wrong by %.2g of its rms, chi-square %.4g, %g iterations, residual %.2g\n",
                      sqrt(error / size), numbers[run][0], numbers[run][1], numbers[run][2]);
        assert_at_most(error, 0.25 * size);
    }
    assert_memory_equal(maps[0], maps[1], sizeof maps[0]);
    assert_memory_equal(numbers[0], numbers[1], sizeof numbers[0]);
}

/* Parameters other than the map: the solver of the conjugate gradients against the steps without map. */
TEST(solver_agrees_with_steps) {
    void *const made = make_case(1);
    const double difference = shim_map_solver(made, random_number);
    print_message("solver: difference %.2g\n", difference);
    assert_at_most(difference, 1e-9);
    shim_map_destroy(made);
}

RUN_TESTS(set_up, NULL)
