/* libtoliman, planets: orbit, mass and odds of the planets of a series, and the planets that it excludes.
 *
 * Data flow (toliman_planet_...)
 *
 *   series (measure.h) -> create, destroy -> toliman_planet
 *   number of planets, residuals, priors   get_info
 *   orbit, mass, odds; posterior           get_candidate, get_samples
 *   for figures                            get_signal, get_residuals
 *   outliers; offsets, jitters             get_outliers, get_instruments
 *   upper limits; rate of detection        get_limits, inject
 *
 * Series       Reduced separations of a binary, radial velocities of a star, or other values, without masses; no prior
 *              for the mean. Noise must be white: toliman_measure_query_noise.
 * Model        y = c_0 + sum over j of c_j b_j + one signal per planet + noise; functions b_j of period_nuisance.h.
 *              Each instrument has an offset without a prior, and a jitter.
 * Signal       Separation: amplitude (r/a) cos(nu + periastron); nu, r, a: true anomaly of the planet, distance from
 *              its star, semi-major axis. amplitude: semi-major axis of the star's orbit times g, the sine of the angle
 *              between the axis A -> B and the pole of the planet's orbit. periastron: angle, in the direction of
 *              motion, from the projection of the axis on the orbital plane to the planet's periastron, if it orbits A;
 *              for B add 180 deg.
 *              Velocity: amplitude (cos(nu + periastron) + e cos(periastron)); periastron of the star.
 * Axis         That of each date if the series has position angles: two more amplitudes are then fitted, across the
 *              mean axis. Otherwise it is fixed, and its true rotation changes the measured period of a face-on orbit.
 * Velocities   Of one star or both, fitted together with separations: two more amplitudes, along the line of sight.
 *              Inclination, node and true masses follow, except for the mirror image of the orbit in the plane of axis
 *              and line of sight.
 * Mass         One series measures mass times g, or of velocities times sin i. Separations do not show which star has
 *              the planet: the mass is given for both.
 * Priors       log period, mean anomaly, direction of the orbit and star: uniform. Eccentricity: Beta(0.867, 3.03).
 *              Amplitudes: Gaussian, with a log-uniform standard deviation. Jitter s, added in quadrature to all sigmas
 *              if chi_square is poor or there are no sigmas: 1/(s + s0), s0 a tenth of the median sigma, or a
 *              thousandth of jitter_max.
 * Odds         log10_bayes: log10 of the Bayes factor of one additional planet, without prior odds. Of series without a
 *              planet, at most 0.6 % reach the threshold, at 95 % confidence (promise: false-planets-are-rare).
 * Candidates   Each is searched in the residuals of those before it. The search ends with the first one that is below
 *              `threshold` or has a reason other than SAMPLES and FRAMES. All are then fitted together.
 * Verdict      A candidate is a planet only if no reason of TOLIMAN_PLANET_REASON_... speaks against it
 *              (promise: one-reason-forbids-a-planet).
 * Outliers     Samples farther than 6 robust standard deviations, and than 6 of their sigmas, from the fit of the
 *              functions with a sinusoid, and also from the joint fit. The search ignores them. With outliers no
 *              candidate is a planet, except with TOLIMAN_PLANET_CLIP (promise: outliers-forbid-a-planet).
 * Source       Price-Whelan et al. (2017), ApJ 837, 20. */
#ifndef TOLIMAN_PLANET_H
#define TOLIMAN_PLANET_H

#include <toliman/goodness.h>
#include <toliman/measure.h>

TOLIMAN_BEGIN_DECLS

/* Result of a search. */
typedef struct toliman_planet toliman_planet;

#define TOLIMAN_PLANET_NO_JITTER 2u /* the sigmas are exact */
#define TOLIMAN_PLANET_CLIP 4u      /* leave out outliers */

/* Largest number of planets. */
#define TOLIMAN_PLANET_MOST 4u

/* Columns of toliman_planet_get_samples. */
#define TOLIMAN_PLANET_COLUMNS 10u

