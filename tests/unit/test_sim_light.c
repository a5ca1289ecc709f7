/* Tests the light path: throughput, quantum efficiency by wavelength, magnitudes in bands, and fluxes in electrons,
 * against integrals and sums computed here. */
#include <toliman/sim_derivative.h>

#include "scene_files.h"

enum { WAVELENGTHS = 5 };

static const double kWavelength[WAVELENGTHS] = {550, 562.5, 575, 587.5, 600};
static const double kPlanck = 6.62607015e-34, kLight = 299792458.0, kBoltzmann = 1.380649e-23;

/* Photons per wavelength of a black body, in any unit. */
static long double planck(long double nm, long double kelvin) {
    return 1 / (powl(nm, 4) * expm1l(kPlanck * kLight / (nm * 1e-9L * kBoltzmann * kelvin)));
}

/* Filter, mirror and quantum efficiency, linear between two wavelengths. */
static double filter(double nm) {
    return 0.9 - 0.004 * (nm - 550);
}
static double mirror(double nm) {
    return 0.8 + 0.001 * (nm - 550);
}
static double qe(double nm) {
    return 0.5 + 0.003 * (nm - 550);
}

static void write_text(const char *name, const char *text) {
    write_file(name, text, strlen(text));
}

static void write_line(const char *name, const char *header, double (*value)(double)) {
    char text[200];
    snprintf(text, sizeof text, "%s\n540,%.17g\n610,%.17g\n", header, value(540), value(610));
    write_text(name, text);
}

static int make_files(void **state) {
    const int failed = make_folder(state);
    write_line("filter.csv", "wavelength_nm,transmission", filter);
    write_line("mirror.csv", "nm,reflectance", mirror);
    write_line("qe.csv", "nm,qe", qe);
    return failed;
}

