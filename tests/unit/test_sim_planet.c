/* Tests a planet as the signal: the reflex motion of its star, the equivalent sinusoid of a circular orbit, and no
 * signal at all. */
#include <stdio.h>

#include "scene_text.h"

static const char *const kSinusoid = "{'kind': 'sinusoid', 'star': 'B', 'amplitude_px': 1e-3, 'period_days': 40}";

/* The binary scene at 0.375 arcsec/px and 1.33 pc, with the masses of alpha Centauri. */
static toliman_sim *sim_with_signal(const char *signal) {
    char *text = EDITED(kBinaryScene, {"'relative_flux': 3}", "'relative_flux': 3, 'mass_sun': 1.0788}"},
                        {"5260}}", "5260}, 'mass_sun': 0.9092}"},
                        {"'position_angle_deg': 30", "'position_angle_deg': 30, 'distance_pc': 1.33"},
                        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.375"}, {kSinusoid, signal});
    toliman_sim *const sim = sim_of(text);
    free(text);
    return sim;
}

/* An Earth in the habitable zone of either star. The published axes are rounded to 0.01 au (0.4 % and 0.7 %), and so
 * are the amplitudes; 0.705 au reproduces B's. */
TEST(earths_of_alpha_centauri) {
    const struct {
        const char *star, *axis;
        double years, uas, px;
    } cases[] = {{"A", "1.23", 1.31, 2.57, 6.86e-6}, {"B", "0.705", 0.62, 1.75, 4.67e-6}};
    for (int i = 0; i < 2; i++) {
        char signal[200];
        snprintf(signal, sizeof signal, "{'kind': 'planet', 'star': '%s', 'mass_earth': 1, 'semi_major_au': %s}",
                 cases[i].star, cases[i].axis);
        toliman_sim *const sim = sim_with_signal(signal);
        const toliman_sim_info info = sim_info_of(sim);
        assert_close(info.period_days / 365.25, cases[i].years, 0, 0.005);
        assert_close(info.amplitude_uas, cases[i].uas, 0, 0.005);
        assert_close(info.amplitude_px, cases[i].px, 0, 0.01e-6);
        assert_close(info.amplitude_px, info.amplitude_uas / 0.375e6, 1e-14, 0);
        /* Solar units: a year and an au for a Sun; the Earth has 3.00349e-6 of its mass. */
        const double mass = i == 0 ? 1.0788 : 0.9092, earth = 3.00349e-6, axis = atof(cases[i].axis);
        assert_close(info.period_days, 365.25690 * sqrt(axis * axis * axis / (mass + earth)), 1e-8, 0);
        assert_close(info.amplitude_uas, 1e6 * earth / (mass + earth) * axis / 1.33, 1e-6, 0);
        toliman_sim_destroy(sim);
    }
}

/* On a circular orbit phase and argument of periastron add up to the sinusoid's phase; everything else is equal. */
TEST(a_circular_orbit_is_a_sinusoid) {
    char sinusoid[300];
    toliman_sim *const circular =
        sim_with_signal("{'kind': 'planet', 'star': 'B', 'mass_earth': 300, 'semi_major_au': 0.3, 'phase_rad': 0.7}");
    toliman_sim *const shifted =
        sim_with_signal("{'kind': 'planet', 'star': 'B', 'mass_earth': 300, 'semi_major_au': 0.3,"
                        " 'eccentricity': 0, 'argument_deg': 90, 'phase_rad': 0.7}");
    const toliman_sim_info info = sim_info_of(circular);
    snprintf(sinusoid, sizeof sinusoid,
             "{'kind': 'sinusoid', 'star': 'B', 'amplitude_px': %.17g, 'period_days': %.17g,"
             " 'phase_rad': 0.7}",
             info.amplitude_px, info.period_days);
    toliman_sim *const same = sim_with_signal(sinusoid);
    double times[100], of_planet[100], of_shifted[100], of_sinusoid[100];
    assert_ok(toliman_sim_get_series(circular, 0, 100, times, of_planet));
    assert_ok(toliman_sim_get_series(shifted, 0, 100, NULL, of_shifted));
    assert_ok(toliman_sim_get_series(same, 0, 100, NULL, of_sinusoid));
    for (int i = 0; i < 100; i++) {
        assert_close(of_planet[i], of_sinusoid[i], 0, 0);
        const double mean = 2 * M_PI * times[i] / info.period_days + 0.7;
        assert_close(of_planet[i], info.amplitude_px * sin(mean), 0, 1e-14 * info.amplitude_px);
        assert_close(of_shifted[i], info.amplitude_px * cos(mean), 0, 1e-14 * info.amplitude_px);
    }
    assert_close(sim_info_of(same).amplitude_uas, info.amplitude_uas, 1e-14, 0);
    toliman_sim_destroy(circular), toliman_sim_destroy(shifted), toliman_sim_destroy(same);
}

/* For small eccentricities the orbit converges to the circle. */
TEST(eccentricity_is_continuous) {
    const char *const form = "{'kind': 'planet', 'mass_earth': 300, 'semi_major_au': 0.3, 'eccentricity': %s,"
                             " 'argument_deg': 40, 'phase_rad': -2}";
    double circle[100], ellipse[100];
    for (int i = 0; i < 2; i++) {
        char signal[200];
        snprintf(signal, sizeof signal, form, i == 0 ? "0" : "1e-13");
        toliman_sim *const sim = sim_with_signal(signal);
        assert_ok(toliman_sim_get_series(sim, 0, 100, NULL, i == 0 ? circle : ellipse));
        toliman_sim_destroy(sim);
    }
    for (int i = 0; i < 100; i++)
        assert_close(ellipse[i], circle[i], 0, 1e-12 * 1e-3);
}

/* kind none: the same as no signal at all. */
TEST(no_signal) {
    toliman_sim *const sim = sim_with_signal("{'kind': 'none'}");
    const toliman_sim_info info = sim_info_of(sim);
    assert_close(info.amplitude_px + info.amplitude_uas + info.period_days, 0, 0, 0);
    assert_close(info.min_displacement_px, 0, 0, 0);
    assert_close(info.max_displacement_px, 0, 0, 0);
    toliman_sim_destroy(sim);
}

/* A single star may have a planet too; it moves along x. */
TEST(a_single_star_has_a_planet) {
    char *text = EDITED(kSingleScene, {"5790}}", "5790}, 'mass_sun': 1}"},
                        {"{'A': [0, 0]}}", "{'A': [0, 0]}, 'distance_pc': 2},"
                                           " 'signal': {'kind': 'planet', 'mass_earth': 1, 'semi_major_au': 1}"});
    toliman_sim *const sim = sim_of(text);
    assert_close(sim_info_of(sim).amplitude_uas, 3.00349 / 2, 1e-5, 0);
    assert_close(sim_info_of(sim).period_days, 365.2563, 1e-6, 0);
    toliman_sim_destroy(sim), free(text);
}

/* A caller whose struct ends before amplitude_uas. */
RUN_TESTS(NULL, NULL)
