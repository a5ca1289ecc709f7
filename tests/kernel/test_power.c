/* Tests the power from fixed-point sums against 113-bit arithmetic on the same sums, and with nuisance functions
 * against least squares on the samples, with every instruction set. */
#include "quad_math.h"
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
size_t shim_power(int isa, int double_limb, const int64_t *const *lo, const int64_t *const *hi, size_t n, double weight,
                  int64_t samples, double mean_high, double mean_low, double spread, int fixed_mean, double *power);
int shim_any_reaches(int isa, const double *values, size_t n, double limit);
void shim_add_row(double f0, double df, size_t blocks, const double *sample, size_t functions, const double *values,
                  int64_t *lo);
size_t shim_power_rows(int isa, const int64_t *const *lo, const int64_t *const *hi, size_t n, int64_t samples,
                       const double *sums, size_t functions, const double *factor, const double *y, double *power);

enum {
    N = 203,
    C1 = 0,
    S1,
    C2,
    S2,
    YC,
    YS,
    YCLOW,
    YSLOW,
    NARROW_SUMS,
    C1LOW = NARROW_SUMS,
    S1LOW,
    C2LOW,
    S2LOW,
    YCLOWEST,
    YSLOWEST,
    SUMS
};

static int64_t lo[SUMS][N], hi[SUMS][N];

static uint64_t state = 5;

/* Splits x, in units of a limb, into a carry-save pair whose low part is not folded. */
static void put(int sum, int k, quad x) {
    const quad upper = floorq(x / QUAD(0x1p32)) + (int64_t)(uniform_signed(&state) * 1000);
    hi[sum][k] = (int64_t)upper;
    lo[sum][k] = (int64_t)(x - upper * QUAD(0x1p32));
}

static quad get(int sum, int k) {
    return (quad)hi[sum][k] * QUAD(0x1p32) + (quad)lo[sum][k];
}

/* The sum of a cosine including its lower limb, which single-limb accumulators do not have. */
static quad whole(int sum, int low, int k, int double_limb) {
    return get(sum, k) + (double_limb ? get(low, k) * QUAD(0x1p-50) : 0);
}

static quad exact_power(int double_limb, int k, quad weight, quad mean, double spread, int fixed_mean,
                        quad *determinant) {
    const quad unit = QUAD(0x1p-50) / weight, moving = fixed_mean ? 0 : 1;
    const quad c = whole(C1, C1LOW, k, double_limb) * unit, s = whole(S1, S1LOW, k, double_limb) * unit;
    const quad cc = QUAD(0.5) + whole(C2, C2LOW, k, double_limb) * unit / 2 - moving * c * c;
    const quad ss = QUAD(0.5) - whole(C2, C2LOW, k, double_limb) * unit / 2 - moving * s * s;
    const quad cs = whole(S2, S2LOW, k, double_limb) * unit / 2 - moving * c * s;
    const quad yc = (get(YC, k) + get(YCLOW, k) * QUAD(0x1p-50)) * unit - mean * c;
    const quad ys = (get(YS, k) + get(YSLOW, k) * QUAD(0x1p-50)) * unit - mean * s;
    *determinant = cc * ss - cs * cs;
    return (yc * yc * ss - 2 * yc * ys * cs + ys * ys * cc) / *determinant / (quad)spread;
}