/* Ranges of the priors. */
typedef struct toliman_planet_prior {
    double period_min, period_max; /* in units of t, in (0, 1e100]; 0 = 60 d and 1000 d */
    double eccentricity_max;       /* in [0.001, 0.99]; 0 = 0.99 */
    /* Scale of the amplitudes, in units of y, in (0, 1e100]; set both or none; 0 = the default: for separations of
     * known unit from 0.05 uas to 100 uas, or to 3 rms if that is larger; for others from a tenth of the standard error
     * of an amplitude to 3 rms about the mean of each instrument, without the planets found before */
    double amplitude_min, amplitude_max;
    double jitter_max; /* in units of y, in (0, 1e100]; 0 = the rms of the series. Not with TOLIMAN_PLANET_NO_JITTER */
} toliman_planet_prior;

/* Options of a search. */
typedef struct toliman_planet_options {
    uint32_t struct_size;
    uint32_t flags;       /* TOLIMAN_PLANET_NO_JITTER, _CLIP */
    uint32_t max_planets; /* in [1, TOLIMAN_PLANET_MOST]; 0 = 1 */
    uint32_t threads;
    /* Of the binary; without them, masses are NaN */
    double parallax_arcsec; /* in (0, 0.77] arcsec; 0 = that of the series; 0 for velocities */
    double star_mass[2];    /* of A and B, in [0.01, 500] solar masses; 0 = that of the series. Velocities: of A */
    toliman_planet_prior prior;
    /* Velocities of A and of B, TOLIMAN_MEASURE_VELOCITY, with sigmas and a known unit. The series must then be
     * separations of known unit and parallax; all times are dates, or all plain numbers. */
    const toliman_measure *velocity_a, *velocity_b;
    double threshold;     /* least log10_bayes of a planet, in [-100, 1e6]; 0 = 2 */
    double detection_fap; /* largest FAP of a planet, also in limits and injections, in [1e-300, 0.5]; 0 = 0.001 */
    uint32_t samples;     /* of each posterior, in [100, 1e6]; 0 = 4096 */
    uint32_t reserved;
    uint64_t seed;
    toliman_progress_fn progress;
    void *progress_data;
} toliman_planet_options;
#define TOLIMAN_PLANET_OPTIONS_INIT TOLIMAN_INIT(toliman_planet_options)

/* Searches a series, which is copied, for planets. Takes 1 to 15 s of processor time per planet and 1,000 samples.
 * Errors: TOLIMAN_E_ARGUMENT separations that are not reduced, equal times, a function without a prior that is a
 * combination of those before it; TOLIMAN_E_STATE n below the number of functions + 6; TOLIMAN_E_RANGE more than 2e6
 * steps of 0.2/(last - first time) from period_min. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_create(const toliman_measure *series,
                                                                    const toliman_planet_options *options,
                                                                    toliman_planet **out) TOLIMAN_NOEXCEPT;

/* Destroys a result. */
TOLIMAN_API void toliman_planet_destroy(toliman_planet *planets) TOLIMAN_NOEXCEPT;

/* Properties of a result. */
typedef struct toliman_planet_info {
    uint32_t struct_size;
    uint32_t planets;      /* candidates without a reason against them */
    uint32_t candidates;   /* those that reach the threshold, and at most one more */
    uint32_t functions;    /* with the mean */
    double rms;            /* weighted, of the residuals of the joint fit, units of y */
    double chi_square;     /* goodness.h: of the joint fit without jitter, outliers included except with _CLIP; NaN
                              without sigmas */
    double jitter[3];      /* 16, 50, 84 % points, with the last planet or, if none, the first candidate in the fit; of
                              the instrument with the largest; 0 = no jitter */
    double time_reference; /* weighted mean time */
    double axis_deg;       /* position angle of the mean axis; NaN if it is fixed */
    double axis_turn_deg;  /* its rotation in the series; 0 if it is fixed */
    /* Of the priors, units of t and y */
    double period_min, period_max, amplitude_min, amplitude_max;
    double chi_square_sigma, largest_residual;
    double chi_square_with_jitter; /* of the samples in use */
    int32_t goodness;
    uint32_t outliers;
    uint64_t series_digest; /* of all numbers of series and velocities, to recognise them */
} toliman_planet_info;
#define TOLIMAN_PLANET_INFO_INIT TOLIMAN_INIT(toliman_planet_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_info(const toliman_planet *planets,
                                                                      toliman_planet_info *out) TOLIMAN_NOEXCEPT;

/* Flag: more than 1 % of the posterior is within 1 % of period_min, period_max or eccentricity_max, or the best fit is
 * outside the range of periods. */
