/* Tests the orbit of alpha Centauri against its published ephemeris. */
#include "assert_close.h"

void shim_alpha_cen(double date, double *separation_arcsec, double *position_angle_deg);

/* The ephemeris of the mission, to the last printed digit. */
TEST(ephemeris_of_the_mission) {
    const struct {
        double date, separation, angle;
    } cases[] = {{2026.0, 9.29, 12.1}, {2027.0, 9.76, 14.5}, {2028.0, 10.12, 16.7}, {2029.5, 10.36, 19.9}};
    for (int i = 0; i < 4; i++) {
        double separation, angle;
        shim_alpha_cen(cases[i].date, &separation, &angle);
        print_message("%.1f: %.4f arcsec at %.3f deg\n", cases[i].date, separation, angle);
        assert_close(separation, cases[i].separation, 0, 0.005);
        assert_close(angle, cases[i].angle, 0, 0.05);
    }
}

/* Predictions by Sky & Telescope (2005) from the orbit of Pourbaix: 10.0 arcsec in October 2005, a minimum of 4.0 in
 * late 2015, a maximum of 10.4 in mid-2029, a minimum of 1.7 in November 2037. */
TEST(extremes_of_the_separation) {
    double first, middle, last, angle, found[3];
    int count = 0;
    shim_alpha_cen(2005.8, &first, &angle);
    assert_close(first, 10.0, 0, 0.1);
    for (double date = 2005.8; date < 2045; date += 0.01) {
        shim_alpha_cen(date - 0.01, &first, &angle);
        shim_alpha_cen(date, &middle, &angle);
        shim_alpha_cen(date + 0.01, &last, &angle);
        if ((middle - first) * (last - middle) > 0)
            continue;
        const double foretold[3][2] = {{2015.85, 4.0}, {2029.5, 10.4}, {2037.87, 1.7}};
        if (count < 3) {
            assert_close(date, foretold[count][0], 0, 0.25);
            assert_close(middle, foretold[count][1], 0, 0.1);
            found[count] = date;
        }
        count++;
    }
    print_message("extremes at %.2f, %.2f, %.2f\n", found[0], found[1], found[2]);
    assert_int_equal(count, 3);
}

RUN_TESTS(NULL, NULL)