/* Sums as real samples produce: weights of `samples`, values scattering by `sigma` about `mean`. */
static void check_kind(int double_limb, double samples, double mean, double sigma) {
    const int64_t *low[SUMS], *high[SUMS];
    for (int s = 0; s < SUMS; s++)
        low[s] = lo[s], high[s] = hi[s];
    const quad weight = (quad)samples * QUAD(0.875), one = QUAD(0x1p50) * weight;
    const quad exact_mean = (quad)mean * (1 + QUAD(0x1p-60));
    for (int k = 0; k < N; k++) {
        /* Every seventh frequency: cosine and sine hardly vary, which needs more than double precision. */
        const double flat = k % 7 == 3 ? 0.999 : 0.3 * uniform_signed(&state),
                     even = k % 7 == 5 ? 0.8 : 0.2 * uniform_signed(&state);
        put(C1, k, one * flat);
        put(S1, k, one * 0.2 * uniform_signed(&state));
        put(C2, k, one * (k % 7 == 3 ? 0.998 : even));
        put(S2, k, one * 0.2 * uniform_signed(&state));
        for (int limb = C1LOW; limb <= S2LOW; limb++)
            put(limb, k, rintq((quad)samples * QUAD(0x1p49) * uniform_signed(&state)));
        for (int part = 0; part < 2; part++) {
            const quad x = exact_mean * whole(part ? S1 : C1, part ? S1LOW : C1LOW, k, double_limb) +
                           one * sigma * 0.3 * uniform_signed(&state);
            const quad whole = rintq(x);
            put(part ? YS : YC, k, whole);
            put(part ? YSLOW : YCLOW, k, rintq((x - whole) * QUAD(0x1p50)));
        }
    }
    const double spread = sigma * sigma;
    for (int fixed_mean = 0; fixed_mean < 2; fixed_mean++) {
        double first[N], power[N];
        size_t reported = 0;
        for (int isa = 0; isa < shim_isas(); isa++) {
            reported = shim_power(isa, double_limb, low, high, N, (double)weight, (int64_t)samples, (double)exact_mean,
                                  (double)(exact_mean - (quad)(double)exact_mean), spread, fixed_mean, power);
            if (isa == 0)
                memcpy(first, power, sizeof first);
            assert_memory_equal(first, power, sizeof first);
        }
        int left_out = 0;
        for (int k = 0; k < N; k++) {
            quad determinant;
            const quad expected = exact_power(double_limb, k, weight, exact_mean, spread, fixed_mean, &determinant);
            if (first[k] == -1) {
                left_out++;
                assert_true(determinant < QUAD(0.0501));
            } else {
                assert_true(determinant > QUAD(0.0499));
                assert_close(first[k], (double)(expected > 1 ? 1 : expected < 0 ? 0 : expected), 0, 1e-13);
            }
        }
        assert_int_equal(left_out, reported);
        assert_true(left_out >= (fixed_mean ? 0 : N / 7) && left_out < N / 2);
    }
}

static void check(double samples, double mean, double sigma) {
    check_kind(0, samples, mean, sigma);
    check_kind(1, samples, mean, sigma);
}

TEST(test_latents) {
    check(1095, 0, 1e-3);
    check(1095, 7.9e-3, 1e-3);
    check(5, 0.1, 0.2);
    check(1e6, 3e-4, 1e-2);
}

TEST(test_many_samples) {
    check(0x1p31, 0.4, 0.2);
}

TEST(test_mean_far_off) {
    check(300, 0.9, 3e-5);
    check(1e6, -0.7, 3e-5);
    check(0x1p31, 0.3, 1e-5);
    check(1e6, 0.1, 0.01);
}

TEST(test_values_far_below_their_bound) {
    check(200, 1e-16, 1e-15);
    check(200, 1e-12, 1e-15);
    check(0x1p22, 1e-12, 1e-13);
    check(0x1p22, -3e-12, 1e-16);
    check(1e6, 1e-12, 1e-12);
}

TEST(test_any_reaches) {
    enum { MOST = 37 };
    for (int isa = 0; isa < shim_isas(); isa++)
        for (size_t n = 0; n <= MOST; n++) {
            double values[MOST] = {0};
            assert_false(shim_any_reaches(isa, values, n, 0x1p-1074));
            for (size_t k = 0; k < n; k++) {
                values[k] = 0.25;
                assert_true(shim_any_reaches(isa, values, n, 0.25));
                assert_false(shim_any_reaches(isa, values, n, 0.25 + 0x1p-54));
                values[k] = 0;
            }
        }
}

/* Nuisance functions; y is the first of the values, in place of the mean. */
enum { ROW_SAMPLES = 60, FUNCTIONS = 4, BLOCKS = 3, WIDTH = 64 * BLOCKS, FREQUENCIES = 175 };
enum { ROW_SUMS = 14 + 4 * (FUNCTIONS - 1) };
static const double f0 = 1e-3, df = 3.7e-3;
static double row_samples[ROW_SAMPLES][2], values[ROW_SAMPLES][FUNCTIONS];
static int64_t row_lo[ROW_SUMS][WIDTH], row_hi[ROW_SUMS][WIDTH];
static quad factor[FUNCTIONS][FUNCTIONS], of_y[FUNCTIONS], row_weight, row_spread;

static quad function(int i, int f) {
    return f == 0 ? 1 : values[i][f];
}

/* L^-1 (sum w b x)/W. */
static void forward(const quad *x, quad *out) {
    for (int f = 0; f < FUNCTIONS; f++) {
        out[f] = 0;
        for (int i = 0; i < ROW_SAMPLES; i++)
            out[f] += row_samples[i][1] * function(i, f) * x[i] / row_weight;
        for (int j = 0; j < f; j++)
            out[f] -= factor[f][j] * out[j];
        out[f] /= factor[f][f];
    }
}

static quad moment(const quad *a, const quad *b, const quad *of_a, const quad *of_b) {
    quad sum = 0;
    for (int i = 0; i < ROW_SAMPLES; i++)
        sum += row_samples[i][1] * a[i] * b[i] / row_weight;
    for (int f = 0; f < FUNCTIONS; f++)
        sum -= of_a[f] * of_b[f];
    return sum;
}

