/* Tests the edges, rotation and shift of a spiral mask on the cells of the pupil: areas against geometry, the image
 * against a direct sum of averaged transmissions, and its smoothness in rotation. */
#include <complex.h>

#include "long_double_sim.h"

enum { N = 64, SIDE = 32, PIXELS = SIDE * SIDE };

static const double kStep = 275e-9, kAperture = 0.125;
static const char *const kSpiral =
    "{\"a\": 0.8, \"f\": 2.9, \"m\": -4, \"p\": 4.8}, {\"a\": 0.9, \"f\": 1.8, \"l\": 1.5, \"m\": 5}";

/* The single star with a mask of these terms and keys in its telescope. */
static toliman_sim *masked(const char *terms, const char *keys) {
    char telescope[500];
    snprintf(telescope, sizeof telescope,
             "\"mask\": {\"kind\": \"spiral\", \"opd_nm\": 275, %s\"terms\": [%s]}, \"aperture_m\"", keys, terms);
    return sim_with(kSingleScene, "\"aperture_m\"", telescope);
}

/* Covered fraction of each cell; -1 where the pupil is closed. */
static void covered_of(const char *terms, const char *keys, double *covered) {
    static double amplitude[N * N];
    toliman_sim *const sim = masked(terms, keys);
    assert_ok(toliman_sim_get_pupil(sim, amplitude, covered));
    toliman_sim_destroy(sim);
    for (int i = 0; i < N * N; i++)
        covered[i] = amplitude[i] > 0 ? covered[i] / kStep : -1;
}

static void image_with(const char *keys, double *image) {
    toliman_sim *const sim = masked(kSpiral, keys);
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, SIDE));
    toliman_sim_destroy(sim);
}

static double peak_of(const double *image) {
    double peak = 0;
    for (int i = 0; i < PIXELS; i++)
        peak = fmax(peak, fabs(image[i]));
    return peak;
}

/* Area of the part of the unit square around the origin where x cos + y sin > d, by clipping its polygon. */
static double area_beyond(double cosine, double sine, double d) {
    const double corner[5][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}, {-0.5, -0.5}};
    double kept[8][2], area = 0;
    int count = 0;
    for (int i = 0; i < 4; i++) {
        const double from = corner[i][0] * cosine + corner[i][1] * sine - d;
        const double to = corner[i + 1][0] * cosine + corner[i + 1][1] * sine - d;
        if (from > 0)
            memcpy(kept[count++], corner[i], sizeof *kept);
        if ((from > 0) != (to > 0)) {
            for (int axis = 0; axis < 2; axis++)
                kept[count][axis] = corner[i][axis] + from / (from - to) * (corner[i + 1][axis] - corner[i][axis]);
            count++;
        }
    }
    for (int i = 0; i < count; i++) {
        const double *const p = kept[i], *const q = kept[(i + 1) % count];
        area += 0.5 * (p[0] * q[1] - p[1] * q[0]);
    }
    return area;
}

/* cos(theta) > 0 is a half-plane; its edge is rotated by 20 deg about the centre, which is shifted by 3.2, -1.7 cells.
 */
TEST(straight_edges_cover_exact_areas) {
    static double covered[N * N];
    const double cell = kAperture / N, angle = 20 * M_PI / 180, x0 = 3.2, y0 = -1.7;
    char keys[200];
    snprintf(keys, sizeof keys, "\"edges\": \"area\", \"rotation_deg\": 20, \"shift_m\": [%.17g, %.17g], ", x0 * cell,
             y0 * cell);
    covered_of("{\"a\": 1, \"m\": 1}", keys, covered);
    int mixed = 0;
    for (int i = 0; i < N * N; i++) {
        const double x = i % N - 0.5 * (N - 1) - x0, y = i / N - 0.5 * (N - 1) - y0;
        if (covered[i] < 0)
            continue;
        const double expected = area_beyond(cos(angle), sin(angle), -x * cos(angle) - y * sin(angle));
        mixed += expected > 0 && expected < 1;
        /* near the centre theta has no tangent plane */
        assert_close(covered[i], expected, 0, hypot(x, y) > 4 ? 1e-5 : 2e-3);
    }
    assert_true(mixed > N / 2);
}

/* cos(2 pi f r) > 0 for r < 1/(4 f), and again for r > 3/(4 f) = 1.2: a disc of 0.4 radii, wherever it is shifted. */
TEST(discs_cover_their_area) {
    static double covered[N * N];
    const char *const places[] = {"", "\"shift_m\": [0.003, -0.0011], ", "\"shift_m\": [0, 0.00101], "};
    for (size_t place = 0; place < 3; place++) {
        char keys[100];
        snprintf(keys, sizeof keys, "\"edges\": \"area\", %s", places[place]);
        covered_of("{\"a\": 1, \"f\": 0.625}", keys, covered);
        double area = 0;
        for (int i = 0; i < N * N; i++)
            area += fmax(0, covered[i]);
        assert_close(area, M_PI * pow(0.4 * N / 2, 2), 2e-5, 0);
    }
}

