/* Tests stars that follow their orbit during the cadence: every frame against a static scene of its date. */
#include <stdio.h>

#include "scene_text.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE };

/* An orbit at a date, moving or static; light by exposure, no noise. */
static char *orbit_at(const char *orbit, double date, const char *moving, const char *cadence, const char *more) {
    char place[400];
    snprintf(place, sizeof place, "{'date': %.17g, 'orbit': %s%s}", date, orbit, moving);
    char *text = EDITED(
        kBinaryScene, {"'peak_photons': 1e5", "'exposure_s': 1"}, {"'relative_flux': 3", "'photons_per_s': 3e6"},
        {"'temperature_k': 5260}", "'temperature_k': 5260}, 'photons_per_s': 1e6"},
        {"{'separation_arcsec': 4, 'position_angle_deg': 30}", place},
        {"'pixel_scale_arcsec': 0.2", "'pixel_scale_arcsec': 0.4"}, {"'frames': 100, 'interval_days': 2", cadence});
    return replaced_again(text, "'noise': {'photon': true, 'read_e': 2.5, 'seed': 7}", more);
}

static char *scene_at(double date, const char *moving, const char *cadence, const char *more) {
    return orbit_at("'alpha-cen'", date, moving, cadence, more);
}

static toliman_sim_plan_info plan_of(const toliman_sim *sim) {
    toliman_sim_plan_info plan = {.struct_size = sizeof plan};
    assert_ok(toliman_sim_get_plan(sim, &plan));
    return plan;
}

/* Largest error of frame k over the peak, against the static scene of its date with the signal of frame k. */
static double error_against(const toliman_sim *sim, int64_t k, const char *text) {
    static double frame[PIXELS], there[PIXELS];
    double displacement, worst = 0;
    assert_ok(toliman_sim_get_series(sim, k, 1, NULL, &displacement));
    assert_ok(toliman_sim_frame(sim, NULL, 1, k, 1, frame));
    toliman_sim *const still = sim_of(text);
    assert_ok(toliman_sim_propagate(still, displacement, there, SIDE));
    for (int i = 0; i < PIXELS; i++)
        worst = fmax(worst, fabs(frame[i] - there[i]));
    worst /= sim_info_of(still).peak_photons;
    toliman_sim_destroy(still);
    return worst;
}

static double error_of(const toliman_sim *sim, int64_t k, double days) {
    char *const text = scene_at(2027 + days / 365.25, "", "'frames': 1", "'accuracy': 1e-15");
    const double error = error_against(sim, k, text);
    free(text);
    return error;
}

TEST(frames_follow_the_orbit) {
    const struct {
        const char *cadence, *accuracy;
        double interval;
        int64_t frames;
    } cases[] = {{"'frames': 1095, 'interval_days': 1", "'accuracy': 1e-9", 1, 1095},
                 {"'frames': 1095, 'interval_days': 1", "'accuracy': 1e-6", 1, 1095},
                 {"'frames': 1095, 'interval_days': 1", "'accuracy': 1e-11", 1, 1095},
                 {"'frames': 5, 'interval_days': 200", "'accuracy': 1e-15", 200, 5}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        char *const text = scene_at(2027, ", 'moving': true", cases[c].cadence, cases[c].accuracy);
        toliman_sim *const sim = sim_of(text);
        const toliman_sim_plan_info plan = plan_of(sim);
        double worst = 0;
        for (int i = 0; i < 4; i++) {
            const int64_t k = i * (cases[c].frames - 1) / 3;
            worst = fmax(worst, error_of(sim, k, (double)k * cases[c].interval));
        }
        print_message("%s, %.2g px along the orbit: %lld taps, exact %d: error/peak %.2g, planned %.2g\n",
                      cases[c].accuracy, plan.orbit_px, (long long)plan.atlas_taps, plan.exact_frames, worst,
                      plan.atlas_error);
        assert_true(plan.orbit_px > 1);
        assert_int_equal(plan.exact_frames, c == 3);
        assert_true((plan.atlas_taps > 0) == (c < 3));
        assert_at_most(plan.atlas_error, plan.accuracy);
        assert_at_most(worst, plan.atlas_error + 1e-13);
        toliman_sim_destroy(sim), free(text);
    }
}

