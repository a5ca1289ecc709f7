/* Tests dates along known paths: their number, the times at which equal lengths are passed, and the distance of every
 * time from its date. */
#include "assert_close.h"

enum { MOST = 500 };

size_t shim_dates(double first, double last, double spacing_px, void (*path)(double, double *), size_t capacity,
                  double *dates);
double shim_place(size_t i, size_t places);

static double dates[MOST][3];

static size_t dates_of(double first, double last, double spacing, void (*path)(double, double *)) {
    const size_t count = shim_dates(first, last, spacing, path, MOST, &dates[0][0]);
    assert_in_range(count, 1, MOST);
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

static void steady_motion_has_regular_dates(void **state) {
    const double length = 2 * acos(-1) * 30 * 0.4; /* of 400 days */
    static const double spacings[] = {0.5, 4, 100};
    for (size_t s = 0; s < 3; s++) {
        const size_t count = dates_of(-100, 300, spacings[s], circle);
        assert_int_equal(count, (size_t)ceil(length / spacings[s]));
        for (size_t i = 0; i < count; i++)
            assert_close(dates[i][0], -100 + 400 * ((double)i + 0.5) / (double)count, 0, 1e-3);
    }
}

static void accelerated_motion_has_denser_dates(void **state) {
    assert_int_equal(dates_of(0, 10, 5, parabola), 20);
    for (int i = 0; i < 20; i++) {
        assert_close(dates[i][0], sqrt(5 * (i + 0.5)), 0, 1e-5);
        assert_close(dates[i][2], sqrt(5 * (i + 1)), 0, 1e-5);
    }
}

static void every_time_is_near_its_date(void **state) {
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

static void one_date_suffices_without_motion(void **state) {
    assert_int_equal(dates_of(10, 40, 0.05, rest), 1);
    assert_close(dates[0][0], 25, 0, 1e-12);
    assert_int_equal(dates_of(70, 70, 0.05, circle), 1);
    assert_close(dates[0][0], 70, 0, 0);
    assert_int_equal(dates_of(0, 100, 10, stop), 5); /* 50 px in the first half */
    assert_close(dates[4][0], 45, 0, 0.05);
}

static void places_divide_a_pixel(void **state) {
    assert_close(shim_place(0, 1), 0, 0, 0);
    for (size_t places = 1; places <= 8; places++)
        for (size_t i = 0; i < places; i++)
            assert_close(shim_place(i, places), ((double)i - 0.5 * (double)(places - 1)) / (double)places, 0, 1e-15);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steady_motion_has_regular_dates), cmocka_unit_test(accelerated_motion_has_denser_dates),
        cmocka_unit_test(every_time_is_near_its_date), cmocka_unit_test(one_date_suffices_without_motion),
        cmocka_unit_test(places_divide_a_pixel)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
