/* libtoliman, periodogram with correlated noise: the power of a whole series, and its false alarm probability, when
 * errors of neighbouring samples are correlated.
 *
 * Data flow (functions toliman_measure_...)
 *
 *   toliman_measure -> query_noise -> power[nf], toliman_period_noise: correlation, whiteness, highest peak
 *     (measure.h)        | rho
 *                        v
 *                      query_noise_bootstrap -> log10(1 - power) of the highest peak of each resampling
 *
 * Model        y = c_0 + sum over j of c_j b_j + a cos(2 pi f t) + b sin(2 pi f t) + noise, with the k functions b_j
 *              of the series. All coefficients are fitted together at each frequency.
 * Noise        Covariance s_i s_j exp(-|t_i - t_j|/tau), with s_i = sigma_i, or 1 without sigmas: a first-order
 *              autoregression, AR(1), between irregular times. rho is its correlation over one step, the median step
 *              between different times; tau = -step/ln rho. The scale of the noise is fitted.
 * Power        1 - R/R_H, with the residual sum of squares R of the model and R_H of mean and functions alone, both
 *              with the inverse of the covariance as metric, in [0, 1].
 * Correlation  Restricted maximum likelihood in [0, 0.999]. While the likelihood ratio of a sinusoid has a FAP above
 *              1e-4, rho is fitted without a sinusoid; below 1e-8, with the strongest one, so that a strong signal is
 *              not taken for noise; between, it is a weighted mean of both. A signal in white noise loses 3 % of its
 *              log10 FAP on average, 10 to 12 % in one series of 20.
 * FAP          Baluev's bound with n - K degrees of freedom, where K counts the mean and the functions without a
 *              prior. It holds for one query of a complete series. Of series of AR(1) noise, about 1 % have a FAP of
 *              0.01 (promise: correlated-alarms-are-rare):
 *                rho                              0       0.2     0.5     0.9
 *                n = 200, regular                 0.6 %   0.6 %   0.7 %   0.8 %
 *                n = 847 in 3 years, with gaps    0.9 %   0.8 %   0.9 %   1.0 %
 *                n = 200, white noise assumed     0.8 %   4.7 %   52 %    99.9 %
 *              1/f noise is not AR(1): 2.1 % (n = 200) and 28 % (n = 847) of its series have a FAP of 0.01, at the
 *              lowest frequencies. log10_p_white is below -3 for all of them.
 * Priors       The coefficient of a function may have a Gaussian prior of mean 0 and standard deviation s_j.
 *              (c_j/s_j)^2 is then added to both residuals; sigmas must be absolute, the marginal standard deviations
 *              of the noise.
 * Samples      In any order of time. Two samples must not have the same time, where this covariance is singular. Pairs
 *              much closer than the correlation time have great influence, since the model has no white component.
 * Accuracy     The power with correlated noise has an error of 1e-10 (promise: noise-power-has-ten-digits), if the
 *              functions leave 1e-8 of the squares of cosine and sine.
 * Source       Rybicki and Press (1995), Phys. Rev. Lett. 74, 1060; Patterson and Thompson (1971), Biometrika 58, 545;
 *              Baluev (2008), MNRAS 385, 1279.
 */
#ifndef TOLIMAN_PERIOD_NOISE_H
#define TOLIMAN_PERIOD_NOISE_H

#include <toliman/measure.h>
#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Flag of toliman_period_noise_options: power and FAP for white noise, rho = 0. The whiteness test is unchanged. */
#define TOLIMAN_PERIOD_WHITE_NOISE 1024u

/* Options of toliman_measure_query_noise. */
typedef struct toliman_period_noise_options {
    uint32_t struct_size;
    uint32_t flags;               /* TOLIMAN_PERIOD_WHITE_NOISE */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
} toliman_period_noise_options;
#define TOLIMAN_PERIOD_NOISE_OPTIONS_INIT TOLIMAN_INIT(toliman_period_noise_options)

/* Fitted noise and highest peak of a series. Standard errors are scaled by the residual; +infinity if the samples do
 * not determine the parameter. */