/* From periastron to apoastron the farther star needs ever more wavelengths; the last frame must have enough, too. */
TEST(wavelengths_suffice_everywhere) {
    const char *const orbit = "{'period_years': 80, 'semi_major_arcsec': 8, 'eccentricity': 0.8,"
                              " 'inclination_deg': 0, 'node_deg': 30, 'periastron_deg': 0, 'epoch': 2027}";
    const char *const fine = "'step_nm': 0.5", *const coarse = "'step_nm': 12.5";
    char *text = orbit_at(orbit, 2027, ", 'moving': true, 'centre': 'A'", "'frames': 5, 'interval_days': 3652.5",
                          "'accuracy': 1e-9");
    text = replaced_again(text, coarse, fine);
    toliman_sim *const sim = sim_of(text);
    free(text);
    const toliman_sim_plan_info plan = plan_of(sim);
    assert_true(plan.wavelengths < plan.scene_wavelengths && plan.atlas_taps > 0);
    for (int k = 0; k < 5; k += 2) {
        text = orbit_at(orbit, 2027 + 10.0 * k, ", 'centre': 'A'", "'frames': 1", "'accuracy': 1e-15");
        text = replaced_again(text, coarse, fine);
        const double error = error_against(sim, k, text);
        print_message("year %d: %d nodes, error/peak %.2g, planned %.2g\n", 10 * k, plan.wavelengths, error,
                      plan.spectrum_error);
        assert_at_most(error, 1e-9);
        free(text);
    }
    toliman_sim_destroy(sim);
}

/* An orbit far shorter than the cadence must not be undersampled. */
TEST(short_orbits_are_followed) {
    const char *const orbit = "{'period_years': 0.04, 'semi_major_arcsec': 0.1, 'eccentricity': 0.2,"
                              " 'inclination_deg': 0, 'node_deg': 30, 'periastron_deg': 0, 'epoch': 2027}";
    char *text = orbit_at(orbit, 2027, ", 'moving': true, 'centre': 'A'", "'frames': 1000000, 'interval_days': 0.01",
                          "'accuracy': 1e-6");
    toliman_sim *const sim = sim_of(text);
    free(text);
    const toliman_sim_plan_info plan = plan_of(sim);
    assert_true(plan.atlas_taps > 0);
    const double speed = 2 * acos(-1) * 0.25 / 14.61 * sqrt(1.2 / 0.8); /* px per day at periastron */
    assert_close(plan.orbit_px, speed * 9999.99, 1e-3, 0);
    double worst = 0;
    for (int64_t k = 0; k < 1000000; k += 99731) {
        text = orbit_at(orbit, 2027 + (double)k / 36525, ", 'centre': 'A'", "'frames': 1", "'accuracy': 1e-15");
        worst = fmax(worst, error_against(sim, k, text));
        free(text);
    }
    print_message("685 turns: error/peak %.2g, planned %.2g\n", worst, plan.atlas_error);
    assert_at_most(worst, 1e-6);
    toliman_sim_destroy(sim);
}

/* Scale and focus act about the current positions of the stars. */
TEST(shapes_follow_the_orbit) {
    const char *const cadence = "'frames': 5, 'interval_days': 200";
    const char *const more = "'systematics': {'focus_rms_nm': 0.01, 'scale_rms': 1e-6}, 'accuracy': 1e-9";
    static double frame[PIXELS], there[PIXELS];
    char *text = scene_at(2027, ", 'moving': true", cadence, more);
    toliman_sim *const sim = sim_of(text);
    free(text);
    text = scene_at(2027 + 800 / 365.25, "", cadence, more);
    toliman_sim *const still = sim_of(text);
    free(text);
    double displacement, worst = 0;
    assert_ok(toliman_sim_get_series(sim, 4, 1, NULL, &displacement));
    assert_ok(toliman_sim_frame(sim, &displacement, 1, 4, 1, frame));
    assert_ok(toliman_sim_frame(still, &displacement, 1, 4, 1, there));
    for (int i = 0; i < PIXELS; i++)
        worst = fmax(worst, fabs(frame[i] - there[i]));
    assert_at_most(worst / sim_info_of(still).peak_photons, 1e-9);
    toliman_sim_destroy(sim), toliman_sim_destroy(still);
}

/* Largest difference over the peak of frame k between two simulators. */
static double difference_of(const toliman_sim *a, const toliman_sim *b, double displacement, int64_t k) {
    static double one[PIXELS], other[PIXELS];
    double worst = 0;
    assert_ok(toliman_sim_frame(a, &displacement, 1, k, 1, one));
    assert_ok(toliman_sim_frame(b, &displacement, 1, k, 1, other));
    for (int i = 0; i < PIXELS; i++)
        worst = fmax(worst, fabs(one[i] - other[i]));
    return worst / sim_info_of(b).peak_photons;
}

