/* Tests error budgets against the Fisher matrix of the derivative images, in long double. */
#include <toliman/budget.h>

#include "invert.h"
#include "scene_text.h"

enum { PIXELS = 64 * 64, FREE = 4, ROWS = 100 };

static const char kFree[] = "flux_a,scale  shift_x shift_y";
/* The separation, then the free parameters; scale is of the instrument, the others are of a frame. */
static const int32_t kKinds[FREE + 1] = {TOLIMAN_SIM_IMAGE_SEPARATION, TOLIMAN_SIM_IMAGE_STAR_A,
                                         TOLIMAN_SIM_IMAGE_SCALE, TOLIMAN_SIM_IMAGE_SHIFT_X, TOLIMAN_SIM_IMAGE_SHIFT_Y};

static long double weighted(const double *a, const double *b, const double *variance) {
    long double sum = 0;
    for (size_t i = 0; i < PIXELS; i++)
        sum += (long double)a[i] * b[i] / variance[i];
    return sum;
}

typedef struct {
    toliman_sim *sim;
    double *images[FREE + 1], *variance;
    long double covariance[(FREE + 1) * (FREE + 1)];
} fit;

static fit fit_of_scene(void) {
    fit f = {.sim = sim_of(kBinaryScene)};
    f.variance = image_of(f.sim, TOLIMAN_SIM_IMAGE_VARIANCE);
    for (int i = 0; i <= FREE; i++)
        f.images[i] = image_of(f.sim, kKinds[i]);
    for (int i = 0; i <= FREE; i++)
        for (int j = 0; j <= FREE; j++)
            f.covariance[i * (FREE + 1) + j] = weighted(f.images[i], f.images[j], f.variance);
    invert(FREE + 1, f.covariance);
    return f;
}

static void free_fit(fit *f) {
    for (int i = 0; i <= FREE; i++)
        free(f->images[i]);
    free(f->variance), toliman_sim_destroy(f->sim);
}

static toliman_sim_budget_options with_names(const char *names) {
    toliman_sim_budget_options options = {.struct_size = sizeof options, .free_names = names};
    return options;
}

static toliman_sim_budget budget_of(const toliman_sim *sim, const toliman_sim_budget_options *options) {
    toliman_sim_budget budget = TOLIMAN_SIM_BUDGET_INIT;
    assert_ok(toliman_sim_get_budget(sim, options, &budget));
    return budget;
}

/* The rows of a budget; returns their number. */
static size_t rows_of(const toliman_sim *sim, const toliman_sim_budget_options *options, toliman_sim_budget_row *rows) {
    size_t count = 0;
    rows[0].struct_size = sizeof *rows;
    assert_ok(toliman_sim_get_budget_rows(sim, options, NULL, 0, rows, ROWS, &count));
    return count;
}

static const toliman_sim_budget_row *row_of(const toliman_sim_budget_row *rows, size_t count, const char *name) {
    for (size_t i = 0; i < count; i++)
        if (strcmp(rows[i].name, name) == 0)
            return &rows[i];
    return NULL;
}

/* promise: budgets-match-fisher-matrix */
TEST(fit_matches_the_fisher_matrix) {
    fit f = fit_of_scene();
    const toliman_sim_budget_options options = with_names(kFree);
    const toliman_sim_budget budget = budget_of(f.sim, &options);
    assert_int_equal(budget.free_count, FREE);
    assert_close(budget.crb_px, (double)sqrtl(f.covariance[0]), 1e-9, 0);
    assert_close(budget.crb_shared_px, budget.crb_px, 0, 0); /* one frame */
    toliman_sim_budget_row rows[ROWS];
    const size_t count = rows_of(f.sim, &options, rows);
    assert_int_equal(count, budget.rows);
    double correlations[(FREE + 1) * (FREE + 1)];
    toliman_sim_budget_row again[ROWS] = {TOLIMAN_SIM_BUDGET_ROW_INIT};
    size_t same = 0;
    assert_ok(toliman_sim_get_budget_rows(f.sim, &options, correlations, FREE + 1, again, ROWS, &same));
    assert_int_equal(same, count);
    const char *const names[FREE] = {"flux_a", "scale", "shift_x", "shift_y"};
    for (int i = 0; i <= FREE; i++) {
        const long double own = f.covariance[i * (FREE + 2)];
        for (int j = 0; j <= FREE; j++)
            assert_close(correlations[i * (FREE + 1) + j],
                         (double)(f.covariance[i * (FREE + 1) + j] / sqrtl(own * f.covariance[j * (FREE + 2)])), 0,
                         1e-9);
        if (i == 0)
            continue;
        assert_string_equal(rows[i - 1].name, names[i - 1]);
        assert_int_equal(rows[i - 1].is_free, 1);
        assert_close(rows[i - 1].deviation, (double)sqrtl(own), 1e-9, 0);
        assert_close(rows[i - 1].correlation, correlations[i], 0, 0);
        assert_true(isnan(rows[i - 1].bias_px));
    }
    free_fit(&f);
}