/* Index of the cell that a rotation by `turns` times 90 deg from +x towards +y brings to cell i. */
static int cell_before(int i, int turns) {
    int x = i % N, y = i / N;
    for (int turn = 0; turn < turns; turn++) {
        const int old_x = x;
        x = y;
        y = N - 1 - old_x;
    }
    return y * N + x;
}

TEST(right_angles_rotate_the_cells) {
    static double still[N * N], rotated[N * N];
    for (int area = 0; area < 2; area++)
        for (int turns = 1; turns < 4; turns++) {
            char keys[100];
            snprintf(keys, sizeof keys, "\"edges\": \"%s\", ", area ? "area" : "cell");
            covered_of(kSpiral, keys, still);
            snprintf(keys, sizeof keys, "\"edges\": \"%s\", \"rotation_deg\": %d, ", area ? "area" : "cell",
                     90 * turns);
            covered_of(kSpiral, keys, rotated);
            for (int i = 0; i < N * N; i++)
                assert_close(rotated[i], still[cell_before(i, turns)], 0, 1e-10);
        }
}

/* A shift by whole cells moves their fractions. */
TEST(whole_cells_shift_the_cells) {
    static double still[N * N], shifted[N * N];
    covered_of(kSpiral, "\"edges\": \"area\", ", still);
    char keys[100];
    snprintf(keys, sizeof keys, "\"edges\": \"area\", \"shift_m\": [%.17g, %.17g], ", 2 * kAperture / N,
             -3 * kAperture / N);
    covered_of(kSpiral, keys, shifted);
    int compared = 0;
    for (int y = 0; y < N - 3; y++)
        for (int x = 2; x < N; x++)
            if (shifted[y * N + x] >= 0 && still[(y + 3) * N + x - 2] >= 0) {
                assert_close(shifted[y * N + x], still[(y + 3) * N + x - 2], 0, 1e-10);
                compared++;
            }
    assert_true(compared > N * N / 2);
}

/* The keys' defaults are the mask without them, bit for bit. */
TEST(defaults_change_nothing) {
    double plain[PIXELS], named[PIXELS];
    image_with("", plain);
    image_with("\"edges\": \"area\", \"rotation_deg\": 0, \"shift_m\": [0, 0], ", named);
    assert_memory_equal(plain, named, sizeof plain);
}

/* F = sum of A (1 - c + c exp(2 pi i s/lambda)) exp(2 pi i (Zernike - x u - y v)/lambda), in long double. The
 * wavelength is not that of a half-wave step, so that the average has a phase of its own. */
TEST(transmissions_are_averaged) {
    static double amplitude[N * N], mean[N * N], smooth[N * N];
    const long double wavelength = 610e-9L, scale = 0.125L / N * 0.2L * M_PIl / 648000 / wavelength;
    const char *const zernike = "\"aberrations\": {\"zernike_rms_nm\": {\"7\": 30}}, \"aperture_m\"";
    char *text = replaced(kSingleScene, "550", "610"), mask[400];
    text = replaced_again(text, "\"aperture_m\"", zernike);
    toliman_sim *const unmasked = sim_of(text);
    assert_ok(toliman_sim_get_pupil(unmasked, amplitude, smooth));
    toliman_sim_destroy(unmasked);
    snprintf(mask, sizeof mask,
             "\"mask\": {\"kind\": \"spiral\", \"opd_nm\": 275, \"edges\": \"area\", \"terms\": [%s]}, \"aperture_m\"",
             kSpiral);
    text = replaced_again(text, "\"aperture_m\"", mask);
    toliman_sim *const sim = sim_of(text);
    assert_ok(toliman_sim_get_pupil(sim, amplitude, mean));
    double *const image = image_of(sim, TOLIMAN_SIM_IMAGE_BOTH);
    long double expected[PIXELS / 37 + 1], peak = 0, found = 0;
    for (int pixel = 0, k = 0; pixel < PIXELS; pixel += 37, k++) {
        const long double u = pixel % SIDE - 0.5L * (SIDE - 1), v = pixel / SIDE - 0.5L * (SIDE - 1);
        long double complex field = 0;
        for (int i = 0; i < N * N; i++) {
            const long double x = (i % N) - 0.5L * (N - 1), y = (i / N) - 0.5L * (N - 1);
            const long double c = (mean[i] - smooth[i]) / kStep;
            field += amplitude[i] * (1 - c + c * cis(275e-9L / wavelength)) *
                     cis(smooth[i] / wavelength - scale * (x * u + y * v));
        }
        expected[k] = creall(field * conjl(field));
        peak = fmaxl(peak, expected[k]);
        found = fmaxl(found, image[pixel]);
    }
    for (int pixel = 0, k = 0; pixel < PIXELS; pixel += 37, k++) /* the scene is scaled to its peak */
        assert_close(image[pixel] / (double)found, (double)(expected[k] / peak), 0, 1e-10);
    free(text), free(image), toliman_sim_destroy(sim);
}

