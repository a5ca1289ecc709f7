/* Phases, pupil fields and intensities against long double. */
#include <complex.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"

void shim_cis(double cycles, double *cosine, double *sine);
double shim_reduce(double x);
double shim_blackbody(double wavelength_m, double temperature_k);
void shim_pupil_field(const double *amplitude, const double *opd_m, size_t n, double wavenumber, const double *tilt_x,
                      const double *tilt_y, double *re, double *im);
void shim_tilt_derivative(double *re, double *im, size_t n, double step_x, double step_y);
void shim_images(double *planes, size_t count, double weight, double axis_x, double axis_y, double *intensity,
                 double *derivative, double *curvature);

static const long double kTwoPi = 6.28318530717958647692528676655900577L;

/* Numbers in [-1, 1], the same on every machine. */
static double number(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-52 - 1;
}

static void cis_is_exact_to_rounding(void **state) {
    (void)state;
    const double corners[] = {0, 0.125, -0.125, 0.25, -0.25, 0.375, -0.375, 0.5, -0.5, 1e-300};
    double worst = 0;
    uint64_t random = 1;
    for (int i = 0; i < 200000; i++) {
        const double cycles = i < 10 ? corners[i] : 0.5 * number(&random);
        double cosine, sine;
        shim_cis(cycles, &cosine, &sine);
        worst = fmax(worst, (double)fabsl(cosine - cosl(kTwoPi * cycles)));
        worst = fmax(worst, (double)fabsl(sine - sinl(kTwoPi * cycles)));
    }
    assert_at_most(worst, 2e-16);
    for (int quarter = -2; quarter <= 2; quarter++) { /* quarters of a turn have no error at all */
        double cosine, sine;
        shim_cis(0.25 * quarter, &cosine, &sine);
        assert_true(cosine == (quarter == 0 ? 1 : abs(quarter) == 2 ? -1 : 0));
        assert_true(sine == (abs(quarter) == 1 ? quarter : 0));
    }
}

static void reduction_is_exact(void **state) {
    (void)state;
    uint64_t random = 2;
    for (int i = 0; i < 10000; i++) {
        const double x = 1e6 * number(&random), reduced = shim_reduce(x);
        assert_true(fabs(reduced) <= 0.5 && x - reduced == rint(x));
    }
}

static void black_bodies_shine(void **state) {
    (void)state;
    for (double nm = 400; nm < 900; nm += 37)
        for (double kelvin = 500; kelvin < 30000; kelvin *= 1.9) {
            const long double um = nm * 1e-9 * 1e6;
            const long double x = 6.62607015e-34L * 299792458.0L / (nm * 1e-9 * 1.380649e-23L * kelvin);
            assert_close(shim_blackbody(nm * 1e-9, kelvin), (double)(1 / (um * um * um * um * expm1l(x))), 2e-14, 0);
        }
    assert_close(shim_blackbody(1e-9, 100), 0, 0, 0);
}

enum { N = 9 };

static void fields_have_the_phase(void **state) {
    (void)state;
    double amplitude[N * N], opd[N * N], tilt_x[N], tilt_y[N], re[N * N], im[N * N], again_re[N * N], again_im[N * N];
    uint64_t random = 3;
    for (int i = 0; i < N * N; i++) {
        amplitude[i] = fabs(number(&random));
        opd[i] = 1e-6 * number(&random);
    }
    for (int i = 0; i < N; i++) {
        tilt_x[i] = 0.5 * number(&random);
        tilt_y[i] = 0.5 * number(&random);
    }
    shim_pupil_field(amplitude, opd, N, 2e6, tilt_x, tilt_y, re, im);
    memcpy(again_re, re, sizeof re);
    memcpy(again_im, im, sizeof im);
    shim_tilt_derivative(again_re, again_im, N, 0.03, -0.07);
    for (int y = 0; y < N; y++)
        for (int x = 0; x < N; x++) {
            const int i = y * N + x;
            const long double phase = kTwoPi * (opd[i] * 2e6L + tilt_x[x] + tilt_y[y]);
            assert_close(re[i], (double)(amplitude[i] * cosl(phase)), 0, 5e-15);
            assert_close(im[i], (double)(amplitude[i] * sinl(phase)), 0, 5e-15);
            const double slope = 0.03 * (x - 4) - 0.07 * (y - 4);
            assert_close(again_re[i], -slope * im[i], 1e-15, 1e-17);
            assert_close(again_im[i], slope * re[i], 1e-15, 1e-17);
        }
}

/* Intensities of f(s) = f + s f' + s^2/2 f'' along the axis, differentiated as polynomials. */
static void intensities_have_derivatives(void **state) {
    (void)state;
    enum { COUNT = 33 };
    double planes[8 * COUNT], intensity[COUNT], derivative[COUNT], curvature[COUNT];
    uint64_t random = 4;
    for (int i = 0; i < 8 * COUNT; i++)
        planes[i] = number(&random);
    for (int i = 0; i < COUNT; i++)
        intensity[i] = derivative[i] = curvature[i] = i; /* they add to what is there */
    shim_images(planes, COUNT, 1.5, 0.6, -0.8, intensity, derivative, curvature);
    for (int i = 0; i < COUNT; i++) {
        const double *const p = planes + i;
        const double complex f = p[0] + I * p[COUNT], fx = p[2 * COUNT] + I * p[3 * COUNT],
                             fy = p[4 * COUNT] + I * p[5 * COUNT], d2f = p[6 * COUNT] + I * p[7 * COUNT],
                             df = 0.6 * fx - 0.8 * fy;
        assert_close(intensity[i], i + 1.5 * creal(f * conj(f)), 1e-14, 1e-14);
        assert_close(derivative[i], i + 1.5 * creal(f * conj(fx) + fx * conj(f)), 1e-14, 1e-14);
        assert_close(curvature[i], i + 1.5 * creal(f * conj(d2f) + 2 * df * conj(df) + d2f * conj(f)), 1e-14, 1e-14);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cis_is_exact_to_rounding),     cmocka_unit_test(reduction_is_exact),
        cmocka_unit_test(black_bodies_shine),           cmocka_unit_test(fields_have_the_phase),
        cmocka_unit_test(intensities_have_derivatives),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