static int remove_files(void **state) {
    static const char *const names[] = {"filter.csv", "mirror.csv", "qe.csv", "band.csv"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        unlink(path_of(names[i]));
    return remove_folder(state);
}

/* kBinaryScene of one second with these fluxes, telescope keys and detector keys. */
static char *text_with(const char *flux_a, const char *flux_b, const char *telescope, const char *detector) {
    char b[200], pupil[300], pixels[200];
    snprintf(b, sizeof b, "5260}, %s}", flux_b);
    snprintf(pupil, sizeof pupil, "'aperture_m': 0.125, %s", telescope);
    snprintf(pixels, sizeof pixels, "'shape': [64, 64], %s", detector);
    return EDITED(kBinaryScene, {"'relative_flux': 3", flux_a}, {"5260}}", b},
                  {"'peak_photons': 1e5", "'exposure_s': 2"}, {"'aperture_m': 0.125,", pupil},
                  {"'shape': [64, 64],", pixels});
}

static toliman_sim_plan_info plan_of(const char *text) {
    toliman_sim_plan_info plan = TOLIMAN_SIM_PLAN_INFO_INIT;
    assert_ok(toliman_sim_plan_json(text, strlen(text), folder, NULL, &plan));
    return plan;
}

/* Light of star A in two seconds. */
static void spectrum_of(const char *text, double *a) {
    toliman_sim *sim = NULL;
    assert_ok(create_in_folder(text, &sim));
    assert_ok(toliman_sim_get_spectrum(sim, WAVELENGTHS, NULL, a, NULL, NULL));
    toliman_sim_destroy(sim);
}

static double half(int i) {
    return i % (WAVELENGTHS - 1) == 0 ? 0.5 : 1;
}

TEST(throughput_and_qe_shape_the_light) {
    char *const text = text_with("'photons_per_s': 1e6", "'photons_per_s': 1e6",
                                 "'throughput': ['filter.csv', 'mirror.csv', 'mirror.csv', 0.7],", "'qe': 'qe.csv',");
    double a[WAVELENGTHS], through = 0, all = 0, electrons = 0;
    spectrum_of(text, a);
    for (int i = 0; i < WAVELENGTHS; i++) {
        const double nm = kWavelength[i], star = half(i) * (double)planck(nm, 5790);
        all += star;
        through += star * filter(nm) * mirror(nm) * mirror(nm) * 0.7;
    }
    for (int i = 0; i < WAVELENGTHS; i++) {
        const double nm = kWavelength[i];
        const double expected =
            2e6 * half(i) * (double)planck(nm, 5790) * filter(nm) * mirror(nm) * mirror(nm) * 0.7 / through * qe(nm);
        assert_close(a[i], expected, 1e-12, 0);
        electrons += expected / 2;
    }
    const toliman_sim_plan_info plan = plan_of(text);
    free(text);
    assert_close(plan.throughput[0], through / all, 1e-12, 0);
    assert_close(plan.photons_per_s[0], 1e6, 1e-12, 0);
    assert_close(plan.electrons_per_s[0], electrons, 1e-12, 0);
    assert_true(isnan(plan.magnitude[0]));
}

/* A file of one value and the number are the same detector, but for the meaning of peak_photons. */
TEST(qe_of_a_file_and_of_a_number) {
    write_text("band.csv", "500,0.6\n700,0.6\n");
    toliman_sim *sims[2] = {NULL, NULL};
    static double images[2][64 * 64];
    for (int i = 0; i < 2; i++) {
        char *const text =
            text_with("'photons_per_s': 3e6", "'photons_per_s': 1e6", "", i == 0 ? "'qe': 0.6," : "'qe': 'band.csv',");
        toliman_sim_info info = TOLIMAN_SIM_INFO_INIT;
        assert_ok(create_in_folder(text, &sims[i]));
        assert_ok(toliman_sim_get_image(sims[i], TOLIMAN_SIM_IMAGE_BOTH, images[i], 64));
        assert_ok(toliman_sim_get_info(sims[i], &info));
        assert_int_equal(info.unit, TOLIMAN_SIM_UNIT_ELECTRON);
        toliman_sim_destroy(sims[i]), free(text);
    }
    for (int i = 0; i < 64 * 64; i++)
        assert_close(images[1][i], images[0][i], 1e-12, 0);
}

TEST(electrons_are_not_multiplied_by_qe) {
    char *const text = text_with("'detected_per_s': 3e6", "'detected_per_s': 1e6", "", "");
    toliman_sim *sim = NULL;
    toliman_sim_info info = TOLIMAN_SIM_INFO_INIT;
    assert_ok(create_in_folder(text, &sim));
    assert_ok(toliman_sim_get_info(sim, &info));
    toliman_sim_destroy(sim);
    assert_int_equal(info.unit, TOLIMAN_SIM_UNIT_ELECTRON);
    assert_close(info.flux_ratio, 3, 1e-12, 0);
    const toliman_sim_plan_info plan = plan_of(text);
    free(text);
    assert_close(plan.electrons_per_s[1], 1e6, 1e-12, 0);
    assert_close(plan.photons_per_s[1], 0, 0, 0);
}

/* Bessell (1990), table 2: response to energy at 470, 480, ... 700 nm. */
static const long double kV[] = {0,      0.030L, 0.163L, 0.458L, 0.780L, 0.967L, 1,      0.973L,
                                 0.898L, 0.792L, 0.684L, 0.574L, 0.461L, 0.359L, 0.270L, 0.197L,
                                 0.135L, 0.081L, 0.045L, 0.025L, 0.017L, 0.013L, 0.009L, 0};

/* Photons per s, m2 and nm of a black body at these wavelengths over its photons in V, for magnitude 0: the mean energy
 * per wavelength, weighted by the table, is 3.631e-9 erg/s/cm2/A. In 2e4 midpoints. */
static long double zero_in_v(long double kelvin) {
    long double energy = 0, weight = 0;
    const int parts = 20000;
    for (int i = 0; i < parts; i++) {
        const long double place = (i + 0.5L) * 23 / parts, nm = 470 + 10 * place;
        const int k = (int)place;
        const long double response = kV[k] + (place - k) * (kV[k + 1] - kV[k]);
        energy += response * planck(nm, kelvin) * kPlanck * kLight / (nm * 1e-9L);
        weight += response;
    }
    return 3.631e-11L * weight / energy; /* W/m2/nm */
}

TEST(magnitudes_in_v) {
    static const double magnitude[2] = {0.01, 1.33}, kelvin[2] = {5790, 5260};
    char *const text = text_with("'magnitude': 0.01, 'magnitude_band': 'V'",
                                 "'magnitude': 1.33, 'magnitude_band': 'V', 'magnitude_system': 'vega'",
                                 "'throughput': ['filter.csv'],", "'qe': 0.9,");
    const toliman_sim_plan_info plan = plan_of(text);
    free(text);
    const double area = 3.14159265358979323846 / 4 * (0.125 * 0.125 - 0.01875 * 0.01875);
    assert_close(plan.open_area_m2, area, 1e-4, 0);
    for (int star = 0; star < 2; star++) {
        long double photons = 0;
        for (int i = 0; i < WAVELENGTHS; i++)
            photons += half(i) * 12.5L * planck(kWavelength[i], kelvin[star]) * filter(kWavelength[i]);
        photons *= zero_in_v(kelvin[star]) * powl(10, -0.4L * magnitude[star]) * plan.open_area_m2;
        assert_close(plan.photons_per_s[star], (double)photons, 1e-7, 0);
        assert_close(plan.electrons_per_s[star], 0.9 * (double)photons, 1e-7, 0);
        assert_close(plan.magnitude[star], magnitude[star], 0, 0);
    }
}

/* A response of 1 from 560 to 580 nm: the photons of 3631 Jy are F/h ln(580/560). A black body of 5790 K through the
 * same interval, in 1e4 midpoints. */
TEST(magnitudes_in_ab) {
    write_text("band.csv",
               "# throughput of a box\nnm throughput\n300 0\n559.999999 0\n560 1\n580 1\n580.000001 0\n1e6 0\n");
    const char *const flux = "'magnitude': 2, 'magnitude_band': 'band.csv', 'magnitude_system': 'ab'";
    char *const text = text_with(flux, flux, "", "");
    const toliman_sim_plan_info plan = plan_of(text);
    free(text);
    long double inside = 0, light = 0;
    for (int i = 0; i < 10000; i++)
        inside += planck(560 + (i + 0.5L) * 0.002L, 5790) * 0.002L;
    for (int i = 0; i < WAVELENGTHS; i++)
        light += half(i) * 12.5L * planck(kWavelength[i], 5790);
    const long double zero = 3.631e-23L / kPlanck * logl(580 / 560.0L);
    assert_close(plan.photons_per_s[0], (double)(zero * powl(10, -0.8L) * light / inside * plan.open_area_m2), 1e-9, 0);
}

/* The spectrum of a table must cover the band of its magnitude, apart from where that responds to nothing; the ends may
 * be rounded by their unit. */
TEST(magnitudes_of_tables) {
    static const struct {
        const char *band, *table;
        toliman_status status;
    } cases[] = {
        {"nm,response\n300,0\n550,0\n570,1\n600,0\n900,0\n", "m,photlam\n5.5e-7,1\n6e-7,1\n", TOLIMAN_OK},
        {"nm,response\n300,0\n550,0\n570,1\n600,0\n900,0\n", "um,photlam\n0.55,1\n0.6,1\n", TOLIMAN_OK},
        {"nm,response\n540,0\n570,1\n600,0\n", "nm,photlam\n550,1\n600,1\n", TOLIMAN_E_SCENE},
        {"nm,response\n500,0\n600,0\n", "nm,photlam\n400,1\n700,1\n", TOLIMAN_E_SCENE},
        {"nm,response\n640,0\n650,1\n", "nm,photlam\n550,1\n600,1\n", TOLIMAN_E_SCENE},
    };
    const char *const flux = "'magnitude': 2, 'magnitude_band': 'band.csv', 'magnitude_system': 'ab'";
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_text("band.csv", cases[i].band);
        write_text("star.csv", cases[i].table);
        char *text = text_with(flux, "'photons_per_s': 1e6", "", "");
        text =
            replaced_again(text, "'kind': 'blackbody', 'temperature_k': 5790", "'kind': 'table', 'file': 'star.csv'");
        toliman_sim_plan_info plan = TOLIMAN_SIM_PLAN_INFO_INIT;
        const toliman_status status = toliman_sim_plan_json(text, strlen(text), folder, NULL, &plan);
        free(text);
        if (cases[i].status != TOLIMAN_OK) {
            assert_refused(status, cases[i].status, "stars.A.magnitude_band");
            continue;
        }
        assert_ok(status);
        /* Triangle of 50 nm: photons of 3631 Jy are F/h times the integral of S/lambda, piece by piece. */
        const double up = 1 - 550 / 20.0 * log(570 / 550.0), down = 600 / 30.0 * log(600 / 570.0) - 1;
        const double zero =
            3.631e-23 / kPlanck * (up + down) / 25; /* the mean of S is 25 nm: per nm of a flat spectrum */
        assert_close(plan.photons_per_s[0], zero * pow(10, -0.8) * 50 * plan.open_area_m2, 1e-9, 0);
    }
}

