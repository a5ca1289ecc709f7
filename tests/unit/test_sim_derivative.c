/* Tests the derivative of every parameter of the model against central differences of whole scenes, extrapolated from
 * two steps (Richardson): two scenes that differ by a step in their own keys. */
#include <stddef.h>

#include <toliman/sim_derivative.h>

#include "scene_text.h"

enum { SIDE = 16, PIXELS = SIDE * SIDE, MODES = 11, LAST_ZERNIKE = 36, MOST = 200 };

typedef enum { CONTINUOUS, LINES, SINGLE } light;

/* The keys of a scene that parameters change. */
typedef struct {
    light light;
    int blurred, dispersed;
    double qe, offset[4], photons[2], dark, pixel_arcsec, anisotropy, shear, zernike[LAST_ZERNIKE + 1], rotation_deg,
        mask_shift[2], jitter[3], kelvin[2], modes[2][MODES], longer_nm, smear;
    const char *motion;                                  /* kind of the smear; NULL: none */
    double diffusion, transfer, fatter, coupling, curve; /* of the detector; diffusion: px^2 */
} keys;

static const keys kKeys = {.qe = 1,
                           .blurred = 1,
                           .offset = {-4.3, 2.1, 3.2, 5.7},
                           .photons = {3e7, 1e7},
                           .dark = 10,
                           .pixel_arcsec = 0.2,
                           .anisotropy = 0.01,
                           .shear = -0.02,
                           .zernike = {[4] = 5, [6] = -7, [7] = 12, [11] = 6, [22] = -4},
                           .rotation_deg = 3,
                           .mask_shift = {2e-4, -1e-4},
                           .jitter = {0.04, 0.07, 0.02},
                           .kelvin = {5790, 5260},
                           .modes = {{0.1, -0.05, 0.02}, {-0.1, 0, 0.03, 0.04}},
                           .smear = 0.5,
                           .diffusion = 0.05,
                           .fatter = 1e-9,
                           .coupling = 0.01,
                           .curve = 2e-9};