/* A residual of one unit of a parameter that is not free, in the normal equations. */
TEST(bias_is_that_of_the_normal_equations) {
    fit f = fit_of_scene();
    const toliman_sim_budget_options options = with_names(kFree);
    const double crb_px = budget_of(f.sim, &options).crb_px;
    toliman_sim_budget_row rows[ROWS];
    const size_t count = rows_of(f.sim, &options, rows);
    const struct {
        const char *name;
        int32_t kind;
    } fixed[] = {{"flux_b", TOLIMAN_SIM_IMAGE_STAR_B},
                 {"roll", TOLIMAN_SIM_IMAGE_ROLL},
                 {"focus", TOLIMAN_SIM_IMAGE_FOCUS},
                 {"background", TOLIMAN_SIM_IMAGE_BACKGROUND}};
    for (size_t k = 0; k < sizeof fixed / sizeof *fixed; k++) {
        double *const image = image_of(f.sim, fixed[k].kind);
        long double bias = 0;
        for (int i = 0; i <= FREE; i++)
            bias += f.covariance[i] * weighted(f.images[i], image, f.variance);
        const toliman_sim_budget_row *const row = row_of(rows, count, fixed[k].name);
        assert_non_null(row);
        assert_int_equal(row->is_free, 0);
        assert_close(row->bias_px, (double)bias, 1e-7, 0);
        assert_close(row->earth_amount, 1e-3 / fabs(row->bias_px), 1e-12, 0); /* the amplitude of the signal */
        assert_close(row->tenth_crb_amount, 0.1 * crb_px / fabs(row->bias_px), 1e-9, 0);
        free(image);
    }
    free_fit(&f);
}

/* K = 3 frames, each with its own separation, flux and shift, and one scale: the whole Fisher matrix. */
/* promise: budgets-match-fisher-matrix */
TEST(shared_bound_is_that_of_many_frames) {
    enum { FRAMES = 3, OWN = 4, ALL = FRAMES * OWN + 1 };
    fit f = fit_of_scene();
    const int own[OWN] = {0, 1, 3, 4};
    long double fisher[ALL * ALL] = {0};
    const double *all[OWN + 1];
    for (int i = 0; i < OWN; i++)
        all[i] = f.images[own[i]];
    all[OWN] = f.images[2]; /* the scale */
    for (int frame = 0; frame < FRAMES; frame++)
        for (int i = 0; i <= OWN; i++)
            for (int j = 0; j <= OWN; j++) {
                const int row = i < OWN ? frame * OWN + i : ALL - 1, column = j < OWN ? frame * OWN + j : ALL - 1;
                fisher[row * ALL + column] += weighted(all[i], all[j], f.variance);
            }
    invert(ALL, fisher);
    toliman_sim_budget_options options = with_names(kFree);
    options.frames = FRAMES;
    const toliman_sim_budget budget = budget_of(f.sim, &options);
    assert_close(budget.crb_shared_px, (double)sqrtl(fisher[0]), 1e-9, 0);
    assert_true(budget.crb_shared_px < 0.999 * budget.crb_px);
    free_fit(&f);
}