/* Interpolated frames against propagated ones, with every effect at once, and with listed times. */
TEST(interpolated_frames_equal_propagated_ones) {
    enum { FRAMES = 600 };
    const char *const effects =
        "'systematics': {'pointing_rms_px': 0.3, 'roll_rms_deg': 0.01,"
        " 'flux_rms': 0.02, 'background_rms_photons': 3, 'jitter_sigma_px': 0.1}, 'accuracy': %s";
    char cadence[8000] = "'times_days': [0", fine[400], exact[400];
    for (int k = 1; k < FRAMES; k++)
        sprintf(cadence + strlen(cadence), ", %d", k);
    strcat(cadence, "]");
    snprintf(fine, sizeof fine, effects, "1e-9");
    snprintf(exact, sizeof exact, effects, "1e-15");
    const char *const evenly = "'frames': 600, 'interval_days': 1";
    const char *const odd = "'m': 5", *const odd_and_even = "'m': 6"; /* so that defocus has a first order */
    char *text = scene_at(2027, ", 'moving': true", cadence, fine);
    toliman_sim *const sim = sim_with(text, odd, odd_and_even);
    free(text);
    text = scene_at(2027, ", 'moving': true", evenly, fine);
    toliman_sim *const even = sim_with(text, odd, odd_and_even);
    free(text);
    text = scene_at(2027, ", 'moving': true", evenly, exact);
    toliman_sim *const propagated = sim_with(text, odd, odd_and_even);
    free(text);
    const toliman_sim_plan_info plan = plan_of(sim);
    assert_true(plan.atlas_taps > 0 && plan_of(propagated).exact_frames == 1);
    for (int64_t k = 17; k < FRAMES; k += 250) {
        assert_at_most(difference_of(sim, even, 1e-3, k), 0);
        const double error = difference_of(sim, propagated, 1e-3, k);
        print_message("frame %d: error/peak %.2g, planned %.2g\n", (int)k, error, plan.atlas_error);
        assert_at_most(error, plan.atlas_error + 1e-13);
    }
    toliman_sim_destroy(sim), toliman_sim_destroy(even), toliman_sim_destroy(propagated);
}

/* A frame outside the atlas is propagated; one of 1e-10 px is not lost. */
TEST(displacements_of_any_size) {
    static double at_0[PIXELS], moved[PIXELS], there[PIXELS];
    char *const text = scene_at(2027, ", 'moving': true", "'frames': 5, 'interval_days': 1", "'accuracy': 1e-9");
    char *const finest = scene_at(2027, ", 'moving': true", "'frames': 5, 'interval_days': 1", "'accuracy': 1e-13");
    toliman_sim *const sim = sim_of(text), *const fine = sim_of(finest);
    const double peak = sim_info_of(sim).peak_photons, far[] = {-14, 14, 1, 90};
    for (int i = 0; i < 4; i++) {
        double worst = 0;
        assert_ok(toliman_sim_frame(sim, &far[i], 1, 0, 1, moved));
        assert_ok(toliman_sim_propagate(sim, far[i], there, SIDE));
        for (int p = 0; p < PIXELS; p++)
            worst = fmax(worst, fabs(moved[p] - there[p]));
        assert_at_most(worst / peak, 1e-9);
    }
    assert_refused(toliman_sim_frame(sim, &(double){101}, 1, 0, 1, moved), TOLIMAN_E_RANGE, "displacements_px[0]");
    double *const slope = image_of(fine, TOLIMAN_SIM_IMAGE_SEPARATION), largest = 0, worst = 0;
    assert_ok(toliman_sim_frame(fine, &(double){0}, 1, 0, 1, at_0));
    assert_ok(toliman_sim_frame(fine, &(double){1e-10}, 1, 0, 1, moved));
    for (int p = 0; p < PIXELS; p++) {
        largest = fmax(largest, fabs(slope[p] * 1e-10));
        worst = fmax(worst, fabs(moved[p] - at_0[p] - slope[p] * 1e-10));
    }
    print_message("signal of 1e-10 px: %.2g of the peak, error %.2g of the peak\n", largest / peak, worst / peak);
    assert_true(largest / peak > 1e-12);
    assert_at_most(worst / peak, 1e-14);
    free(slope), free(text), free(finest), toliman_sim_destroy(sim), toliman_sim_destroy(fine);
}

/* In any order and with any number of threads: the same bytes. */
/* promise: frames-depend-on-seed-alone */
TEST(frames_are_computed_in_any_order) {
    enum { FRAMES = 12 };
    char *const text = scene_at(2027, ", 'moving': true", "'frames': 12000, 'interval_days': 0.1",
                                "'noise': {'photon': true, 'seed': 3}, 'accuracy': 1e-9");
    toliman_sim *const sim = sim_on_threads(text, 4), *const other = sim_on_threads(text, 1);
    double *const frames = malloc(FRAMES * PIXELS * sizeof *frames), *const again = malloc(PIXELS * sizeof *again);
    assert_non_null(frames);
    assert_non_null(again);
    assert_ok(toliman_sim_frame(sim, NULL, 3, 5000, FRAMES, frames)); /* the first ones, on several threads */
    for (int64_t i = FRAMES; i-- > 0;) {
        assert_ok(toliman_sim_frame(other, NULL, 3, 5000 + i, 1, again));
        assert_memory_equal(again, frames + i * PIXELS, PIXELS * sizeof *again);
    }
    free(frames), free(again), toliman_sim_destroy(sim), toliman_sim_destroy(other), free(text);
}

RUN_TESTS(NULL, NULL)