static void put(char *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void put(char *text, const char *format, ...) {
    va_list values;
    va_start(values, format);
    vsprintf(text + strlen(text), format, values);
    va_end(values);
}

static void put_star(char *text, const keys *k, int star) {
    put(text, "'%c': {'photons_per_s': %.17g, 'spectrum': ", 'A' + star, k->photons[star]);
    if (k->light == LINES)
        put(text, "{'kind': 'lines', 'wavelength_nm': [%.17g, %.17g, %.17g], 'weight': [1, 0.6, %g]}}",
            560 + k->longer_nm, 571 + k->longer_nm, 598 + k->longer_nm, 0.5 + star);
    else
        put(text, "{'kind': 'blackbody', 'temperature_k': %.17g", k->kelvin[star]);
    if (k->light == CONTINUOUS)
        for (int i = 0; i < MODES; i++)
            put(text, "%s%.17g%s", i == 0 ? ", 'modes': [" : ", ", k->modes[star][i], i == MODES - 1 ? "]" : "");
    put(text, k->light == LINES ? "" : "}}");
}

static toliman_sim *sim_of_keys(const keys *k) {
    char text[6000] =
        "{'schema': 'toliman-scene/1', 'accuracy': 1e-11, 'telescope': {'aperture_m': 0.125, 'secondary_m':"
        " 0.02, 'struts': {'count': 3, 'width_m': 0.004}, 'pupil_samples': 24, 'aberrations':"
        " {'zernike_rms_nm': {";
    for (int noll = 4; noll <= LAST_ZERNIKE; noll++)
        put(text, "%s'%d': %.17g", noll == 4 ? "" : ", ", noll, k->zernike[noll]);
    put(text,
        "}}, 'mask': {'kind': 'spiral', 'opd_nm': 297.5, 'edges': 'area', 'rotation_deg': %.17g,"
        " 'shift_m': [%.17g, %.17g],"
        " 'terms': [{'a': 0.819, 'f': 2.918, 'm': -7, 'p': 4.874}, {'a': 0.93, 'f': 1.829, 'm': 5}]}},",
        k->rotation_deg, k->mask_shift[0], k->mask_shift[1]);
    if (k->light == CONTINUOUS)
        put(text, "'band': {'min_nm': 550, 'max_nm': 600, 'step_nm': 12.5}, ");
    if (k->light == SINGLE)
        put(text, "'band': {'wavelength_nm': %.17g}, ", 580 + k->longer_nm);
    put(text, "'stars': {");
    for (int star = 0; star < 2; star++) {
        put_star(text, k, star);
        put(text, star == 0 ? ", " : "}, ");
    }
    if (k->blurred)
        put(text, "'systematics': {'jitter_covariance_px2': {'xx': %.17g, 'yy': %.17g, 'xy': %.17g}", k->jitter[0],
            k->jitter[1], k->jitter[2]);
    if (k->blurred && k->motion != NULL)
        put(text, ", 'smear': {'kind': '%s', 'length_px': %.17g, 'angle_deg': 30}", k->motion, sqrt(k->smear));
    if (k->blurred)
        put(text, "}, ");
    put(text, "'binary': {'offsets_px': {'A': [%.17g, %.17g], 'B': [%.17g, %.17g]}}, ", k->offset[0], k->offset[1],
        k->offset[2], k->offset[3]);
    put(text,
        "'signal': {'kind': 'sinusoid', 'star': 'B', 'amplitude_px': 1e-5, 'period_days': 40},"
        " 'cadence': {'frames': 2, 'interval_days': 1, 'exposure_s': 1},"
        " 'detector': {'shape': [%d, %d], 'pixel': 'integrated', 'pixel_scale_arcsec': %.17g, 'qe': %g,"
        " 'scale_anisotropy': %.17g, 'shear': %.17g, 'dark_e_per_s': %.17g, 'gain_e_per_dn': 2, 'diffusion_px': %.17g,"
        " 'transfer_smear': %.17g, 'brighter_fatter_px2_per_e': %.17g, 'interpixel_capacitance': %.17g,"
        " 'nonlinearity_per_e': %.17g%s}}",
        SIDE, SIDE, k->pixel_arcsec, k->qe, k->anisotropy, k->shear, k->dark, sqrt(k->diffusion), k->transfer,
        k->fatter, k->coupling, k->curve,
        k->dispersed ? ", 'sidelobe': {'period_um': 2000, 'angle_deg': 40, 'centre_nm': 577, 'efficiency': 0.5}" : "");
    char *const scene = quoted(text);
    toliman_sim *const sim = sim_of(scene);
    free(scene);
    return sim;
}

/* Changes of the keys by h units of a parameter that are not a sum. */
static void change_separation(keys *k, double h) { /* of the signal: star B moves */
    const double x = k->offset[2] - k->offset[0], y = k->offset[3] - k->offset[1], d = hypot(x, y);
    k->offset[2] += h * x / d;
    k->offset[3] += h * y / d;
}
static void turn(double *offset, double angle) {
    const double x = offset[0], y = offset[1];
    offset[0] = x * cos(angle) - y * sin(angle);
    offset[1] = x * sin(angle) + y * cos(angle);
}
static void change_angle(keys *k, double h) {
    double from_a[2] = {k->offset[2] - k->offset[0], k->offset[3] - k->offset[1]};
    turn(from_a, h);
    for (int axis = 0; axis < 2; axis++)
        k->offset[2 + axis] = k->offset[axis] + from_a[axis];
}
static void change_roll(keys *k, double h) {
    turn(k->offset, h);
    turn(k->offset + 2, h);
}
static void change_shift_x(keys *k, double h) {
    k->offset[0] += h;
    k->offset[2] += h;
}
static void change_shift_y(keys *k, double h) {
    k->offset[1] += h;
    k->offset[3] += h;
}
static void change_flux_a(keys *k, double h) {
    k->photons[0] *= 1 + h;
}
static void change_flux_b(keys *k, double h) {
    k->photons[1] *= 1 + h;
}
static void change_scale(keys *k, double h) {
    k->pixel_arcsec /= 1 + h;
    for (int i = 0; i < 4; i++)
        k->offset[i] *= 1 + h;
}
/* The stars keep their angles. */
static void deform(keys *k, double anisotropy, double shear) {
    for (int star = 0; star < 2; star++) {
        double *const at = k->offset + 2 * star;
        const double u = at[0] / (1 + k->anisotropy), v = (at[1] - k->shear * u) / (1 - k->anisotropy);
        at[0] = (1 + anisotropy) * u;
        at[1] = shear * u + (1 - anisotropy) * v;
    }
    k->anisotropy = anisotropy;
    k->shear = shear;
}
static void change_anisotropy(keys *k, double h) {
    deform(k, k->anisotropy + h, k->shear);
}
static void change_shear(keys *k, double h) {
    deform(k, k->anisotropy, k->shear + h);
}

typedef struct {
    const char *name; /* of the parameter, or of those that a number follows */
    double step;
    void (*change)(keys *k, double h);
    size_t sum;       /* else the key's offset in `keys`, */
    int first;        /* of the parameter with this number */
    double tolerance; /* 0 = 1e-6 of the largest pixel */
} row;

static const row kRows[] = {
    {"separation", 0.02, change_separation, 0, 0, 0},
    {"position_angle", 1e-3, change_angle, 0, 0, 0},
    {"shift_x", 0.02, change_shift_x, 0, 0, 0},
    {"shift_y", 0.02, change_shift_y, 0, 0, 0},
    {"roll", 1e-3, change_roll, 0, 0, 0},
    {"flux_a", 0.1, change_flux_a, 0, 0, 0},
    {"flux_b", 0.1, change_flux_b, 0, 0, 0},
    {"background", 1, NULL, offsetof(keys, dark), 0, 0},
    {"scale", 5e-4, change_scale, 0, 0, 0},
    {"anisotropy", 5e-4, change_anisotropy, 0, 0, 0},
    {"shear", 5e-4, change_shear, 0, 0, 0},
    {"focus", 1, NULL, offsetof(keys, zernike[4]), 0, 0},
    {"zernike_", 1, NULL, offsetof(keys, zernike[5]), 5, 0},
    {"mask_rotation", 1e-3, NULL, offsetof(keys, rotation_deg), 0, 1e-3},
    {"mask_shift_x", 1e-6, NULL, offsetof(keys, mask_shift[0]), 0, 1e-3},
    {"mask_shift_y", 1e-6, NULL, offsetof(keys, mask_shift[1]), 0, 1e-3},
    {"jitter_xx", 2e-3, NULL, offsetof(keys, jitter[0]), 0, 0},
    {"jitter_yy", 2e-3, NULL, offsetof(keys, jitter[1]), 0, 0},
    {"jitter_xy", 2e-3, NULL, offsetof(keys, jitter[2]), 0, 0},
    {"temperature_a", 10, NULL, offsetof(keys, kelvin[0]), 0, 0},
    {"temperature_b", 10, NULL, offsetof(keys, kelvin[1]), 0, 0},
    {"spectrum_a_", 0.01, NULL, offsetof(keys, modes[0]), 1, 0},
    {"spectrum_b_", 0.01, NULL, offsetof(keys, modes[1]), 1, 0},
    {"wavelength", 0.2, NULL, offsetof(keys, longer_nm), 0, 0},
    {"smear", 0.02, NULL, offsetof(keys, smear), 0, 0},
    {"diffusion", 2e-3, NULL, offsetof(keys, diffusion), 0, 0},
    {"transfer_smear", 1e-4, NULL, offsetof(keys, transfer), 0, 0},
    {"brighter_fatter", 1e-9, NULL, offsetof(keys, fatter), 0, 0},
    {"interpixel_capacitance", 1e-3, NULL, offsetof(keys, coupling), 0, 0},
    {"nonlinearity", 1e-9, NULL, offsetof(keys, curve), 0, 0},
};

static const row *row_of(const char *name) {
    for (size_t i = 0; i < sizeof kRows / sizeof *kRows; i++) {
        const row *const r = &kRows[i];
        const size_t length = strlen(r->name);
        if (r->first == 0 ? strcmp(name, r->name) == 0 : strncmp(name, r->name, length) == 0)
            return r;
    }
    fail_msg("%s: the test has no such parameter", name);
    return NULL;
}

static void changed_image(const keys *base, const char *name, double h, double *image) {
    const row *const r = row_of(name);
    keys k = *base;
    if (r->change != NULL)
        r->change(&k, h);
    else {
        double *const key = (double *)(void *)((char *)&k + r->sum);
        key[r->first == 0 ? 0 : atoi(name + strlen(r->name)) - r->first] += h;
    }
    toliman_sim *const sim = sim_of_keys(&k);
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, SIDE));
    toliman_sim_destroy(sim);
}

