/* Tests the model of sums of frames against sums of the models of single frames, for normal and other distributions of
 * places, and its noise; and that spreads which no places have are refused. */
#include <stdlib.h>

#include "coadd_frames.h"
#include "images.h"

enum { PLACES = 400, N = 7 };

static toliman_fit *fit;

FIXTURE(make_fit) {
    fit = coadd_fit("'pixel_scale_arcsec': 0.2, 'bias_dn': 100, 'gain_e_per_dn': 2, 'bit_depth': 12, "
                    "'dark_e_per_s': 30, 'qe': 0.9, 'flat_rms': 0.02}");
    return 0;
}

FIXTURE(destroy_fit) {
    toliman_fit_destroy(fit);
    return 0;
}

/* The cumulants of equal weights, by their formulas in central moments. */
static double moment(double (*places)[2], int a, int b) {
    long double sum = 0;
    for (int k = 0; k < PLACES; k++)
        sum += powl(places[k][0], a) * powl(places[k][1], b);
    return (double)(sum / PLACES);
}

static double kappa(double (*p)[2], int a, int b) {
    const double m = moment(p, a, b);
    const int n = a + b;
    /* Sums over all partitions of a x and b y into blocks, blocks of one being 0. */
    static const double kChoose[7][7] = {
        {1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}, {1, 6, 15, 20, 15, 6, 1}};
    if (n == 3)
        return m;
    /* m_ab = sum over the block that contains the first x (or y): i x and j y more. */
    double sum = m;
    for (int i = 0; i <= (a > 0 ? a - 1 : 0); i++)
        for (int j = 0; j <= (a > 0 ? b : b - 1); j++) {
            const int in_a = a > 0 ? i + 1 : 0, in_b = a > 0 ? j : j + 1, size = in_a + in_b;
            if (size < 2 || size == n || n - size < 2)
                continue;
            const double ways = a > 0 ? kChoose[a - 1][i] * kChoose[b][j] : kChoose[b - 1][j];
            const double block = size == 2 ? moment(p, in_a, in_b) : kappa(p, in_a, in_b);
            sum -= ways * block * moment(p, a - in_a, b - in_b);
        }
    return sum;
}

static toliman_spread spread_of(double (*places)[2]) {
    toliman_spread spread = {.struct_size = sizeof spread,
                             .frames = PLACES,
                             .xx_px2 = moment(places, 2, 0),
                             .yy_px2 = moment(places, 0, 2),
                             .xy_px2 = moment(places, 1, 1)};
    int i = 0;
    for (int n = 3; n <= 6; n++)
        for (int b = 0; b <= n; b++)
            spread.cumulants[i++] = kappa(places, n - b, b);
    return spread;
}

static void centre(double (*places)[2]) {
    for (int axis = 0; axis < 2; axis++) {
        long double mean = 0;
        for (int k = 0; k < PLACES; k++)
            mean += places[k][axis] / PLACES;
        for (int k = 0; k < PLACES; k++)
            places[k][axis] -= (double)mean;
    }
}

/* The largest error of the model of a sum, over its peak. */
static double error_of(double (*places)[2], const toliman_spread *spread, double x, double y) {
    static double sum[COADD_PIXELS], image[COADD_PIXELS];
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < PLACES; k++) {
        coadd_expect(fit, x + places[k][0], y + places[k][1], image);
        for (int p = 0; p < COADD_PIXELS; p++)
            sum[p] += image[p];
    }
    const toliman_fit_prediction place = {.struct_size = sizeof place, .x_px = x, .y_px = y, .spread = spread};
    assert_ok(toliman_fit_predict(fit, &place, image, COADD_SIDE, NULL, NULL));
    double worst = 0, peak = 0;
    for (int p = 0; p < COADD_PIXELS; p++) {
        worst = fmax(worst, fabs(image[p] - sum[p]));
        peak = fmax(peak, sum[p] - PLACES * COADD_BIAS);
    }
    return worst / peak;
}

TEST(sums_are_those_of_single_frames) {
    uint64_t state = 8;
    static double places[PLACES][2];
    for (int kind = 0; kind < 3; kind++) {
        for (int k = 0; k < PLACES; k++) {
            const double a = noise(&state), b = noise(&state), t = 2 * 3.14159265358979 * uniform(&state);
            places[k][0] = kind == 0 ? 0.3 * a : kind == 1 ? 0.4 * sin(t) : 0.5 * uniform_signed(&state);
            places[k][1] = kind == 0 ? 0.2 * b + 0.1 * a : kind == 1 ? 0.2 * sin(2 * t + 1) : 0.3 * b;
        }
        centre(places);
        toliman_spread spread = spread_of(places);
        const double exact = error_of(places, &spread, 0.37, -0.21);
        memset(spread.cumulants, 0, sizeof spread.cumulants);
        const double normal = error_of(places, &spread, 0.37, -0.21);
        print_message("places %d: error with cumulants %.1e of the peak, without %.1e\n", kind, exact, normal);
        assert_at_most(exact, 3e-5);
        assert_true(normal > 10 * exact);
    }
}