/* With the efficiency of a file, derivatives by the spectrum keep the photons before it. */
TEST(derivatives_with_qe_of_a_file) {
    static double derivative[64 * 64], images[2][64 * 64];
    static const struct {
        const char *name, *minus, *plus;
        double step;
    } cases[] = {
        {"temperature_a", "5788}", "5792}", 2},
        {"spectrum_a_1", "5790, 'modes': [-1e-3]}", "5790, 'modes': [1e-3]}", 1e-3},
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        double most = 0;
        for (int side = -1; side < 2; side++) {
            char *text = text_with("'photons_per_s': 3e6", "'photons_per_s': 1e6", "'throughput': ['filter.csv'],",
                                   "'qe': 'qe.csv',");
            toliman_sim *sim = NULL;
            if (side != 0)
                text = replaced_again(text, "5790}", side < 0 ? cases[c].minus : cases[c].plus);
            assert_ok(create_in_folder(text, &sim));
            if (side == 0)
                assert_ok(toliman_sim_get_derivative(sim, cases[c].name, derivative, 64));
            else
                assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, images[side > 0], 64));
            toliman_sim_destroy(sim), free(text);
        }
        for (int i = 0; i < 64 * 64; i++)
            most = fmax(most, fabs(derivative[i]));
        for (int i = 0; i < 64 * 64; i++)
            assert_close(derivative[i], (images[1][i] - images[0][i]) / (2 * cases[c].step), 0, 1e-6 * most);
    }
}

