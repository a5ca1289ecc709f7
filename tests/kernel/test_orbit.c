/* Tests the orbit of alpha Centauri against its published ephemeris, and the positions of the stars over time. */
#include <stdio.h>

#include "scene_text.h"

void shim_alpha_cen(double date, double *separation_arcsec, double *position_angle_deg);
void shim_offsets(const char *json, double days, double *offsets_px);

/* The ephemeris of the mission, to the last printed digit. */
static void ephemeris_of_the_mission(void **state) {
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
static void extremes_of_the_separation(void **state) {
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

static char *dated(const char *date, const char *centre) {
    char binary[200];
    snprintf(binary, sizeof binary, "{\"date\": %s, \"orbit\": \"alpha-cen\", \"centre\": \"%s\"}", date, centre);
    return replaced(kBinaryScene, "{\"separation_arcsec\": 4, \"position_angle_deg\": 30}", binary);
}

/* A time after one date is a later date, both forwards and backwards, for every centre. */
static void positions_at_a_time(void **state) {
    for (const char *const *centre = (const char *const[]){"barycentre", "A", "B", NULL}; *centre != NULL; centre++) {
        char *const early = dated("2026.25", *centre), *const late = dated("2029.5", *centre);
        double now[4], then[4], start[4];
        shim_offsets(early, 0, start);
        shim_offsets(early, 3.25 * 365.25, now);
        shim_offsets(late, 0, then);
        for (int i = 0; i < 4; i++)
            assert_close(now[i], then[i], 0, 1e-11);
        assert_true(hypot(start[2] - now[2], start[3] - now[3]) + hypot(start[0] - now[0], start[1] - now[1]) > 1);
        shim_offsets(late, -3.25 * 365.25, then);
        for (int i = 0; i < 4; i++)
            assert_close(start[i], then[i], 0, 1e-11);
        free(early);
        free(late);
    }
}

/* The positions at time 0 follow from separation and angle, and are constant without an orbit. */
static void positions_without_an_orbit(void **state) {
    double separation, angle, by_angle[4], by_date[4], later[4];
    char binary[200];
    shim_alpha_cen(2027.0, &separation, &angle);
    snprintf(binary, sizeof binary, "{\"separation_arcsec\": %.17g, \"position_angle_deg\": %.17g}", separation, angle);
    char *const placed = replaced(kBinaryScene, "{\"separation_arcsec\": 4, \"position_angle_deg\": 30}", binary);
    char *const orbiting = dated("2027.0", "barycentre");
    shim_offsets(placed, 0, by_angle);
    shim_offsets(placed, 4000, later);
    shim_offsets(orbiting, 0, by_date);
    for (int i = 0; i < 4; i++) {
        assert_close(by_date[i], by_angle[i], 0, 1e-12);
        assert_close(later[i], by_angle[i], 0, 0);
    }
    free(placed);
    free(orbiting);
    const double given[4] = {-8, 0.5, 11, 2};
    char *const fixed = replaced(kBinaryScene, "{\"separation_arcsec\": 4, \"position_angle_deg\": 30}",
                                 "{\"offsets_px\": {\"A\": [-8, 0.5], \"B\": [11, 2]}}");
    shim_offsets(fixed, 1000, later);
    for (int i = 0; i < 4; i++)
        assert_close(later[i], given[i], 0, 0);
    free(fixed);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ephemeris_of_the_mission),
        cmocka_unit_test(extremes_of_the_separation),
        cmocka_unit_test(positions_at_a_time),
        cmocka_unit_test(positions_without_an_orbit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