#define TOLIMAN_PLANET_AT_EDGE 1u

/* Reasons against a planet.
 *   ODDS        log10_bayes is below the threshold. Other reasons are then not given
 *   CHI_SQUARE  chi_square_with_jitter is not good: poor without a jitter, or too good
 *   JITTER      separations: chi_square of the samples in use is above 3: frame model, times, unit or sigmas are wrong
 *   FAP         log10_fap and log10_fap_orbit are above log10 of detection_fap
 *   EDGE        TOLIMAN_PLANET_AT_EDGE
 *   RANGE       a sinusoid fits better at a period outside [period_min, period_max]; searched from twice the median
 *               time step to twice the time span
 *   MASS        the mass is not below that of the star, for each star of known mass
 *   CROSSING    the orbit crosses that of a planet with larger odds, if both orbit the same star
 *   FRAMES      frame_chi_square of the series is above 2
 *   SAMPLES     there are outliers, without TOLIMAN_PLANET_CLIP
 *   EVIDENCE    log10_bayes minus log10_bayes_error is below the threshold */
#define TOLIMAN_PLANET_REASON_ODDS 65536u
#define TOLIMAN_PLANET_REASON_CHI_SQUARE 131072u
#define TOLIMAN_PLANET_REASON_JITTER 262144u
#define TOLIMAN_PLANET_REASON_FAP 524288u
#define TOLIMAN_PLANET_REASON_EDGE 1048576u
#define TOLIMAN_PLANET_REASON_RANGE 2097152u
#define TOLIMAN_PLANET_REASON_MASS 4194304u
#define TOLIMAN_PLANET_REASON_CROSSING 8388608u
#define TOLIMAN_PLANET_REASON_FRAMES 16777216u
#define TOLIMAN_PLANET_REASON_SAMPLES 33554432u
#define TOLIMAN_PLANET_REASON_EVIDENCE 67108864u

/* A candidate, in the order in which they were found. Members [3] are the 16, 50 and 84 % points of the posterior.
 * Angles are within half a turn of those in `best`, epochs within half a period. */
typedef struct toliman_planet_candidate {
    uint32_t struct_size;
    uint32_t flags;
    uint32_t reasons; /* TOLIMAN_PLANET_REASON_...; 0: a planet */
    int32_t star;     /* likelier star, 0 = A, 1 = B; -1 without velocities */
    double log10_bayes;
    double log10_bayes_error; /* of the quadrature; infinite if not converged */
    double log10_fap;         /* Baluev's bound for the strongest sinusoid */
    double log10_fap_orbit;   /* of the joint fit: log10 of 20 z times the FAP of a sinusoid of the same power; z: half
                                 of power times degrees of freedom, at least 1 */
    double period[3];
    double eccentricity[3];
    double periastron_deg[3];
    double epoch[3]; /* of a passage through periastron */
    double amplitude[3];
    double mass_a[3]; /* Earth masses, times g or sin i, if the planet orbits A. With velocities: true masses, NaN if
                         `star` is not A */
    double mass_b[3]; /* likewise for B */
    double best[5];   /* joint fit: period (may leave its prior), eccentricity, periastron_deg (-180 to 180), epoch
                         (nearest to time_reference), amplitude */
    double best_error[5];
    double correlation[25];    /* [5][5], posterior of the same five */
    double power_left;         /* share of the squared signal left by functions and other planets */
    double log10_star;         /* log10 of the odds of star A; NaN without velocities */
    double inclination_deg[3]; /* of the orbit or its mirror image, 0 to 90; likewise */
    double node_deg[3];        /* ascending node from the mean axis, to either side; likewise */
} toliman_planet_candidate;
#define TOLIMAN_PLANET_CANDIDATE_INIT TOLIMAN_INIT(toliman_planet_candidate)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_candidate(
    const toliman_planet *planets, int64_t index, toliman_planet_candidate *out) TOLIMAN_NOEXCEPT;

/* Writes samples of the posterior of a candidate, of equal weight and in random order.
 *   count    at most `samples` of the options
 *   samples  [count][TOLIMAN_PLANET_COLUMNS]: period, eccentricity, periastron_deg, epoch, amplitude, mass_a, mass_b,
 *            jitter, inclination_deg, node_deg */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_samples(const toliman_planet *planets, int64_t index,
                                                                         size_t count,
                                                                         double *samples) TOLIMAN_NOEXCEPT;