TEST(refusals) {
    static const struct {
        const char *flux, *telescope, *detector, *field;
    } cases[] = {
        {"'photons_per_s': 1, 'detected_per_s': 1", "", "", "stars.A.photons_per_s"},
        {"'detected_per_s': 1", "", "'qe': 0.5,", "detector.qe"},
        {"'detected_per_s': 1", "", "'qe': 'qe.csv',", "detector.qe"},
        {"'detected_per_s': 1, 'relative_flux': 1", "", "", "stars.A.relative_flux"},
        {"'magnitude': 1", "", "", "stars.A.zero_point_photons_per_s"},
        {"'magnitude': 1, 'magnitude_band': 'V', 'zero_point_photons_per_s': 1", "", "",
         "stars.A.zero_point_photons_per_s"},
        {"'magnitude': 1, 'magnitude_band': 'filter.csv'", "", "", "stars.A.magnitude_system"},
        {"'magnitude': 1, 'magnitude_band': 'filter.csv', 'magnitude_system': 'vega'", "", "",
         "stars.A.magnitude_system"},
        {"'magnitude': 1, 'magnitude_band': 'none.csv', 'magnitude_system': 'ab'", "", "", NULL},
        {"'magnitude': 1, 'zero_point_photons_per_s': 1, 'magnitude_system': 'ab'", "", "", "stars.A.magnitude_system"},
        {"'magnitude_band': 'V'", "", "", "stars.A.magnitude_band"},
        {"'magnitude': -50, 'magnitude_band': 'V'", "", "", "stars.A.magnitude"},
        {"'photons_per_s': 1", "'throughput': [1.5],", "", "telescope.throughput[0]"},
        {"'photons_per_s': 1", "'throughput': [0.5, 0],", "", "telescope.throughput[1]"},
        {"'photons_per_s': 1", "'throughput': [],", "", "telescope.throughput"},
        {"'photons_per_s': 1", "'throughput': [true],", "", "telescope.throughput[0]"},
        {"'photons_per_s': 1", "'throughput': ['qe.csv'],", "", NULL},
        {"'photons_per_s': 1", "'throughput': ['none.csv'],", "", NULL},
        {"'photons_per_s': 1", "", "'qe': 'filter.csv',", NULL},
        {"'photons_per_s': 1", "", "'qe': [1],", "detector.qe"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const int detected = strstr(cases[i].flux, "detected") != NULL;
        char *const text = text_with(cases[i].flux, detected ? "'detected_per_s': 1" : "'photons_per_s': 1",
                                     cases[i].telescope, cases[i].detector);
        toliman_sim *sim = NULL;
        const toliman_status status = create_in_folder(text, &sim);
        if (cases[i].field != NULL)
            assert_refused(status, TOLIMAN_E_SCENE, cases[i].field);
        else
            assert_true(status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_NOT_FOUND);
        assert_null(sim);
        free(text);
    }
    static const struct {
        const char *text, *message;
    } tables[] = {
        {"nm,throughput\n500,91\n700,92\n", "must be in [0, 1], not in percent"},
        {"nm,throughput (%)\n500,0.91\n700,0.92\n", "from 0 to 1"},
        {"nm,quantum efficiency\n500,0.91\n700,0.92\n", "a quantum efficiency is detector.qe"},
        {"nm,throughput\n560,0.9\n700,0.9\n", "the file covers 560 to 700 nm"},
        {"nm,throughput\n500,-0.1\n700,0.9\n", "must be finite and not negative"},
    };
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        write_text("band.csv", tables[i].text);
        char *const text = text_with("'photons_per_s': 1", "'photons_per_s': 1", "'throughput': ['band.csv'],", "");
        toliman_sim *sim = NULL;
        const toliman_status status = create_in_folder(text, &sim);
        assert_fails(status, i == 3 ? TOLIMAN_E_SCENE : TOLIMAN_E_FORMAT, tables[i].message);
        free(text);
    }
}

RUN_TESTS(make_files, remove_files)