static void central_difference(const keys *base, const char *name, double h, double *difference) {
    static double before[PIXELS], after[PIXELS];
    changed_image(base, name, -h, before);
    changed_image(base, name, h, after);
    for (int i = 0; i < PIXELS; i++)
        difference[i] = (after[i] - before[i]) / (2 * h);
}

static void check_derivative(const toliman_sim *sim, const keys *base, const char *name) {
    static double derivative[PIXELS], coarse[PIXELS], fine[PIXELS];
    const row *const r = row_of(name);
    const double tolerance = r->tolerance == 0 ? 1e-6 : r->tolerance;
    const double response = strcmp(name, "background") == 0 ? base->qe : 1; /* dark current is not multiplied by it */
    assert_ok(toliman_sim_get_derivative(sim, name, derivative, SIDE));
    central_difference(base, name, r->step, coarse);
    central_difference(base, name, r->step / 2, fine);
    double most = 0, worst = 0;
    for (int i = 0; i < PIXELS; i++) {
        const double expected = response * (4 * fine[i] - coarse[i]) / 3;
        most = fmax(most, fabs(expected));
        worst = fmax(worst, fabs(derivative[i] - expected));
    }
    if (!(most > 0) || !(worst <= tolerance * most))
        fail_msg("%s: differs by %g of its largest pixel, %g", name, worst / most, most);
}

