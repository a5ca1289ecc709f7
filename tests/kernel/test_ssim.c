/* Tests the structural similarity against its definition: two-dimensional window, central moments, long double. */
#include "assert_close.h"

double shim_ssim(const double *a, const double *b, size_t rows, size_t cols);

enum { kRows = 23, kCols = 31, kWindow = 11 };

static long double at_window(const double *a, const double *b, int row, int col) {
    long double weights[kWindow][kWindow], sum = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    for (int i = 0; i < kWindow; i++)
        for (int j = 0; j < kWindow; j++)
            sum += weights[i][j] = expl(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5L * 1.5L));
    for (int i = 0; i < kWindow; i++)
        for (int j = 0; j < kWindow; j++) {
            weights[i][j] /= sum;
            x += weights[i][j] * a[(row + i) * kCols + col + j];
            y += weights[i][j] * b[(row + i) * kCols + col + j];
        }
    for (int i = 0; i < kWindow; i++)
        for (int j = 0; j < kWindow; j++) {
            const long double u = a[(row + i) * kCols + col + j] - x, v = b[(row + i) * kCols + col + j] - y;
            xx += weights[i][j] * u * u;
            yy += weights[i][j] * v * v;
            xy += weights[i][j] * u * v;
        }
    return (2 * x * y + 1e-4L) * (2 * xy + 9e-4L) / ((x * x + y * y + 1e-4L) * (xx + yy + 9e-4L));
}

static void fill(double *a, double *b, double difference) {
    for (int i = 0; i < kRows * kCols; i++) {
        a[i] = 0.5 + 0.5 * sin(0.7 * i) * cos(0.01 * i * i);
        b[i] = a[i] + difference * cos(3.1 * i);
    }
}

static void test_follows_the_definition(void **unused) {
    static double a[kRows * kCols], b[kRows * kCols];
    const double differences[] = {0.5, 1e-2, 1e-5};
    for (int k = 0; k < 3; k++) {
        long double sum = 0;
        fill(a, b, differences[k]);
        for (int row = 0; row + kWindow <= kRows; row++)
            for (int col = 0; col + kWindow <= kCols; col++)
                sum += at_window(a, b, row, col);
        assert_close(shim_ssim(a, b, kRows, kCols), (double)(sum / ((kRows - kWindow + 1) * (kCols - kWindow + 1))), 0,
                     1e-13);
    }
}

static void test_equal_images_give_one(void **unused) {
    static double a[kRows * kCols], b[kRows * kCols];
    fill(a, b, 0);
    assert_close(shim_ssim(a, b, kRows, kCols), 1, 0, 1e-15);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_follows_the_definition),
        cmocka_unit_test(test_equal_images_give_one),
    };
    return cmocka_run_group_tests_name("ssim", tests, NULL, NULL);
}
