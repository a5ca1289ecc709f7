/* Tests phases, pupil fields, folded transforms and products of fields against their defining sums in long double, with
 * every instruction set of the machine. */
#include "quad_math.h"
#include <complex.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
void shim_cis(double cycles, double *cosine, double *sine);
double shim_reduce(double x);
double shim_blackbody(double wavelength_m, double temperature_k);
void shim_operand(int isa, size_t samples, size_t pixels, long double step, double *cosine, double *sine);
void shim_transform(int isa, const double *amplitude, const double *opd_m, size_t n, double wavenumber,
                    const double *tilt_x, const double *tilt_y, double slope_x, double slope_y, const double *mode,
                    double mode_scale, size_t rows, size_t cols, long double step, double weight, double *images);

TEST(cis_is_exact_to_rounding) {
    const double corners[] = {0, 0.125, -0.125, 0.25, -0.25, 0.375, -0.375, 0.5, -0.5, 1e-300};
    double worst = 0;
    uint64_t random = 1;
    for (int i = 0; i < 200000; i++) {
        const double cycles = i < 10 ? corners[i] : 0.5 * uniform_signed(&random);
        double cosine, sine;
        shim_cis(cycles, &cosine, &sine);
        worst = fmax(worst, (double)fabsl(cosine - cosl(2 * M_PIl * cycles)));
        worst = fmax(worst, (double)fabsl(sine - sinl(2 * M_PIl * cycles)));
    }
    assert_at_most(worst, 2e-16);
    for (int quarter = -2; quarter <= 2; quarter++) { /* quarter cycles are exact */
        double cosine, sine;
        shim_cis(0.25 * quarter, &cosine, &sine);
        assert_true(cosine == (quarter == 0 ? 1 : abs(quarter) == 2 ? -1 : 0));
        assert_true(sine == (abs(quarter) == 1 ? quarter : 0));
    }
}

TEST(reduction_is_exact) {
    uint64_t random = 2;
    for (int i = 0; i < 10000; i++) {
        const double x = 1e6 * uniform_signed(&random), reduced = shim_reduce(x);
        assert_true(fabs(reduced) <= 0.5 && x - reduced == rint(x));
    }
}

TEST(black_bodies_match_planck) {
    for (double nm = 400; nm < 900; nm += 37)
        for (double kelvin = 500; kelvin < 30000; kelvin *= 1.9) {
            const long double um = nm * 1e-9 * 1e6;
            const long double x = 6.62607015e-34L * 299792458.0L / (nm * 1e-9 * 1.380649e-23L * kelvin);
            assert_close(shim_blackbody(nm * 1e-9, kelvin), (double)(1 / (um * um * um * um * expm1l(x))), 2e-14, 0);
        }
    assert_close(shim_blackbody(1e-9, 100), 0, 0, 0);
}

/* Phases of tens of thousands of cycles keep their precision. */
TEST(operands_are_exact) {
    double cosine[50 * 40], sine[50 * 40];
    const long double step = 97.123456789123456789L;
    for (int isa = 0; isa < shim_isas(); isa++) {
        shim_operand(isa, 100, 79, step, cosine, sine);
        for (int x = 0; x < 50; x++)
            for (int u = 0; u < 40; u++) {
                /* 2e5 cycles: the reference needs 113 bits, long double would lose 1e-14. */
                quad cycles = (quad)step * ((x + 0.5L) * u);
                cycles -= rintq(cycles);
                assert_close(cosine[x * 40 + u], (double)cosq(2 * M_PIq * cycles), 0, 5e-16);
                assert_close(sine[x * 40 + u], (double)sinq(2 * M_PIq * cycles), 0, 5e-16);
            }
    }
}

enum { N = 8, PIXELS = 9 };

typedef struct {
    double amplitude[N * N], opd[N * N], tilt_x[N], tilt_y[N], mode[N * N];
} pupil;

static pupil random_pupil(void) {
    pupil p;
    uint64_t random = 3;
    for (int i = 0; i < N * N; i++) {
        p.amplitude[i] = fabs(uniform_signed(&random));
        p.opd[i] = 1e-6 * uniform_signed(&random);
        p.mode[i] = uniform_signed(&random);
    }
    for (int i = 0; i < N; i++) {
        p.tilt_x[i] = 0.5 * uniform_signed(&random);
        p.tilt_y[i] = 0.5 * uniform_signed(&random);
    }
    return p;
}