/* Checks all parameters but the wavelength; only the wavelength where the light is lines or a single one. Of
 * parameters with a number the first two, and every fifteenth (make long: fifth) unless few. */
static void check_all(const keys *base, int few) {
    toliman_sim *const sim = sim_of_keys(base);
    toliman_sim_parameter all[MOST] = {TOLIMAN_SIM_PARAMETER_INIT};
    size_t count = 0;
    assert_ok(toliman_sim_get_parameters(all, MOST, &count));
    for (size_t i = 0; i < count; i++) {
        const toliman_sim_parameter parameter = all[i];
        if (strcmp(parameter.name, "flat") == 0) /* has no derivative */
            continue;
        const row *const r = row_of(parameter.name);
        const int jitter = strncmp(parameter.name, "jitter_", 7) == 0; /* has no smaller covariance than 0 */
        const int smear = strcmp(parameter.name, "smear") == 0;        /* motion_within_an_exposure */
        const int number = r->first > 0 ? atoi(parameter.name + strlen(r->name)) : 0;
        const int later =
            number > r->first + 1 && (few || (number % (in_long() ? 5 : 15) != 0 && number != LAST_ZERNIKE));
        if ((strcmp(parameter.name, "wavelength") == 0) == (base->light != CONTINUOUS) && (base->blurred || !jitter) &&
            !later && !smear)
            check_derivative(sim, base, parameter.name);
    }
    toliman_sim_destroy(sim);
}

/* promise: derivatives-are-exact */
TEST(derivatives_are_those_of_scenes) {
    check_all(&kKeys, 0);
}

TEST(motion_within_an_exposure) {
    const char *const kinds[] = {"linear", "harmonic"}, *const names[] = {"smear", "jitter_xy", "shear", "zernike_7"};
    for (int i = 0; i < 2; i++) {
        keys base = kKeys;
        base.motion = kinds[i];
        base.smear = i == 0 ? 0.5 : 4;
        toliman_sim *const sim = sim_of_keys(&base);
        for (int j = 0; j < 4; j++)
            check_derivative(sim, &base, names[j]);
        toliman_sim_destroy(sim);
    }
}

TEST(without_jitter) {
    keys base = kKeys;
    base.blurred = 0;
    base.qe = 0.8;
    check_all(&base, 1);
}

TEST(wavelengths_increase) {
    const light lights[] = {LINES, SINGLE};
    for (int i = 0; i < 4; i++) {
        keys base = kKeys;
        base.light = lights[i % 2];
        base.dispersed = i / 2;
        check_all(&base, 0);
    }
}

/* Of the window around an order of a grating, whose place on the detector does not depend on the light. */
TEST(in_a_sidelobe) {
    keys base = kKeys;
    base.dispersed = 1;
    check_all(&base, 1);
}