static void prepare(void) {
    uint64_t seed = 3;
    quad y[ROW_SAMPLES];
    row_weight = 0;
    for (int i = 0; i < ROW_SAMPLES; i++) {
        const double x = uniform(&seed) * 2 - 1;
        row_samples[i][0] = 100 * (x + 1);
        row_samples[i][1] = 0.2 + 0.8 * uniform(&seed);
        values[i][0] = 0.01 * (uniform(&seed) - 0.5) + 0.02 * x - 0.05;
        values[i][1] = x;
        values[i][2] = 2 * x * x - 1;
        values[i][3] = cos(9 * x);
        y[i] = values[i][0];
        row_weight += row_samples[i][1];
        shim_add_row(f0, df, BLOCKS, row_samples[i], FUNCTIONS, values[i], row_lo[0]);
    }
    for (int f = 0; f < FUNCTIONS; f++) {
        quad column[ROW_SAMPLES], row[FUNCTIONS];
        for (int i = 0; i < ROW_SAMPLES; i++)
            column[i] = function(i, f);
        for (int j = f; j < FUNCTIONS; j++)
            factor[j][j] = 1; /* not used yet */
        forward(column, row);
        quad square = 0;
        for (int i = 0; i < ROW_SAMPLES; i++)
            square += row_samples[i][1] * column[i] * column[i] / row_weight;
        for (int j = 0; j < f; j++) {
            factor[f][j] = row[j];
            square -= row[j] * row[j];
        }
        factor[f][f] = sqrtq(square);
    }
    forward(y, of_y);
    row_spread = moment(y, y, of_y, of_y);
}

static quad exact_row_power(int k) {
    quad y[ROW_SAMPLES], c[ROW_SAMPLES], s[ROW_SAMPLES], of_c[FUNCTIONS], of_s[FUNCTIONS];
    for (int i = 0; i < ROW_SAMPLES; i++) {
        const quad cycles = ((quad)f0 + k * (quad)df) * row_samples[i][0];
        const quad angle = 2 * M_PIq * (cycles - rintq(cycles));
        y[i] = values[i][0];
        c[i] = cosq(angle);
        s[i] = sinq(angle);
    }
    forward(c, of_c);
    forward(s, of_s);
    const quad cc = moment(c, c, of_c, of_c), ss = moment(s, s, of_s, of_s), cs = moment(c, s, of_c, of_s);
    const quad yc = moment(y, c, of_y, of_c), ys = moment(y, s, of_y, of_s);
    return (yc * yc * ss - 2 * yc * ys * cs + ys * ys * cc) / ((cc * ss - cs * cs) * row_spread);
}

TEST(test_power_with_functions) {
    prepare();
    double plain[FUNCTIONS][FUNCTIONS], y[FUNCTIONS], sums[3] = {(double)row_weight, 0, (double)row_spread};
    const int64_t *rows[ROW_SUMS], *upper[ROW_SUMS];
    quad square = row_spread;
    for (int f = 0; f < FUNCTIONS; f++) {
        for (int j = 0; j < FUNCTIONS; j++)
            plain[f][j] = (double)factor[f][j];
        y[f] = (double)of_y[f];
        square += of_y[f] * of_y[f];
    }
    sums[1] = (double)sqrtq(square);
    double power[3][FREQUENCIES];
    for (int split = 0; split < 2; split++) { /* a sum is divided between the words in any way */
        for (int i = 0; i < ROW_SUMS; i++) {
            rows[i] = row_lo[i];
            upper[i] = row_hi[i];
            for (int k = 0; k < WIDTH && split == 1; k++) {
                row_hi[i][k] += row_lo[i][k] >> 32;
                row_lo[i][k] &= 0xffffffff;
            }
        }
        for (int isa = 0; isa < shim_isas(); isa++) {
            const size_t left =
                shim_power_rows(isa, rows, upper, FREQUENCIES, ROW_SAMPLES, sums, FUNCTIONS, plain[0], y, power[isa]);
            assert_in_range(left, 1, 5); /* the lowest frequencies, close to the polynomials */
            assert_memory_equal(power[isa], power[0], sizeof power[0]);
        }
        double worst = 0;
        for (int k = 0; k < FREQUENCIES; k++)
            if (power[0][k] != -1)
                worst = fmax(worst, fabs((double)(power[0][k] - exact_row_power(k))));
        assert_at_most(worst, 2e-14);
        assert_true(power[0][0] == -1);
    }
}

RUN_TESTS(NULL, NULL)