/* Fields f, i (slopes) f and i mode times the latter at one pixel, by definition. */
static void fields_at(const pupil *p, int n, long double step, double u, double v, long double complex *field) {
    field[0] = field[1] = field[2] = 0;
    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++) {
            const int i = y * n + x;
            const double from_x = x - 0.5 * (n - 1), from_y = y - 0.5 * (n - 1);
            const long double phase = 2 * M_PIl *
                                      (p->opd[i] * 2e6L + p->tilt_x[x] + p->tilt_y[y] -
                                       step * (from_x * (long double)u + from_y * (long double)v));
            long double complex term = p->amplitude[i] * (cosl(phase) + I * sinl(phase));
            field[0] += term;
            term *= I * (0.3L * from_x - 0.2L * from_y);
            field[1] += term;
            field[2] += term * I * (1.5L * p->mode[i]);
        }
}

static void check(const pupil *p, int isa, int n, int rows, int cols) {
    const long double step = 0.0313L;
    double images[3 * PIXELS * PIXELS];
    const int count = rows * cols;
    for (int i = 0; i < 3 * count; i++)
        images[i] = i; /* the kernel adds to the existing values */
    shim_transform(isa, p->amplitude, p->opd, (size_t)n, 2e6, p->tilt_x, p->tilt_y, 0.3, -0.2, p->mode, 1.5,
                   (size_t)rows, (size_t)cols, step, 0.25, images);
    for (int row = 0; row < rows; row++)
        for (int col = 0; col < cols; col++) {
            long double complex field[3];
            fields_at(p, n, step, col - 0.5 * (cols - 1), row - 0.5 * (rows - 1), field);
            const int i = row * cols + col;
            assert_close(images[i], i + 0.25 * (double)creall(field[0] * conjl(field[0])), 0, 2e-13);
            assert_close(images[count + i], count + i + 0.5 * (double)creall(field[0] * conjl(field[1])), 0, 2e-13);
            assert_close(images[2 * count + i], 2 * count + i + 0.25 * (double)creall(field[1] * conjl(field[2])), 0,
                         2e-13);
        }
}

/* Closes cells at random, whole rows at the edge included, so that folded rows end at different samples. */
static pupil partly_closed(pupil p, int n) {
    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++)
            if (abs(2 * x - n + 1) + abs(2 * y - n + 1) > n || (5 * x + 3 * y) % 7 == 0)
                p.amplitude[y * n + x] = 0;
    return p;
}

/* All combinations of even and odd numbers of rows and columns. */
TEST(transforms_match_their_sums) {
    const pupil open = random_pupil();
    for (int isa = 0; isa < shim_isas(); isa++)
        for (int n = 1; n <= N; n++) {
            const pupil p = n % 3 == 0 ? open : partly_closed(open, n);
            for (int rows = 1; rows <= PIXELS; rows += 2)
                for (int cols = 1; cols <= PIXELS; cols++)
                    check(&p, isa, n, cols % 3 == 0 ? rows - rows / 2 : rows, cols);
        }
}

/* Only +, - and * are used: every instruction set gives the same bits. */
TEST(instruction_sets_agree) {
    const pupil p = random_pupil();
    double first[3 * PIXELS * PIXELS] = {0};
    shim_transform(0, p.amplitude, p.opd, N, 2e6, p.tilt_x, p.tilt_y, 0.3, -0.2, p.mode, 1.5, PIXELS, PIXELS, 0.0313L,
                   1, first);
    for (int isa = 1; isa < shim_isas(); isa++) {
        double other[3 * PIXELS * PIXELS] = {0};
        shim_transform(isa, p.amplitude, p.opd, N, 2e6, p.tilt_x, p.tilt_y, 0.3, -0.2, p.mode, 1.5, PIXELS, PIXELS,
                       0.0313L, 1, other);
        assert_memory_equal(first, other, sizeof first);
    }
}

RUN_TESTS(NULL, NULL)