typedef struct toliman_period_noise {
    uint32_t struct_size;  /* in: sizeof(toliman_period_noise) */
    uint32_t flags;        /* TOLIMAN_PERIOD_AT_EDGE, _COARSE, _ABOVE_NYQUIST, _LONG */
    double rho;            /* correlation over one step */
    double rho_error;      /* its asymptotic standard error */
    double tau;            /* correlation time, -step/ln rho, in units of t; 0 if rho is 0 */
    double step;           /* median step between different times */
    double log10_p_white;  /* whiteness: log10 of the probability that white noise has a likelihood ratio of AR(1) to
                              white noise of this size or more, with the strongest sinusoid in both models */
    int64_t index;         /* grid frequency of highest power */
    double power;          /* P at that grid frequency */
    double log10_residual; /* log10(1 - P), at least -4900; meaningful down to -28 */
    double log10_fap;      /* Baluev's upper bound of the false alarm probability of that P */
    double frequency;      /* refined by least squares within one step of the grid. Members below are those of this
                              frequency */
    double frequency_error;
    double period; /* 1/frequency */
    double period_error;
    double amplitude; /* y = offset + amplitude sin(2 pi frequency (t - time_reference) + phase) + functions */
    double amplitude_error;
    double phase; /* rad */
    double phase_error;
    double offset; /* c_0 */
    double offset_error;
    double time_reference; /* the time that is nearest to the weighted mean time */
    uint32_t rank;         /* 2; 1 or 0 if the functions or each other leave nothing of cosine or sine */
    uint32_t reserved;
} toliman_period_noise;
#define TOLIMAN_PERIOD_NOISE_INIT TOLIMAN_INIT(toliman_period_noise)

/* Computes the power of a series at frequencies f0 + i df, i < nf, in the metric of the noise, which is fitted first.
 * With the mean its k functions are fitted, and their priors.
 *   options       may be NULL
 *   power         [nf]; may be NULL
 *   coefficients  [k], c_1 ... c_k at out->frequency, in units of y per unit of the function; may be NULL
 *   errors        [k], their standard errors; may be NULL
 * Takes O(n k) per frequency and one thread: 0.1 s for n = 836, k = 0 and nf = 5475, 0.2 s for k = 5. On failure
 * nothing is written.
 * Errors: TOLIMAN_E_ARGUMENT if a number is not finite, sigma <= 0, a precision < 0, two samples have the same time, a
 * function without a prior is a combination of the mean and the functions before it, or the grid is impossible;
 * TOLIMAN_E_STATE if n < k + 6, or if mean and functions describe all values; TOLIMAN_E_RANGE for |t| > 1e100, |y| >
 * 1e300 or phases of more than 2^50 cycles; TOLIMAN_E_CANCELLED. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_query_noise(
    const toliman_measure *series, double f0, double df, int64_t nf, const toliman_period_noise_options *options,
    double *power, double *coefficients, double *errors, toliman_period_noise *out) TOLIMAN_NOEXCEPT;

/* Options of toliman_measure_query_noise_bootstrap. */
typedef struct toliman_period_noise_bootstrap_options {
    uint32_t struct_size;
    uint32_t threads;             /* worker threads, 0 = one per processor */
    uint64_t seed;                /* of the random resamplings */
    uint64_t block;               /* consecutive samples per block, at most n; 0 = n^(1/3), rounded up */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
} toliman_period_noise_bootstrap_options;
#define TOLIMAN_PERIOD_NOISE_BOOTSTRAP_OPTIONS_INIT TOLIMAN_INIT(toliman_period_noise_bootstrap_options)

/* Moving-block bootstrap: writes log10(1 - P) of the highest power of each of `count` resamplings to
 * log10_residuals[count], sorted, strongest peak first. It assumes no distribution of the noise.
 *   rho  correlation over one step, in [0, 0.999]; out->rho of toliman_measure_query_noise
 * The residuals about mean and functions are
 * whitened with rho. A resampling strings blocks of consecutive residuals together, each from a random place, so that
 * correlations up to the length of a block remain, also those that rho does not describe. Times and sigmas do not
 * change. With rho = 0 the blocks must be longer than the correlation and the period. If m entries are at or below the
 * log10_residual of the highest peak, its FAP is (m + 1)/(count + 1). Each resampling takes the time of one
 * periodogram.
 * Errors: as toliman_measure_query_noise; TOLIMAN_E_RANGE for rho or block out of range. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_measure_query_noise_bootstrap(
    const toliman_measure *series, double f0, double df, int64_t nf, double rho,
    const toliman_period_noise_bootstrap_options *options, size_t count, double *log10_residuals) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