/* Writes the signal of a candidate's joint fit at times t[n] to signal[n].
 *   position_angle_deg  [n], as in the series; NULL = along the mean axis; must be NULL if the axis is fixed */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_signal(const toliman_planet *planets, int64_t index,
                                                                        const double *t,
                                                                        const double *position_angle_deg, size_t n,
                                                                        double *signal) TOLIMAN_NOEXCEPT;

/* Writes the residuals of the joint fit of the functions and all candidates that reach the threshold to residuals[n]:
 * the series, then velocities of A and of B; n is the number of all samples. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_residuals(const toliman_planet *planets, size_t n,
                                                                           double *residuals) TOLIMAN_NOEXCEPT;

/* Writes the indices of the outliers in the residuals to indices[count], count = info.outliers. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_outliers(const toliman_planet *planets, size_t count,
                                                                          int64_t *indices) TOLIMAN_NOEXCEPT;

/* Writes the instruments in the joint fit: those of the series, then of the velocities of A and of B. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_instruments(const toliman_planet *planets,
                                                                             toliman_measure_instrument *instruments,
                                                                             size_t capacity,
                                                                             size_t *count) TOLIMAN_NOEXCEPT;

/* Limits at one period, for circular orbits. */
typedef struct toliman_planet_limit {
    uint32_t struct_size;
    uint32_t reserved;
    double period;
    double upper;      /* excluded amplitude, units of y; +infinity if the functions leave nothing */
    double detectable; /* amplitude that a search detects with `probability`; +infinity: none */
    /* Earth masses, times g or sin i */
    double upper_mass_a, upper_mass_b, detectable_mass_a, detectable_mass_b;
} toliman_planet_limit;
#define TOLIMAN_PLANET_LIMIT_INIT TOLIMAN_INIT(toliman_planet_limit)

/* Computes limits of one additional planet, from the separations alone, with amplitudes along the mean axis.
 *   periods      [count], within the prior
 *   probability  in (0, 1), for example 0.95
 *   limits       [count]
 * upper       With `probability`, a planet of this amplitude and random phase would let a sinusoid reduce chi-square by
 *             more than it does in this series. A reduction below the 16 % point of noise counts as that point. A true
 *             planet is wrongly excluded with a probability of 1 - probability, at any period
 *             (promise: upper-limits-hold).
 * detectable  From 400 simulated series, within 5 %. Detected: log10_bayes of circular orbits reaches the threshold,
 *             log10_fap that of detection_fap, and the posterior is not at the edges of the prior; the period may
 *             differ. It agrees with toliman_planet_inject within 0.03 in probability
 *             (promise: detectable-planets-are-found). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_limits(const toliman_planet *planets,
                                                                        const double *periods, size_t count,
                                                                        double probability,
                                                                        toliman_planet_limit *limits) TOLIMAN_NOEXCEPT;

/* Planets that are injected. */
typedef struct toliman_planet_cell {
    uint32_t struct_size;
    int32_t star;                  /* 0, 1: a planet of A, B; sizes are Earth masses, times g or sin i. -1: sizes are
                                      amplitudes, units of y */
    double period_min, period_max; /* within the prior; log-uniform, or equal */
    double size_min, size_max;     /* log-uniform, or equal */
    int32_t is_circular;           /* 1: eccentricity 0. 0: drawn from its prior */
    uint32_t count;                /* injections, at most 1,000,000 */
    uint64_t seed;
} toliman_planet_cell;
#define TOLIMAN_PLANET_CELL_INIT TOLIMAN_INIT(toliman_planet_cell)

/* Counts the detections (toliman_planet_get_limits) among planets injected into white noise of the sigmas and the
 * jitter of the series. Each injection also draws the coefficients of the functions that have a prior, planets
 * included. Periastron and epoch are uniform; the amplitude across the mean axis is 0. The same `planets` and `cell`
 * give the same number. Keeps 16 n bytes (32 n if the axis rotates) per step 1/(10 T) of frequency.
 * Errors: TOLIMAN_E_ARGUMENT masses without a known unit, parallax or mass of the star. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_inject(const toliman_planet *planets,
                                                                    const toliman_planet_cell *cell,
                                                                    uint32_t *detected) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
