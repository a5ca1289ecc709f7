/* Tests dates along known paths (their number, the times at which equal lengths are passed, the distance of every time
 * from its date), and the displacement of images: whole pixels are exact, polynomials are reproduced, waves have the
 * error of the interpolation's order, and the opposite displacement is the adjoint operator. */
#include "assert_close.h"
#include "uniform.h"

/* ---- grid */

enum { MOST_DATES = 500 };

size_t shim_dates(double first, double last, double spacing_px, void (*path)(double, double *), size_t capacity,
                  double *dates);
double shim_place(size_t i, size_t places);

static double dates[MOST_DATES][3];

static size_t dates_of(double first, double last, double spacing, void (*path)(double, double *)) {
    const size_t count = shim_dates(first, last, spacing, path, MOST_DATES, &dates[0][0]);
    assert_in_range(count, 1, MOST_DATES);
    assert_close(dates[0][1], first, 0, 0);
    assert_close(dates[count - 1][2], last, 0, 0);
    for (size_t i = 0; i < count; i++) {
        assert_true(dates[i][1] <= dates[i][0] && dates[i][0] <= dates[i][2]);
        if (i > 0)
            assert_close(dates[i][1], dates[i - 1][2], 0, 0); /* no gap */
    }
    return count;
}

/* Radius 30 px, one turn in 1000 days. */
static void circle(double days, double *at) {
    const double angle = 2 * acos(-1) * days / 1000;
    at[0] = 30 * cos(angle);
    at[1] = 30 * sin(angle);
}

static void parabola(double days, double *at) {
    at[0] = days * days;
    at[1] = 7;
}

static void stop(double days, double *at) {
    at[0] = 3;
    at[1] = days < 50 ? -days : -50;
}

static void rest(double days, double *at) {
    (void)days;
    at[0] = 12;
    at[1] = -5;
}

TEST(steady_motion_has_regular_dates) {
    const double length = 2 * acos(-1) * 30 * 0.4; /* of 400 days */
    static const double spacings[] = {0.5, 4, 100};
    for (size_t s = 0; s < 3; s++) {
        const size_t count = dates_of(-100, 300, spacings[s], circle);
        assert_int_equal(count, (size_t)ceil(length / spacings[s]));
        for (size_t i = 0; i < count; i++)
            assert_close(dates[i][0], -100 + 400 * ((double)i + 0.5) / (double)count, 0, 1e-3);
    }
}

TEST(accelerated_motion_has_denser_dates) {
    assert_int_equal(dates_of(0, 10, 5, parabola), 20);
    for (int i = 0; i < 20; i++) {
        assert_close(dates[i][0], sqrt(5 * (i + 0.5)), 0, 1e-5);
        assert_close(dates[i][2], sqrt(5 * (i + 1)), 0, 1e-5);
    }
}

TEST(every_time_is_near_its_date) {
    void (*const paths[])(double, double *) = {circle, parabola, stop, rest};
    for (size_t p = 0; p < 4; p++) {
        const size_t count = dates_of(1, 10, 0.6, paths[p]);
        for (size_t i = 0; i < count; i++)
            for (int part = 0; part <= 10; part++) {
                double here[2], there[2];
                paths[p](dates[i][0], there);
                paths[p](dates[i][1] + (dates[i][2] - dates[i][1]) * part / 10, here);
                assert_at_most(hypot(here[0] - there[0], here[1] - there[1]), 0.3 * (1 + 1e-3));
            }
    }
}

TEST(one_date_suffices_without_motion) {
    assert_int_equal(dates_of(10, 40, 0.05, rest), 1);
    assert_close(dates[0][0], 25, 0, 1e-12);
    assert_int_equal(dates_of(70, 70, 0.05, circle), 1);
    assert_close(dates[0][0], 70, 0, 0);
    assert_int_equal(dates_of(0, 100, 10, stop), 5); /* 50 px in the first half */
    assert_close(dates[4][0], 45, 0, 0.05);
}

TEST(places_divide_a_pixel) {
    assert_close(shim_place(0, 1), 0, 0, 0);
    for (size_t places = 1; places <= 8; places++)
        for (size_t i = 0; i < places; i++)
            assert_close(shim_place(i, places), ((double)i - 0.5 * (double)(places - 1)) / (double)places, 0, 1e-15);
}

/* ---- resample */

enum { ROWS = 37, COLS = 45, SMALL = 24, MOST = ROWS * COLS, MARGIN = 4 };

void shim_move(const double *source, size_t rows, size_t cols, double x, double y, double *result, size_t result_rows,
               size_t result_cols);