/* One long exposure with the jitter of the scene. */
TEST(a_normal_spread_is_the_jitter_of_a_scene) {
    static double image[COADD_PIXELS], other[COADD_PIXELS];
    const toliman_spread spread = {.struct_size = sizeof spread, .xx_px2 = 0.09, .yy_px2 = 0.05, .xy_px2 = 0.02};
    const toliman_fit_prediction place = {.struct_size = sizeof place, .spread = &spread};
    assert_ok(toliman_fit_predict(fit, &place, image, COADD_SIDE, NULL, NULL));
    memset(other, 0, sizeof other);
    /* Gauss-Hermite quadrature of order 9 along both axes of the ellipse */
    static const double node[9] = {0,
                                   0.7235510187528376,
                                   1.4685532892166679,
                                   2.2665805845318431,
                                   3.1909932017815276,
                                   -0.7235510187528376,
                                   -1.4685532892166679,
                                   -2.2665805845318431,
                                   -3.1909932017815276};
    static const double weight[9] = {0.7202352156060510,   0.4326515590025558,    0.08847452739437657,
                                     0.004943624275536947, 3.960697726326438e-05, 0.4326515590025558,
                                     0.08847452739437657,  0.004943624275536947,  3.960697726326438e-05};
    const double pi = 3.14159265358979323846, lower = 0.02 / 0.3, rest = sqrt(0.05 - lower * lower);
    for (int i = 0; i < 9; i++)
        for (int j = 0; j < 9; j++) {
            static double one[COADD_PIXELS];
            const double u = sqrt(2) * node[i], v = sqrt(2) * node[j];
            coadd_expect(fit, 0.3 * u, lower * u + rest * v, one);
            for (int p = 0; p < COADD_PIXELS; p++)
                other[p] += weight[i] * weight[j] / pi * one[p];
        }
    for (int p = 0; p < COADD_PIXELS; p++)
        assert_close(image[p], other[p], 0, 2e-6 * 200);
}

/* The bound of a sum is that of one frame over the root of their number, with read noise and bias of all. */
TEST(sums_have_the_noise_of_their_frames) {
    double one[N * N], sum[N * N], values[N];
    const toliman_spread spread = {.struct_size = sizeof spread, .frames = 400};
    const toliman_fit_prediction place = {.struct_size = sizeof place, .spread = &spread};
    static double image[COADD_PIXELS], expected[COADD_PIXELS];
    assert_ok(toliman_fit_predict(fit, NULL, expected, COADD_SIDE, values, one));
    assert_ok(toliman_fit_predict(fit, &place, image, COADD_SIDE, NULL, sum));
    for (int i = 0; i < N; i++)
        assert_close(sum[i * N + i] * (i == 6 ? 1 : 400) / (i == 6 ? 400 : 1), one[i * N + i], 1e-9, 0);
    for (int p = 0; p < COADD_PIXELS; p++)
        assert_close(image[p], 400 * expected[p], 1e-12, 0);
    toliman_fit_result result = {.struct_size = sizeof result};
    assert_ok(toliman_fit_frame(fit, PLAIN_IMAGE(image), 1, &place, &result, values, NULL));
    assert_close(result.displacement_px, 0, 0, 1e-7);
    assert_close(result.flux_a, 0, 0, 1e-7);
    assert_close(result.background, 0, 0, 1e-4);
    assert_int_equal(result.flags, 0);
}

TEST(impossible_spreads_are_refused) {
    static const struct {
        toliman_spread spread;
        const char *field;
    } kCases[] = {{{.reserved = 1}, "prediction->spread->reserved"},
                  {{.frames = -1}, "prediction->spread->frames"},
                  {{.frames = 0.5}, "prediction->spread->frames"},
                  {{.frames = 1e13}, "prediction->spread->frames"},
                  {{.xx_px2 = -1e-9}, "prediction->spread->xx_px2"},
                  {{.yy_px2 = 5}, "prediction->spread->yy_px2"},
                  {{.xx_px2 = NAN}, "prediction->spread->xx_px2"},
                  {{.xx_px2 = 0.1, .yy_px2 = 0.1, .xy_px2 = -0.11}, "prediction->spread->xy_px2"},
                  {{.xx_px2 = 0.1, .cumulants = {0, 0, INFINITY}}, "prediction->spread->cumulants[2]"},
                  {{.cumulants = {1e-3}}, "prediction->spread->cumulants[0]"}};
    for (size_t i = 0; i < sizeof kCases / sizeof *kCases; i++) {
        toliman_spread spread = kCases[i].spread;
        spread.struct_size = sizeof spread;
        const toliman_fit_prediction place = {.struct_size = sizeof place, .spread = &spread};
        double values[N];
        assert_invalid(toliman_fit_predict(fit, &place, NULL, 0, values, NULL), kCases[i].field);
    }
    const toliman_spread spread = {.struct_size = sizeof spread};
    const toliman_fit_prediction place = {.struct_size = sizeof place, .spread = &spread};
    const toliman_fit_prediction sum = {.struct_size = sizeof sum,
                                        .spread = &(toliman_spread){.struct_size = sizeof spread, .frames = 2}};
    toliman_coadd *coadd = NULL;
    assert_ok(toliman_coadd_create(fit, &place, NULL, &coadd)); /* one frame that does not move */
    toliman_coadd_destroy(coadd), coadd = NULL;
    assert_invalid(toliman_coadd_create(fit, &sum, NULL, &coadd), "prediction->spread");
}

RUN_TESTS(make_fit, destroy_fit)
