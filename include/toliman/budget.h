/* libtoliman, error budget: which unknown parameters of the forward model limit the separation, and by how much.
 *
 * Data flow (toliman_sim_...)
 *
 *   toliman_sim -> get_budget               bound with chosen parameters free; displacement due to an Earth
 *                  get_budget_steps         bounds with more and more parameters free
 *                  get_budget_rows          each parameter: its bias, or what the fit leaves of it; correlations
 *
 * A budget is that of a least-squares estimate of the separation from one frame. Free parameters (sim_derivative.h) are
 * fitted together with the separation. Its standard deviation is the Cramer-Rao bound
 * (promise: budgets-match-fisher-matrix). How to read it: budget.md. */
#ifndef TOLIMAN_BUDGET_H
#define TOLIMAN_BUDGET_H

#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Rows: of the Zernike polynomials that are not free only those up to Noll 11, of such spectral modes those up to 2.
 * The others take most of the time. */
#define TOLIMAN_SIM_BUDGET_LOW_ORDERS 1u

/* Options of a budget. */
typedef struct toliman_sim_budget_options {
    uint32_t struct_size;
    uint32_t flags;         /* TOLIMAN_SIM_BUDGET_LOW_ORDERS */
    const char *free_names; /* the free parameters; "" = none; NULL = preprocess.project */
    int64_t frames;         /* that share the parameters of the instrument, in [1, 2^50]; 0 = 1 */
    double earth_px;        /* displacement due to an Earth, in (0, 100] px; 0 = that of the scene */
} toliman_sim_budget_options;
#define TOLIMAN_SIM_BUDGET_OPTIONS_INIT TOLIMAN_INIT(toliman_sim_budget_options)

/* Summary of a budget. */
typedef struct toliman_sim_budget {
    uint32_t struct_size;
    uint32_t reserved;
    double crb_px;        /* of the separation in one frame; infinite if the free parameters leave nothing of the
                             signal */
    double crb_shared_px; /* likewise for each of `frames` identical frames that share the parameters of the
                             instrument */
    double uas_per_px;
    double earth_px;        /* NaN if not known */
    const char *earth_from; /* its source, such as "an Earth at 1.23 au of star A" (0.71 au of B), "not known" */
    size_t free_count;
    size_t steps;
    size_t rows;
} toliman_sim_budget;
#define TOLIMAN_SIM_BUDGET_INIT TOLIMAN_INIT(toliman_sim_budget)

/* Gets the summary of a budget. Errors: TOLIMAN_E_UNSUPPORTED for a name without derivative
 * (toliman_sim_get_derivative); TOLIMAN_E_SCENE if the signal changes no pixel. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_budget(const toliman_sim *sim,
                                                                     const toliman_sim_budget_options *options,
                                                                     toliman_sim_budget *out) TOLIMAN_NOEXCEPT;

/* Bounds with one set of free parameters. */
typedef struct toliman_sim_budget_step {
    uint32_t struct_size;
    uint32_t reserved;
    const char *name; /* "alone", "fluxes, shift", "eight" (with roll, scale, focus, background), "eight + jitter",
                         ... */
    double crb_px;    /* as in toliman_sim_budget */
    double crb_shared_px;
} toliman_sim_budget_step;
#define TOLIMAN_SIM_BUDGET_STEP_INIT TOLIMAN_INIT(toliman_sim_budget_step)

/* Writes the steps. Of the options, only `frames` counts. A step omits parameters without derivative. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_budget_steps(const toliman_sim *sim,
                                                                           const toliman_sim_budget_options *options,
                                                                           toliman_sim_budget_step *steps,
                                                                           size_t capacity,
                                                                           size_t *count) TOLIMAN_NOEXCEPT;

/* One parameter of a budget. Amounts are absolute values, infinite for a parameter without effect. A member is NaN if
 * it does not apply or is not known, or if the parameter is a combination of others. */
typedef struct toliman_sim_budget_row {
    uint32_t struct_size;
    int32_t is_free;         /* 1: free */
    const char *name, *unit; /* "px", "nm", "K", ..., "" for a ratio */
    double bias_px;          /* not free: error of the separation per unit */
    double curvature_px;     /* free: error of the separation per unit squared; unknown for jitter, motions of the
                                mask, the detector and PADDED_FFT */
    double earth_amount;     /* whose effect is that of an Earth */
    double tenth_crb_amount; /* whose effect is a tenth of crb_px */
    double deviation;        /* free: standard deviation in the fit */
    double correlation;      /* free: with the separation, -1 to 1 */
} toliman_sim_budget_row;
#define TOLIMAN_SIM_BUDGET_ROW_INIT TOLIMAN_INIT(toliman_sim_budget_row)

/* Writes the rows: the free parameters in the order of their names, then every other one with a derivative, or only
 * those of TOLIMAN_SIM_BUDGET_LOW_ORDERS. The row flat is the response of the pixels: its bias_px is the standard
 * deviation due to independent errors of all. Propagates the frame twice per free parameter that is not linear. Errors
 * as toliman_sim_get_budget.
 *   correlations  [side][side], or NULL: of the separation and the free parameters; NaN for one that depends on those
 *                 before it
 *   side          toliman_sim_budget.free_count + 1; not used without correlations */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_budget_rows(const toliman_sim *sim,
                                                                          const toliman_sim_budget_options *options,
                                                                          double *correlations, size_t side,
                                                                          toliman_sim_budget_row *rows, size_t capacity,
                                                                          size_t *count) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