static double source[MOST], result[MOST];

static void fill(double *image, size_t count, uint64_t seed) {
    for (size_t i = 0; i < count; i++)
        image[i] = uniform_signed(&seed);
}

TEST(whole_pixels_are_exact) {
    static const int moves[][2] = {{0, 0}, {3, -5}, {-40, 2}, {44, 36}, {45, 0}, {0, -37}, {4000, 1}, {-1, -4000}};
    static const int shapes[][2] = {{ROWS, COLS}, {SMALL, SMALL}};
    fill(source, MOST, 1);
    for (size_t s = 0; s < 2; s++)
        for (size_t m = 0; m < sizeof moves / sizeof *moves; m++) {
            const int rows = shapes[s][0], cols = shapes[s][1], x = moves[m][0], y = moves[m][1];
            for (int i = 0; i < MOST; i++)
                result[i] = NAN;
            shim_move(source, ROWS, COLS, x, y, result, (size_t)rows, (size_t)cols);
            for (int r = 0; r < rows; r++)
                for (int c = 0; c < cols; c++) {
                    const int inside = r + y >= 0 && r + y < ROWS && c + x >= 0 && c + x < COLS;
                    assert_close(result[r * cols + c], inside ? source[(r + y) * COLS + c + x] : 0, 0, 0);
                }
        }
}

/* Polynomials of degree 7 in each coordinate, where all eight samples are inside. */
TEST(polynomials_are_reproduced) {
    const double x = 0.37, y = -0.81;
    for (int degree = 0; degree < 8; degree++) {
        for (int i = 0; i < MOST; i++)
            source[i] = pow((i % COLS - 20) / 20.0, degree) + pow((i / COLS - 15) / 20.0, degree);
        shim_move(source, ROWS, COLS, x, y, result, ROWS, COLS);
        for (int r = MARGIN; r < ROWS - MARGIN; r++)
            for (int c = MARGIN; c < COLS - MARGIN; c++)
                assert_close(result[r * COLS + c], pow((c + x - 20) / 20.0, degree) + pow((r + y - 15) / 20.0, degree),
                             0, 1e-13);
    }
}

/* The error of polynomials through eight samples is at most the eighth derivative times 0.5^2 1.5^2 2.5^2 3.5^2 / 8!.
 */
TEST(waves_have_the_error_of_the_order) {
    static const double frequencies[] = {0.02, 0.05, 0.1, 0.2}; /* cycles per pixel */
    for (size_t f = 0; f < 4; f++) {
        const double k = 2 * acos(-1) * frequencies[f], bound = 1.0682e-3 * pow(k, 8) + 1e-14;
        double worst = 0;
        for (int part = 0; part < 10; part++) {
            const double x = part / 10.0 - 0.5;
            for (int i = 0; i < MOST; i++)
                source[i] = sin(k * (i % COLS) + 1);
            shim_move(source, ROWS, COLS, x, 0, result, ROWS, COLS);
            for (int i = 0; i < MOST; i++)
                if (i % COLS >= MARGIN && i % COLS < COLS - MARGIN)
                    worst = fmax(worst, fabs(result[i] - sin(k * (i % COLS + x) + 1)));
        }
        assert_at_most(worst, bound);
        assert_true(worst > 0.3 * bound || frequencies[f] < 0.05);
    }
}

/* <move(a), b> = <a, move_back(b)>, at the borders as well. */
TEST(the_opposite_displacement_is_the_adjoint) {
    static const double moves[][2] = {{0.3, -0.4}, {10.75, 3.5}, {-7.01, 12.99}, {30.5, -20.5}, {2, 0.25}};
    static double a[MOST], b[MOST], moved[MOST], back[MOST];
    fill(a, MOST, 2);
    fill(b, SMALL * SMALL, 3);
    for (size_t m = 0; m < sizeof moves / sizeof *moves; m++) {
        shim_move(a, ROWS, COLS, moves[m][0], moves[m][1], moved, SMALL, SMALL);
        shim_move(b, SMALL, SMALL, -moves[m][0], -moves[m][1], back, ROWS, COLS);
        double there = 0, here = 0, size = 0;
        for (int i = 0; i < SMALL * SMALL; i++) {
            there += moved[i] * b[i];
            size += fabs(moved[i] * b[i]);
        }
        for (int i = 0; i < MOST; i++)
            here += a[i] * back[i];
        assert_true(size > 0);
        assert_close(here, there, 0, 1e-13 * size);
    }
}

RUN_TESTS(NULL, NULL)