TEST(parameters_have_names) {
    toliman_sim_parameter all[MOST] = {TOLIMAN_SIM_PARAMETER_INIT};
    size_t count = 0;
    assert_asks(toliman_sim_get_parameters(NULL, 0, &count));
    assert_true(count > 70 && count < MOST);
    assert_ok(toliman_sim_get_parameters(all, MOST, &count));
    for (size_t i = 0; i < count; i++) {
        const toliman_sim_parameter parameter = all[i];
        for (size_t j = 0; j < i; j++)
            assert_string_not_equal(parameter.name, all[j].name);
        if (strcmp(parameter.name, "zernike_7") == 0) {
            assert_string_equal(parameter.unit, "nm");
            assert_int_equal(parameter.scope, TOLIMAN_SIM_SCOPE_INSTRUMENT);
        }
        if (strcmp(parameter.name, "flux_b") == 0) {
            assert_string_equal(parameter.unit, "");
            assert_int_equal(parameter.scope, TOLIMAN_SIM_SCOPE_FRAME);
        }
    }
    assert_refused(toliman_sim_get_parameters(all, count - 1, &count), TOLIMAN_E_CAPACITY, "capacity");
    assert_invalid(toliman_sim_get_parameters(NULL, 1, &count), "parameters");
}

TEST(refusals) {
    char *const lines = replaced(kBinaryScene, "'kind': 'blackbody', 'temperature_k': 5260",
                                 "'kind': 'lines', 'wavelength_nm': [560, 570], 'weight': [1, 2]");
    const struct {
        const char *scene;
        int32_t engine;
        const char *name;
    } cases[] = {
        {kSingleScene, 0, "flux_b"},
        {kSingleScene, 0, "position_angle"},
        {kSingleScene, 0, "temperature_b"},
        {kSingleScene, 0, "spectrum_b_3"},
        {kSingleScene, 0, "temperature_a"}, /* a single wavelength */
        {kBinaryScene, 0, "mask_shift_x"},  /* edges that are not 'area' */
        {lines, 0, "temperature_b"},
        {kSingleScene, 0, "smear"},
        {kSingleScene, TOLIMAN_SIM_ENGINE_PADDED_FFT, "zernike_5"},
        {kSingleScene, TOLIMAN_SIM_ENGINE_PADDED_FFT, "shear"},
        {kSingleScene, TOLIMAN_SIM_ENGINE_PADDED_FFT, "jitter_xx"},
        {kSingleScene, TOLIMAN_SIM_ENGINE_PADDED_FFT, "wavelength"},
    };
    static double image[64 * 64] = {7};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
        options.engine = cases[i].engine;
        toliman_sim *sim = NULL;
        assert_ok(toliman_sim_create_json(cases[i].scene, strlen(cases[i].scene), NULL, &options, &sim));
        assert_refused(toliman_sim_get_derivative(sim, cases[i].name, image, 64), TOLIMAN_E_UNSUPPORTED, "");
        assert_true(image[0] == 7);
        toliman_sim_destroy(sim);
    }
    free(lines);
}

TEST(wrong_arguments) {
    double image[32 * 40];
    toliman_sim *const sim = sim_of(kSingleScene);
    const struct {
        const toliman_sim *sim;
        const char *name;
        double *image;
        size_t stride;
        const char *field;
    } cases[] = {{NULL, "focus", image, 32, "sim"},     {sim, NULL, image, 32, "name"},
                 {sim, "focus", NULL, 32, "image"},     {sim, "focus", image, 31, "stride"},
                 {sim, "zernike_4", image, 32, "name"}, {sim, "", image, 32, "name"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_invalid(toliman_sim_get_derivative(cases[i].sim, cases[i].name, cases[i].image, cases[i].stride),
                       cases[i].field);
    double plain[32 * 32], *const focus = image_of(sim, TOLIMAN_SIM_IMAGE_FOCUS);
    for (int i = 0; i < 32 * 40; i++)
        image[i] = -1;
    assert_ok(toliman_sim_get_derivative(sim, "focus", image, 40));
    assert_ok(toliman_sim_get_derivative(sim, "focus", plain, 32));
    assert_memory_equal(plain, focus, sizeof plain);
    for (int i = 0; i < 32 * 40; i++)
        assert_true(image[i] == (i % 40 < 32 ? plain[i / 40 * 32 + i % 40] : -1));
    free(focus), toliman_sim_destroy(sim);
}

RUN_TESTS(NULL, NULL)
