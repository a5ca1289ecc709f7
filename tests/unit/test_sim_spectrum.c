/* Tests temperatures and modes of spectra against spectra computed by hand. */
#include "scene_files.h"

enum { WAVELENGTHS = 5 };

static const double kWavelength[WAVELENGTHS] = {550, 562.5, 575, 587.5, 600},
                    kTable[WAVELENGTHS] = {1, 1.2, 0.9, 1.1, 1.05}, kPhotons = 3e7;

/* Photons per wavelength of a black body, in any unit. */
static double planck(double nm, double kelvin) {
    return 1 / (pow(nm, 4) * (exp(6.62607015e-34 * 299792458.0 / (nm * 1e-9 * 1.380649e-23 * kelvin)) - 1));
}

static int make_files(void **state) {
    const int failed = make_folder(state);
    char text[200] = "";
    for (int i = 0; i < WAVELENGTHS; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%g,%g\n", kWavelength[i], kTable[i]);
    write_file("star.csv", text, strlen(text));
    return failed;
}

/* kBinaryScene with this spectrum of star A, 3e7 photons in one second. */
static char *text_with(const char *spectrum) {
    char *text = EDITED(kBinaryScene, {"'kind': 'blackbody', 'temperature_k': 5790", spectrum},
                        {"'peak_photons': 1e5", "'exposure_s': 1"}, {"'relative_flux': 3", "'photons_per_s': 3e7"});
    return replaced_again(text, "5260}}}", "5260}, 'photons_per_s': 1e7}}");
}

/* Star A has the expected relative photons, with half weight at both ends, and kPhotons in total. */
static void check_spectrum(const char *spectrum, const double *expected) {
    char *const text = text_with(spectrum);
    toliman_sim *sim = NULL;
    double wavelength[WAVELENGTHS], a[WAVELENGTHS], sum = 0;
    assert_ok(create_in_folder(text, &sim));
    assert_ok(toliman_sim_get_spectrum(sim, WAVELENGTHS, wavelength, a, NULL, NULL));
    for (int i = 0; i < WAVELENGTHS; i++)
        sum += expected[i] * (i % (WAVELENGTHS - 1) == 0 ? 0.5 : 1);
    for (int i = 0; i < WAVELENGTHS; i++) {
        assert_close(wavelength[i], 1e-9 * kWavelength[i], 1e-15, 0);
        assert_close(a[i], kPhotons * expected[i] * (i % (WAVELENGTHS - 1) == 0 ? 0.5 : 1) / sum, 1e-12, 0);
    }
    toliman_sim_destroy(sim), free(text);
}

TEST(temperatures_multiply_tables) {
    double expected[WAVELENGTHS];
    for (int i = 0; i < WAVELENGTHS; i++)
        expected[i] = kTable[i] * planck(kWavelength[i], 5900) / planck(kWavelength[i], 5770);
    check_spectrum("'kind': 'table', 'file': 'star.csv', 'star_temperature_k': 5900, 'table_temperature_k': 5770",
                   expected);
    check_spectrum("'kind': 'table', 'file': 'star.csv', 'star_temperature_k': 5770, 'table_temperature_k': 5770",
                   kTable);
}

/* P_1 = x, P_2 = (3 x^2 - 1)/2, P_3 = (5 x^3 - 3 x)/2, P_4 = (35 x^4 - 30 x^2 + 3)/8 of x = -1 ... 1. */
TEST(modes_are_legendre_polynomials) {
    double black[WAVELENGTHS], table[WAVELENGTHS];
    for (int i = 0; i < WAVELENGTHS; i++) {
        const double x = (i - 2) / 2.0, p2 = (3 * x * x - 1) / 2, p3 = (5 * x * x - 3) * x / 2,
                     p4 = (35 * x * x * x * x - 30 * x * x + 3) / 8;
        const double factor = 1 + 0.1 * x - 0.2 * p2 + 0.05 * p3 + 0.3 * p4;
        black[i] = planck(kWavelength[i], 5790) * factor;
        table[i] = kTable[i] * planck(kWavelength[i], 5000) / planck(kWavelength[i], 6000) * factor;
    }
    const char *const modes = "'modes': [0.1, -0.2, 0.05, 0.3]";
    char spectrum[200];
    snprintf(spectrum, sizeof spectrum, "'kind': 'blackbody', 'temperature_k': 5790, %s", modes);
    check_spectrum(spectrum, black);
    snprintf(spectrum, sizeof spectrum,
             "'kind': 'table', 'file': 'star.csv', 'star_temperature_k': 5000, 'table_temperature_k': 6000, %s", modes);
    check_spectrum(spectrum, table);
}

/* P_k(1) = 1 and P_k(-1) = (-1)^k for all eleven; in the middle the odd ones are 0 and the even ones (-1)^(k/2) (k -
 * 1)!!/k!!. */
TEST(eleven_modes) {
    for (int mode = 5; mode <= 11; mode++) {
        char spectrum[200] = "'kind': 'blackbody', 'temperature_k': 5790, 'modes': [";
        for (int k = 1; k <= mode; k++)
            strcat(spectrum, k < mode ? "0, " : "0.5]");
        char *const text = text_with(spectrum);
        toliman_sim *sim = NULL;
        double a[WAVELENGTHS], middle = mode % 2 == 0 ? 1 : 0;
        assert_ok(create_in_folder(text, &sim));
        assert_ok(toliman_sim_get_spectrum(sim, WAVELENGTHS, NULL, a, NULL, NULL));
        for (int k = 2; k <= mode && mode % 2 == 0; k += 2)
            middle *= -(k - 1.0) / k;
        const double blue = a[0] / planck(550, 5790), red = a[4] / planck(600, 5790);
        assert_close(blue / red, (mode % 2 == 0 ? 1.5 : 0.5) / 1.5, 1e-12, 0);
        assert_close(a[2] / planck(575, 5790) / (2 * red), (1 + 0.5 * middle) / 1.5, 1e-12, 0);
        toliman_sim_destroy(sim), free(text);
    }
}

TEST(refusals) {
    const refusal cases[] = {
        {"'temperature_k': 5790", "'temperature_k': 5790, 'table_temperature_k': 5770",
         "stars.A.spectrum.table_temperature_k"},
        {"'temperature_k': 5790", "'temperature_k': 5790, 'modes': 0.1", "stars.A.spectrum.modes"},
        {"'temperature_k': 5790", "'temperature_k': 5790, 'modes': []", "stars.A.spectrum.modes"},
        {"'temperature_k': 5790", "'temperature_k': 5790, 'modes': [0, 11]", "stars.A.spectrum.modes[1]"},
        {"'temperature_k': 5790", "'temperature_k': 5790, 'modes': [0, 0, 2]", "stars.A.spectrum.modes"},
    };
    CHECK_REFUSALS(kBinaryScene, TOLIMAN_E_SCENE, cases);
    const char *const tables[][2] = {
        {"'star_temperature_k': 5770", "stars.A.spectrum.table_temperature_k"},
        {"'table_temperature_k': 5770", "stars.A.spectrum.star_temperature_k"},
        {"'star_temperature_k': 99, 'table_temperature_k': 5770", "stars.A.spectrum.star_temperature_k"},
        {"'temperature_k': 5770", "stars.A.spectrum.temperature_k"},
    };
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        char spectrum[200];
        snprintf(spectrum, sizeof spectrum, "'kind': 'table', 'file': 'star.csv', %s", tables[i][0]);
        char *const text = text_with(spectrum);
        toliman_sim *sim = NULL;
        assert_refused(create_in_folder(text, &sim), TOLIMAN_E_SCENE, tables[i][1]);
        assert_null(sim);
        free(text);
    }
    toliman_sim *sim = NULL;
    char *const text = replaced(kSingleScene, "5790}", "5790, 'modes': [0.1]}");
    assert_refused(create_in_folder(text, &sim), TOLIMAN_E_SCENE, "stars.A.spectrum.modes");
    free(text);
}

RUN_TESTS(make_files, remove_folder)