TEST(steps_are_the_bounds_of_the_scene) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    const toliman_sim_bounds bounds = sim_bounds_of(sim);
    toliman_sim_budget_step steps[8] = {TOLIMAN_SIM_BUDGET_STEP_INIT};
    size_t count = 0;
    assert_ok(toliman_sim_get_budget_steps(sim, NULL, steps, 8, &count));
    assert_int_equal(count, 8);
    assert_int_equal(budget_of(sim, NULL).steps, 8);
    assert_close(steps[0].crb_px, bounds.crb_px, 0, 0);
    assert_close(steps[1].crb_px, bounds.crb_flux_shift_px, 0, 0);
    assert_close(steps[2].crb_px, bounds.crb_marginal_px, 0, 0);
    for (size_t i = 3; i < 6; i++)
        assert_true(steps[i].crb_px > steps[2].crb_px && steps[i].crb_px < steps[6].crb_px);
    assert_true(steps[7].crb_px > steps[6].crb_px);
    toliman_sim_destroy(sim);
}

/* Free parameters: linear ones leave nothing, a shift leaves what half the second derivative of the frame makes of it,
 * which is the derivative by the variance of the jitter. */
TEST(curvature_of_a_shift_is_the_derivative_by_jitter) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    const toliman_sim_budget_options options = with_names(kFree);
    toliman_sim_budget_row rows[ROWS];
    const size_t count = rows_of(sim, &options, rows);
    assert_close(row_of(rows, count, "flux_a")->curvature_px, 0, 0, 0);
    assert_true(isinf(row_of(rows, count, "flux_a")->earth_amount));
    const toliman_sim_budget_row *const shift = row_of(rows, count, "shift_y");
    assert_close(shift->curvature_px, row_of(rows, count, "jitter_yy")->bias_px, 1e-4, 0);
    assert_close(shift->earth_amount, sqrt(1e-3 / fabs(shift->curvature_px)), 1e-12, 0);
    toliman_sim_destroy(sim);
}

TEST(earth_is_that_of_options_or_scene) {
    toliman_sim *sim = sim_of(kBinaryScene);
    toliman_sim_budget_options options = with_names("");
    toliman_sim_budget budget = budget_of(sim, &options);
    assert_string_equal(budget.earth_from, "the amplitude of the signal");
    assert_close(budget.earth_px, 1e-3, 0, 0);
    assert_close(budget.uas_per_px, 2e5, 1e-12, 0);
    assert_close(budget.crb_px, sim_bounds_of(sim).crb_px, 0, 0);
    options.earth_px = 2e-6;
    budget = budget_of(sim, &options);
    assert_string_equal(budget.earth_from, "the options");
    assert_close(budget.earth_px, 2e-6, 0, 0);
    toliman_sim_destroy(sim);
    /* 3.0035e-6 solar masses / 0.9092 of them, 0.71 au at 1.3319 pc: 1.761 microarcsec */
    char *scene = replaced(kBinaryScene, "\"temperature_k\": 5260}", "\"temperature_k\": 5260}, \"mass_sun\": 0.9092");
    scene = replaced_again(scene, "\"position_angle_deg\": 30", "\"position_angle_deg\": 30, \"distance_pc\": 1.3319");
    sim = sim_of(scene);
    budget = budget_of(sim, NULL);
    assert_string_equal(budget.earth_from, "an Earth at 0.71 au of star B");
    assert_close(budget.earth_px * budget.uas_per_px, 1.761, 1e-3, 0);
    toliman_sim_destroy(sim);
    scene = replaced_again(scene, "\"sinusoid\", \"star\": \"B\", \"amplitude_px\": 1e-3, \"period_days\": 40",
                           "\"planet\", \"star\": \"B\", \"mass_earth\": 2, \"semi_major_au\": 0.71");
    sim = sim_of(scene);
    budget = budget_of(sim, NULL);
    assert_string_equal(budget.earth_from, "the planet of the scene");
    assert_close(budget.earth_px * budget.uas_per_px, 2 * 1.761, 1e-3, 0);
    toliman_sim_destroy(sim), free(scene);
}

/* The position of a single star cannot be distinguished from a common shift, and it has no star B. */
TEST(a_single_star_is_degenerate) {
    toliman_sim *const sim = sim_of(kSingleScene);
    toliman_sim_budget_options options = with_names("shift_x");
    toliman_sim_budget budget = budget_of(sim, &options);
    assert_true(isinf(budget.crb_px) && isinf(budget.crb_shared_px));
    assert_true(isnan(budget.earth_px));
    assert_string_equal(budget.earth_from, "not known");
    toliman_sim_budget_row rows[ROWS];
    const size_t count = rows_of(sim, &options, rows);
    assert_int_equal(count, budget.rows);
    assert_true(isnan(rows[1].bias_px));
    assert_null(row_of(rows, count, "flux_b"));
    options.free_names = "flux_b";
    assert_refused(toliman_sim_get_budget(sim, &options, &budget), TOLIMAN_E_UNSUPPORTED, "");
    toliman_sim_destroy(sim);
}

