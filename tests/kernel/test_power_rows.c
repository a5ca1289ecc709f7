/* Tests the power with nuisance functions against least squares on the samples in 113 bits, with every instruction set.
 */
#include <quadmath.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
void shim_add_row(double f0, double df, size_t blocks, const double *sample, size_t functions, const double *values,
                  int64_t *lo);
size_t shim_power_rows(int isa, const int64_t *const *lo, const int64_t *const *hi, size_t n, int64_t samples,
                       const double *sums, size_t functions, const double *factor, const double *y, double *power);

enum { SAMPLES = 60, FUNCTIONS = 4, BLOCKS = 3, WIDTH = 64 * BLOCKS, FREQUENCIES = 175 };
enum { SUMS = 14 + 4 * (FUNCTIONS - 1) };
static const double f0 = 1e-3, df = 3.7e-3;
static double samples[SAMPLES][2], values[SAMPLES][FUNCTIONS]; /* y in place of the mean */
static int64_t lo[SUMS][WIDTH], hi[SUMS][WIDTH];
static __float128 factor[FUNCTIONS][FUNCTIONS], of_y[FUNCTIONS], weight, spread;

static __float128 function(int i, int f) {
    return f == 0 ? 1 : values[i][f];
}

/* L^-1 (sum w b x)/W. */
static void forward(const __float128 *x, __float128 *out) {
    for (int f = 0; f < FUNCTIONS; f++) {
        out[f] = 0;
        for (int i = 0; i < SAMPLES; i++)
            out[f] += samples[i][1] * function(i, f) * x[i] / weight;
        for (int j = 0; j < f; j++)
            out[f] -= factor[f][j] * out[j];
        out[f] /= factor[f][f];
    }
}

static __float128 moment(const __float128 *a, const __float128 *b, const __float128 *of_a, const __float128 *of_b) {
    __float128 sum = 0;
    for (int i = 0; i < SAMPLES; i++)
        sum += samples[i][1] * a[i] * b[i] / weight;
    for (int f = 0; f < FUNCTIONS; f++)
        sum -= of_a[f] * of_b[f];
    return sum;
}

static void prepare(void) {
    uint64_t state = 3;
    __float128 y[SAMPLES];
    weight = 0;
    for (int i = 0; i < SAMPLES; i++) {
        const double x = uniform(&state) * 2 - 1;
        samples[i][0] = 100 * (x + 1);
        samples[i][1] = 0.2 + 0.8 * uniform(&state);
        values[i][0] = 0.01 * (uniform(&state) - 0.5) + 0.02 * x - 0.05;
        values[i][1] = x;
        values[i][2] = 2 * x * x - 1;
        values[i][3] = cos(9 * x);
        y[i] = values[i][0];
        weight += samples[i][1];
        shim_add_row(f0, df, BLOCKS, samples[i], FUNCTIONS, values[i], lo[0]);
    }
    for (int f = 0; f < FUNCTIONS; f++) {
        __float128 column[SAMPLES], row[FUNCTIONS];
        for (int i = 0; i < SAMPLES; i++)
            column[i] = function(i, f);
        for (int j = f; j < FUNCTIONS; j++)
            factor[j][j] = 1; /* not used yet */
        forward(column, row);
        __float128 square = 0;
        for (int i = 0; i < SAMPLES; i++)
            square += samples[i][1] * column[i] * column[i] / weight;
        for (int j = 0; j < f; j++) {
            factor[f][j] = row[j];
            square -= row[j] * row[j];
        }
        factor[f][f] = sqrtq(square);
    }
    forward(y, of_y);
    spread = moment(y, y, of_y, of_y);
}

static __float128 exact_power(int k) {
    __float128 y[SAMPLES], c[SAMPLES], s[SAMPLES], of_c[FUNCTIONS], of_s[FUNCTIONS];
    for (int i = 0; i < SAMPLES; i++) {
        const __float128 cycles = ((__float128)f0 + k * (__float128)df) * samples[i][0];
        const __float128 angle = 2 * M_PIq * (cycles - rintq(cycles));
        y[i] = values[i][0];
        c[i] = cosq(angle);
        s[i] = sinq(angle);
    }
    forward(c, of_c);
    forward(s, of_s);
    const __float128 cc = moment(c, c, of_c, of_c), ss = moment(s, s, of_s, of_s), cs = moment(c, s, of_c, of_s);
    const __float128 yc = moment(y, c, of_y, of_c), ys = moment(y, s, of_y, of_s);
    return (yc * yc * ss - 2 * yc * ys * cs + ys * ys * cc) / ((cc * ss - cs * cs) * spread);
}

static void powers_match_113_bits(void **unused) {
    prepare();
    double plain[FUNCTIONS][FUNCTIONS], y[FUNCTIONS], sums[3] = {(double)weight, 0, (double)spread};
    const int64_t *rows[SUMS], *upper[SUMS];
    __float128 square = spread;
    for (int f = 0; f < FUNCTIONS; f++) {
        for (int j = 0; j < FUNCTIONS; j++)
            plain[f][j] = (double)factor[f][j];
        y[f] = (double)of_y[f];
        square += of_y[f] * of_y[f];
    }
    sums[1] = (double)sqrtq(square);
    double power[3][FREQUENCIES];
    for (int split = 0; split < 2; split++) { /* a sum is divided between the words in any way */
        for (int i = 0; i < SUMS; i++) {
            rows[i] = lo[i];
            upper[i] = hi[i];
            for (int k = 0; k < WIDTH && split == 1; k++) {
                hi[i][k] += lo[i][k] >> 32;
                lo[i][k] &= 0xffffffff;
            }
        }
        for (int isa = 0; isa < shim_isas(); isa++) {
            const size_t left =
                shim_power_rows(isa, rows, upper, FREQUENCIES, SAMPLES, sums, FUNCTIONS, plain[0], y, power[isa]);
            assert_in_range(left, 1, 5); /* the lowest frequencies, close to the polynomials */
            assert_memory_equal(power[isa], power[0], sizeof power[0]);
        }
        double worst = 0;
        for (int k = 0; k < FREQUENCIES; k++)
            if (power[0][k] != -1)
                worst = fmax(worst, fabs((double)(power[0][k] - exact_power(k))));
        assert_at_most(worst, 2e-14);
        assert_true(power[0][0] == -1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(powers_match_113_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
