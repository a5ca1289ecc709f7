/* libtoliman, periodogram with correlated noise: power and false alarm probability of a series whose neighbouring
 * errors are correlated.
 *
 * Data flow (toliman_measure_...)
 *
 *   toliman_measure -> query_noise -> power[nf], toliman_period_noise
 *                      query_noise_bootstrap <- rho; -> log10(1 - power) of the highest peak of each resampling
 *
 * Model        y = c_0 + sum over j of c_j b_j + a cos(2 pi f t) + b sin(2 pi f t) + noise, with the k functions b_j of
 *              the series (measure.h), fitted at each frequency. Priors as in period_nuisance.h; sigmas are marginal
 *              standard deviations.
 * Noise        Covariance s_i s_j exp(-|t_i - t_j|/tau), s_i = sigma_i, or 1 without sigmas: a first-order
 *              autoregression, AR(1), of fitted scale, without a white component. rho: correlation over one step, the
 *              median step between different times; tau = -step/ln rho.
 * Power        1 - R/R_H, residual sums of squares R of the model and R_H of mean and functions, with the inverse of
 *              the covariance as metric.
 * Correlation  Restricted maximum likelihood, in [0, 0.999], without a sinusoid unless it is significant (FAP below
 *              1e-4 to 1e-8).
 * FAP          Baluev's bound with n - K degrees of freedom, K as in period_nuisance.h, for one query. Of series of
 *              AR(1) noise, about 1 % have a FAP of 0.01 (promise: correlated-alarms-are-rare); if white noise is
 *              assumed, 52 % have, for rho = 0.5 and n = 200. 1/f noise is not AR(1): up to 28 % have (benchmarks.md);
 *              log10_p_white is then below -3.
 * Samples      In any order, at different times.
 * Accuracy     The power with correlated noise has an error of 1e-10 (promise: noise-power-has-ten-digits), if the
 *              functions leave 1e-8 of the squares of cosine and sine. */
#ifndef TOLIMAN_PERIOD_NOISE_H
#define TOLIMAN_PERIOD_NOISE_H

#include <toliman/measure.h>
#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Flag: rho = 0 for power and FAP; whiteness is tested as without it. */
#define TOLIMAN_PERIOD_WHITE_NOISE 1024u

/* Options of the noise. */
typedef struct toliman_period_noise_options {
    uint32_t struct_size;
    uint32_t flags; /* TOLIMAN_PERIOD_WHITE_NOISE */
    toliman_progress_fn progress;
    void *progress_data;
} toliman_period_noise_options;
#define TOLIMAN_PERIOD_NOISE_OPTIONS_INIT TOLIMAN_INIT(toliman_period_noise_options)

/* Fitted noise and highest peak of a series. Standard errors are scaled by the residual; +infinity if not
 * determined. */
typedef struct toliman_period_noise {
    uint32_t struct_size;
    uint32_t flags; /* TOLIMAN_PERIOD_AT_EDGE, _COARSE, _ABOVE_NYQUIST, _LONG */
    double rho;
    double rho_error; /* asymptotic */
    double tau;       /* units of t; 0 if rho is 0 */
    double step;
    double log10_p_white;  /* log10 of the probability that white noise has this likelihood ratio of AR(1) to white
                              noise, or more */
    int64_t index;         /* grid frequency of highest power P */
    double power;          /* P */
    double log10_residual; /* log10(1 - P), at least -4900; meaningful down to -28 */
    double log10_fap;
    /* Least-squares fit within one step of the grid: y = offset + amplitude sin(2 pi frequency (t - time_reference) +
     * phase) + functions */
    double frequency;
    double frequency_error;
    double period;
    double period_error;
    double amplitude;
    double amplitude_error;
    double phase; /* rad */
    double phase_error;
    double offset; /* c_0 */
    double offset_error;
    double time_reference; /* sample's time nearest to the weighted mean */
    uint32_t rank;         /* 2; 1 or 0 if the functions or each other leave nothing of cosine or sine */
    uint32_t reserved;
} toliman_period_noise;
#define TOLIMAN_PERIOD_NOISE_INIT TOLIMAN_INIT(toliman_period_noise)

/* Fits the noise of a series, then computes the power at frequencies f0 + i df, i < nf.
 *   power         [nf]; may be NULL
 *   coefficients  [k], c_1 ... c_k at out->frequency, units of y per unit of the function; may be NULL
 *   errors        [k], their standard errors; may be NULL
 * One thread: 0.1 s for n = 836, k = 0 and nf = 5475, 0.2 s for k = 5.
 * Errors:
 *   - TOLIMAN_E_ARGUMENT two samples at one time; a function without a prior that is a combination of the mean and
 *     those before it
 *   - TOLIMAN_E_STATE n < k + 6; mean and functions describe all values
 *   - TOLIMAN_E_RANGE |t| > 1e100, |y| > 1e300, phases above 2^50 cycles */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_query_noise(
    const toliman_measure *series, double f0, double df, int64_t nf, const toliman_period_noise_options *options,
    double *power, double *coefficients, double *errors, toliman_period_noise *out) TOLIMAN_NOEXCEPT;

/* Options of a bootstrap. */
typedef struct toliman_period_noise_bootstrap_options {
    uint32_t struct_size;
    uint32_t threads;
    uint64_t seed;
    uint64_t block; /* samples per block, at most n; 0 = n^(1/3), rounded up */
    toliman_progress_fn progress;
    void *progress_data;
} toliman_period_noise_bootstrap_options;
#define TOLIMAN_PERIOD_NOISE_BOOTSTRAP_OPTIONS_INIT TOLIMAN_INIT(toliman_period_noise_bootstrap_options)

/* Moving-block bootstrap: as toliman_period_query_bootstrap, but a resampling joins random blocks of consecutive
 * residuals, whitened with rho, at the same times and sigmas.
 *   rho  correlation over one step, in [0, 0.999]: out->rho of toliman_measure_query_noise
 * With rho = 0, blocks must be longer than the correlation and the period. Each resampling takes the time of one
 * periodogram.
 * Errors: as toliman_measure_query_noise; TOLIMAN_E_RANGE rho or block. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_query_noise_bootstrap(
    const toliman_measure *series, double f0, double df, int64_t nf, double rho,
    const toliman_period_noise_bootstrap_options *options, size_t count, double *log10_residuals) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