/* The padded FFT has its own pupil, so that a changed one has no effect. */
TEST(second_order_is_not_known_for_the_padded_fft) {
    const int32_t engines[2] = {TOLIMAN_SIM_ENGINE_MATRIX_DFT, TOLIMAN_SIM_ENGINE_PADDED_FFT};
    for (int i = 0; i < 2; i++) {
        toliman_sim_options engine = {.struct_size = sizeof engine, .engine = engines[i]};
        toliman_sim *sim = NULL;
        assert_ok(toliman_sim_create_json(kSingleScene, strlen(kSingleScene), NULL, &engine, &sim));
        const toliman_sim_budget_options options = with_names("focus");
        toliman_sim_budget_row rows[ROWS];
        rows_of(sim, &options, rows);
        assert_int_equal(isnan(rows[0].curvature_px) != 0, i);
        assert_int_equal(isnan(rows[0].earth_amount) != 0, 1); /* the scene has no signal */
        toliman_sim_destroy(sim);
    }
}

/* The same rows without modes of high order that are not free. */
TEST(low_orders_omit_rows) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    toliman_sim_budget_options options = with_names("zernike_20, flux_a");
    static toliman_sim_budget_row all[ROWS], low[ROWS];
    const size_t count = rows_of(sim, &options, all);
    options.flags = TOLIMAN_SIM_BUDGET_LOW_ORDERS;
    const size_t least = rows_of(sim, &options, low);
    assert_int_equal(budget_of(sim, &options).rows, least);
    assert_int_equal(count - least, 25 - 1 + 2 * 9); /* Noll 12 to 36 but for 20, spectral modes 3 to 11 */
    for (size_t i = 0; i < least; i++) {
        const toliman_sim_budget_row *const same = row_of(all, count, low[i].name);
        assert_non_null(same);
        assert_memory_equal(&low[i], same, sizeof low[i]);
    }
    assert_null(row_of(low, least, "zernike_12"));
    assert_null(row_of(low, least, "spectrum_b_3"));
    assert_non_null(row_of(low, least, "zernike_20"));
    assert_non_null(row_of(low, least, "spectrum_b_2"));
    toliman_sim_destroy(sim);
}

/* Numbers that are not finite: bind/test_options. */
TEST(bad_arguments_are_refused) {
    toliman_sim *const sim = sim_of(kBinaryScene);
    toliman_sim_budget budget = TOLIMAN_SIM_BUDGET_INIT;
    static const char *const lists[] = {"shift_x zernike_37", "separation", "roll, roll"};
    for (size_t i = 0; i < 3; i++) {
        const toliman_sim_budget_options options = with_names(lists[i]);
        assert_invalid(toliman_sim_get_budget(sim, &options, &budget), "options->free_names");
    }
    const toliman_sim_budget_options negative = {.struct_size = sizeof negative, .frames = -1};
    assert_invalid(toliman_sim_get_budget(sim, &negative, &budget), "options->frames");
    toliman_sim_budget_row row = TOLIMAN_SIM_BUDGET_ROW_INIT;
    size_t count = 7;
    double correlations[4];
    assert_invalid(toliman_sim_get_budget_rows(sim, NULL, correlations, 2, &row, 1, &count), "side");
    assert_invalid(toliman_sim_get_budget_rows(sim, NULL, NULL, 0, NULL, 2, &count), "rows");
    assert_int_equal(count, 7);
    assert_asks(toliman_sim_get_budget_rows(sim, NULL, NULL, 0, NULL, 0, &count));
    const size_t needed = count;
    row.name = "as before";
    assert_refused(toliman_sim_get_budget_rows(sim, NULL, NULL, 0, &row, 1, &count), TOLIMAN_E_CAPACITY, "capacity");
    assert_int_equal(count, needed);
    assert_string_equal(row.name, "as before");
    assert_asks(toliman_sim_get_budget_steps(sim, NULL, NULL, 0, &count));
    toliman_sim_destroy(sim);
}

RUN_TESTS(NULL, NULL)
