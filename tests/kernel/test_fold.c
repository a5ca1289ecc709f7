/* The folded transform against the sum that defines it, for every mixture of even and odd sides. */
#include <complex.h>
#include <string.h>

#include "assert_close.h"

void shim_operand(size_t samples, size_t pixels, long double step, double *cosine, double *sine);
void shim_transform(double *re, double *im, size_t n, size_t rows, size_t cols, long double step, double *out_re,
                    double *out_im);

static const long double kTwoPi = 6.28318530717958647692528676655900577L;

/* Phases of tens of thousands of cycles lose nothing. */
static void operands_are_exact(void **state) {
    (void)state;
    double cosine[50 * 40], sine[50 * 40];
    const long double step = 97.123456789123456789L;
    shim_operand(100, 79, step, cosine, sine);
    for (int x = 0; x < 50; x++)
        for (int u = 0; u < 40; u++) {
            long double cycles = (x + 0.5L) * u * step;
            cycles -= rintl(cycles);
            assert_close(cosine[x * 40 + u], (double)cosl(kTwoPi * cycles), 0, 5e-16);
            assert_close(sine[x * 40 + u], (double)sinl(kTwoPi * cycles), 0, 5e-16);
        }
}

static void check(int n, int rows, int cols) {
    double re[64], im[64], out_re[81], out_im[81];
    uint64_t random = 5;
    for (int i = 0; i < n * n; i++) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        re[i] = (double)(random >> 11) * 0x1p-53;
        im[i] = (double)(random >> 40) * 0x1p-24;
    }
    const long double step = 0.0313L;
    shim_transform(re, im, (size_t)n, (size_t)rows, (size_t)cols, step, out_re, out_im);
    for (int row = 0; row < rows; row++)
        for (int col = 0; col < cols; col++) {
            long double complex sum = 0;
            for (int y = 0; y < n; y++)
                for (int x = 0; x < n; x++) {
                    const long double phase = -kTwoPi * step *
                                              ((x - (n - 1) / 2.0L) * (col - (cols - 1) / 2.0L) +
                                               (y - (n - 1) / 2.0L) * (row - (rows - 1) / 2.0L));
                    sum += (re[y * n + x] + I * (long double)im[y * n + x]) * (cosl(phase) + I * sinl(phase));
                }
            assert_close(out_re[row * cols + col], (double)creall(sum), 0, 1e-13);
            assert_close(out_im[row * cols + col], (double)cimagl(sum), 0, 1e-13);
        }
}

static void folding_changes_nothing(void **state) {
    (void)state;
    for (int n = 1; n <= 8; n++)
        for (int rows = 1; rows <= 9; rows += 2)
            for (int cols = 1; cols <= 9; cols++)
                check(n, cols % 3 == 0 ? rows - rows / 2 : rows, cols);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(operands_are_exact),
        cmocka_unit_test(folding_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
