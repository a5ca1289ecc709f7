/* libtoliman, error budget: which unknown parameters of the forward model limit the separation, and by how much.
 *
 * Data flow (functions toliman_sim_...)
 *
 *   toliman_sim -> get_budget               bound with chosen parameters free; displacement due to an Earth
 *                  get_budget_steps         bounds with more and more parameters free
 *                  get_budget_rows          each parameter: its bias, or what the fit leaves of it; correlations
 *
 * Estimate
 *
 *   A budget describes the weighted least-squares estimate of the separation from one frame, with some parameters free:
 *   fitted together with it. The standard deviation of this estimate is the Cramer-Rao bound
 *   (promise: budgets-match-fisher-matrix). An error of a parameter that is not free is a bias of the separation, to
 *   first order. A free parameter causes no bias to first order; its second-order term remains.
 *
 * Parameters
 *
 *   Names are those of preprocess.project in a scene: flux_a, shift_x, zernike_7, temperature_a, ... Effects are per
 *   toliman_sim_budget_row.unit.
 */
#ifndef TOLIMAN_BUDGET_H
#define TOLIMAN_BUDGET_H

#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Options of a budget. */
typedef struct toliman_sim_budget_options {
    uint32_t struct_size;
    uint32_t reserved;
    const char *free_names; /* list of the free parameters; "" = none; NULL = those of preprocess.project */
    int64_t frames;         /* frames that share the parameters of the instrument, in [1, 2^50]; 0 = 1 */
    double earth_px;        /* displacement due to an Earth, in (0, 100] px; 0 = that of the scene */
} toliman_sim_budget_options;
#define TOLIMAN_SIM_BUDGET_OPTIONS_INIT TOLIMAN_INIT(toliman_sim_budget_options)

/* Summary of a budget. */
typedef struct toliman_sim_budget {
    uint32_t struct_size;   /* in: sizeof(toliman_sim_budget) */
    uint32_t reserved;      /* 0 */
    double crb_px;          /* standard deviation of the separation in one frame, px, all free parameters fitted to this
                               frame alone; infinite if they leave nothing of the signal */
    double crb_shared_px;   /* the same for each of `frames` identical frames that share the parameters of the
                               instrument, while those of a frame are free in each */
    double uas_per_px;      /* angle of a displacement of 1 px, microarcsec */
    double earth_px;        /* displacement due to an Earth, px; NaN if not known */
    const char *earth_from; /* where it comes from: "the options", "the planet of the scene", "an Earth at 1.23 au of
                               star A" (0.71 au of B; from the star's mass_sun and the distance_pc), "the amplitude of
                               the signal" or "not known". Static text */
    size_t free_count;      /* free parameters */
    size_t steps;           /* steps of toliman_sim_get_budget_steps; later versions may append some */
    size_t rows;            /* rows of toliman_sim_get_budget_rows */
} toliman_sim_budget;
#define TOLIMAN_SIM_BUDGET_INIT TOLIMAN_INIT(toliman_sim_budget)

/* Writes the summary of a budget to *out, whose struct_size must be set. options may be NULL. The first call for a
 * parameter computes its derivative. Errors: TOLIMAN_E_ARGUMENT for an unknown name or one that is given twice,
 * TOLIMAN_E_UNSUPPORTED if the scene has no derivative by a parameter (a single star, a spectrum of lines, the engine
 * PADDED_FFT), TOLIMAN_E_SCENE if the scene's signal changes no pixel. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_budget(const toliman_sim *sim,
                                                                     const toliman_sim_budget_options *options,
                                                                     toliman_sim_budget *out) TOLIMAN_NOEXCEPT;

/* Bounds with one set of free parameters. */
typedef struct toliman_sim_budget_step {
    uint32_t struct_size; /* in, in the first element: sizeof(toliman_sim_budget_step) */
    uint32_t reserved;    /* 0 */
    const char *name;     /* "alone", "fluxes, shift", "eight" (with roll, scale, focus and background), "eight +
                             jitter", "eight + Noll 5-10", "eight + temperatures", "all of these", "all + wavelength".
                             Static text */
    double crb_px;        /* as in toliman_sim_budget, with this set free */
    double crb_shared_px;
} toliman_sim_budget_step;
#define TOLIMAN_SIM_BUDGET_STEP_INIT TOLIMAN_INIT(toliman_sim_budget_step)

/* Writes the steps to steps[capacity] and their number to *count. Only the member `frames` of options, which may be
 * NULL, is used. A step omits parameters of which the scene has no derivative. TOLIMAN_E_CAPACITY if capacity is too
 * small. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_budget_steps(const toliman_sim *sim,
                                                                           const toliman_sim_budget_options *options,
                                                                           toliman_sim_budget_step *steps,
                                                                           size_t capacity,
                                                                           size_t *count) TOLIMAN_NOEXCEPT;

/* One parameter of a budget. Amounts are absolute values; NaN where they are not known and infinite where the parameter
 * has no effect. */
typedef struct toliman_sim_budget_row {
    uint32_t struct_size;    /* in, in the first element: sizeof(toliman_sim_budget_row) */
    int32_t is_free;         /* 1 if the parameter is free, else 0 */
    const char *name, *unit; /* unit: "px", "nm", "K", ..., "" for a ratio. Static text */
    double bias_px;          /* not free: error of the separation per unit of the parameter; NaN if free */
    double curvature_px;     /* free: error of the separation per unit squared that the fit leaves; 0 if frames depend
                                linearly on the parameter, NaN if it is not known: jitter, motions of the mask, the
                                engine PADDED_FFT, and parameters that are not free */
    double earth_amount;     /* amount of the parameter that has the effect of an Earth */
    double tenth_crb_amount; /* amount that has the effect of a tenth of crb_px */
    double deviation;        /* free: standard deviation of the parameter in the fit; NaN if it depends on others */
    double correlation;      /* free: correlation with the separation, -1 to 1; NaN if it depends on others */
} toliman_sim_budget_row;
#define TOLIMAN_SIM_BUDGET_ROW_INIT TOLIMAN_INIT(toliman_sim_budget_row)

/* Writes the rows to rows[capacity] and their number to *count: the free parameters in the order of their names, then
 * every other parameter of which the scene has a derivative. Arguments and errors as toliman_sim_get_budget;
 * TOLIMAN_E_CAPACITY if capacity is too small. Propagates the frame twice for each free parameter that is not linear.
 *   correlations  [side][side], or NULL: those of the estimates of the separation and the free parameters, in this
 *                 order. NaN for a parameter that depends on those before it, and for all if they leave nothing of the
 *                 signal
 *   side          toliman_sim_budget.free_count + 1, else TOLIMAN_E_ARGUMENT; not used without correlations */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_budget_rows(const toliman_sim *sim,
                                                                          const toliman_sim_budget_options *options,
                                                                          double *correlations, size_t side,
                                                                          toliman_sim_budget_row *rows, size_t capacity,
                                                                          size_t *count) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