static void difference_at(const char *edges, double step_deg, double *difference) {
    double before[PIXELS], after[PIXELS];
    for (int side = 0; side < 2; side++) {
        char keys[100];
        snprintf(keys, sizeof keys, "\"edges\": \"%s\", \"rotation_deg\": %.17g, ", edges, side ? step_deg : -step_deg);
        image_with(keys, side ? after : before);
    }
    for (int i = 0; i < PIXELS; i++)
        difference[i] = (after[i] - before[i]) / (2 * step_deg);
}

/* Central differences at steps of 1e-3 and 1e-4 deg agree. By the sign at the centre the image is a staircase: no cell
 * changes within 1e-3 deg, many do within 1 deg. */
TEST(area_is_smooth_in_rotation) {
    double coarse[PIXELS], fine[PIXELS];
    difference_at("area", 1e-3, coarse);
    difference_at("area", 1e-4, fine);
    const double most = peak_of(coarse);
    assert_at_most(1, most);
    for (int i = 0; i < PIXELS; i++)
        assert_close(coarse[i], fine[i], 0, 1e-3 * most);
    difference_at("cell", 1e-3, coarse);
    assert_true(peak_of(coarse) == 0);
    difference_at("cell", 1, coarse);
    assert_at_most(1, peak_of(coarse));
}

/* The baseline engine averages, too. With pixels of lambda/(4 D) its array of 128 has exactly 32 pupil samples. */
TEST(both_engines_average) {
    char mask[400], scale[60];
    snprintf(mask, sizeof mask,
             "\"mask\": {\"kind\": \"spiral\", \"opd_nm\": 200, \"edges\": \"area\", \"terms\": [%s]}, \"aperture_m\"",
             kSpiral);
    snprintf(scale, sizeof scale, "\"pixel_scale_arcsec\": %.17g", 550e-9 / (4 * kAperture) * 648000 / M_PI);
    char *text = replaced(kSingleScene, "\"aperture_m\"", mask);
    text = replaced_again(text, "\"pixel_scale_arcsec\": 0.2", scale);
    text = replaced_again(text, "\"pupil_samples\": 64", "\"pupil_samples\": 32");
    double image[2][PIXELS];
    const int32_t engines[] = {TOLIMAN_SIM_ENGINE_MATRIX_DFT, TOLIMAN_SIM_ENGINE_PADDED_FFT};
    for (int i = 0; i < 2; i++) {
        toliman_sim_options options = {.struct_size = sizeof options, .engine = engines[i]};
        toliman_sim *sim = NULL;
        assert_ok(toliman_sim_create_json(text, strlen(text), NULL, &options, &sim));
        assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image[i], SIDE));
        toliman_sim_destroy(sim);
    }
    for (int i = 0; i < PIXELS; i++)
        assert_close(image[1][i], image[0][i], 0, 1e-12 * peak_of(image[0]));
    free(text);
}

TEST(refusals) {
    static const char *const cases[][2] = {
        {"\"spiral\", \"edges\": \"soft\"", "mask.edges = \"soft\": must be one of \"cell\", \"area\""},
        {"\"spiral\", \"edges\": true", "mask.edges = true: must be a string"},
        {"\"spiral\", \"rotation_deg\": -361", "mask.rotation_deg = -361: must be in [-360, 360] deg"},
        {"\"spiral\", \"rotation_deg\": \"1\"", "mask.rotation_deg = \"1\": must be a number in [-360, 360] deg"},
        {"\"spiral\", \"shift_m\": 0.001", "mask.shift_m = 0.001: must be an array of numbers"},
        {"\"spiral\", \"shift_m\": [0.001]", "mask.shift_m: has 1 numbers: must have 2 to 2"},
        {"\"spiral\", \"shift_m\": [0, 1e300]", "mask.shift_m[1] = 1e+300: must be in [-0.1, 0.1] m"},
        {"\"file\", \"edges\": \"area\"", "telescope.mask.edges: needs kind \"spiral\""},
        {"\"file\", \"rotation_deg\": 1", "telescope.mask.rotation_deg: needs kind \"spiral\""},
        {"\"clear\", \"shift_m\": [0, 0]", "telescope.mask.shift_m: needs kind \"spiral\""}};
    char *const text = replaced(kBinaryScene, "\"edges\": \"cell\", ", "");
    check_additions(text, "\"spiral\"", "%s", cases, sizeof cases / sizeof *cases);
    free(text);
}

RUN_TESTS(NULL, NULL)
