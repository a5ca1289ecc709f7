/* libtoliman, planets: orbit, mass and odds of the planets of a series, and the planets that it excludes.
 *
 * Data flow (functions toliman_planet_...)
 *
 *   series, options -> create -> toliman_planet -> get_info                       number of planets, residuals, priors
 *   (measure.h)                                -> get_candidate                  orbit, mass, odds
 *                                              -> get_samples                    samples of the posterior
 *                                              -> get_signal, get_residuals      for figures
 *                                              -> get_outliers                   samples that do not belong
 *                                              -> get_instruments                offsets and jitters
 *                                              -> get_limits                     upper limits, detectable amplitudes
 *                                              -> inject                         rate of detection by injection
 *                                              destroy
 *
 * Series       Reduced separations of a binary (toliman_sky_reduce, or a state folder), or the radial velocities of a
 *              star, or values of another kind, without masses. The mean must not have a prior.
 * Model        y = c_0 + sum over j of c_j b_j + one signal per planet + noise, with the nuisance functions of
 *              period_nuisance.h: mean, Chebyshev polynomials, columns.
 * Signal       Of a separation: amplitude (r/a) cos(nu + periastron), with the planet's true anomaly nu and distance r
 *              from its star in units of the semi-major axis a. periastron is the angle from the projection of the
 *              axis A -> B on the orbital plane to the planet's periastron, in the direction of motion, if the planet
 *              orbits A; if it orbits B, add 180 deg. The amplitude is that of its star: star's semi-major axis times
 *              g, the sine of the angle between the axis and the pole of the planet's orbit.
 *              Of a velocity: amplitude (cos(nu + periastron) + e cos(periastron)); periastron is that of the star.
 * Axis         With position angles, the axis A -> B is that of the date. The signal then has two more amplitudes,
 *              across the mean axis, with the same prior. Amplitude and periastron are those along the mean axis. The
 *              rotation of the axis adds to the frequency of a face-on orbit; the two amplitudes describe it, and the
 *              error of the period is larger. Without position angles the axis is fixed: the period of a face-on orbit
 *              is then wrong by the angle through which the axis turns in one period, divided by 360 deg (alpha
 *              Centauri: 0.8 % at 479 d from 2027 to 2030).
 * Velocities   Of one star or both, with their own functions, fitted together with separations: the orbit has one
 *              period, eccentricity and epoch. Two more amplitudes, of the coordinate away from the observer, have the
 *              prior of the others: orbits of all directions have the same probability. Orbits about A and about B are
 *              searched; before the data both stars have the same probability. Inclination and node follow from the
 *              amplitudes along the axis and away from the observer, but for the mirror image of the orbit in the plane
 *              of both. Masses are then true masses. Times are those of the separations; the light time across the
 *              Earth's orbit is 8 min at most.
 * Instruments  Each has an offset, without a prior, and a jitter. The ratios of their jitters are those of restricted
 *              maximum likelihood (Patterson and Thompson 1971) without the planet, or with it if these give larger
 *              odds; their common factor has the prior of a jitter. A jitter that an instrument hardly determines is
 *              drawn towards those of the others: the logarithms have a prior with a standard deviation of ln 10.
 * Mass         One series measures mass times g, or mass times sin i of velocities; g is 0.985 to 0.997 for an orbit in
 *              the plane of alpha Centauri, 0.785 in the mean of all directions. Which star has the planet cannot be
 *              seen in a separation: the mass is stated for both. The total mass of the orbit includes this mass times
 *              g or sin i as that of the planet.
 * Priors       log period: uniform from period_min to period_max. Eccentricity: Beta(0.867, 3.03) up to
 *              eccentricity_max. Mean anomaly: uniform. Amplitudes: Gaussian with mean 0 and a standard deviation
 *              whose logarithm is uniform from amplitude_min to amplitude_max. Jitter s, added in quadrature to all
 *              sigmas: density proportional to 1/(s + s0) up to jitter_max, with s0 a tenth of the median sigma, or a
 *              thousandth of jitter_max without sigmas. The mean has no prior.
 * Method       Coefficients and amplitudes are marginalised analytically; frequency, eccentricity, mean anomaly, scale
 *              of the amplitudes and jitter by quadrature on a lattice. Cells are divided where the posterior is
 *              concentrated, until neighbouring nodes differ little. There are no chains and no random start.
 * Jitter       Fitted if chi_square is poor without it, or if there are no sigmas. With right sigmas, odds and errors
 *              are those of exact ones.
 * Odds         log10_bayes: log10 of the Bayes factor of a model with one more planet against the model without it,
 *              with these priors. It does not contain the prior odds. Of series without a planet, at most 0.6 % (95 %)
 *              reach the threshold (promise: false-planets-are-rare): the largest factor of 500 was 2, log10 0.3.
 * Candidates   One at a time: candidate k is searched in the residuals of candidates 1 ... k-1. The derivatives of
 *              their signals are fitted too, which marginalises their errors to first order. The search ends with the
 *              first whose log10_bayes is below `threshold`, or that has a reason other than SAMPLES and FRAMES. All
 *              others are fitted together, and the posterior of each is computed again with the others. One whose
 *              log10_bayes is then below the threshold becomes the last candidate, and the search ends.
 * Verdict      A candidate is a planet only if no reason of TOLIMAN_PLANET_REASON_... speaks against it
 *              (promise: one-reason-forbids-a-planet). Odds alone prove nothing: both models may be wrong.
 * Outliers     Samples farther than 6 standard deviations from a robust fit of functions and sinusoid and also from
 *              the joint fit. The standard deviation is the sigma times that of the residuals, by their median, if that
 *              is above 1. Outliers have no weight in the search: a sharp periastron would describe any single one of
 *              them. With one outlier or more no candidate is a planet, except with TOLIMAN_PLANET_CLIP
 *              (promise: outliers-forbid-a-planet).
 * Noise        Must be white. toliman_measure_query_noise tests it.
 * Source       Hogg, Myers and Bovy (2010), ApJ 725, 2166, and Price-Whelan et al. (2017), ApJ 837, 20, for the
 *              marginalisation; Kipping (2013), MNRAS 434, L51, for the prior of the eccentricity; Golub and Pereyra
 *              (1973), SIAM J. Numer. Anal. 10, 413, for the joint fit.
 */
#ifndef TOLIMAN_PLANET_H
#define TOLIMAN_PLANET_H

#include <toliman/goodness.h>
#include <toliman/measure.h>

TOLIMAN_BEGIN_DECLS

/* Result of a search. Several threads may use it at the same time. */
typedef struct toliman_planet toliman_planet;

/* Flags of toliman_planet_options. */
#define TOLIMAN_PLANET_NO_JITTER 2u /* the sigmas are exact: no jitter is fitted, however poor the fit */
#define TOLIMAN_PLANET_CLIP 4u      /* leave out samples that do not belong: planets are those of the others */

/* Largest number of planets. */
#define TOLIMAN_PLANET_MOST 4u

/* Number of columns of the samples of a posterior. */
#define TOLIMAN_PLANET_COLUMNS 10u

/* Ranges of the priors. */
typedef struct toliman_planet_prior {
    double period_min, period_max; /* in units of t, in (0, 1e100]; 0 = 60 d and 1000 d */
    double eccentricity_max;       /* in [0.001, 0.99]; 0 = 0.99 */
    double amplitude_min,
        amplitude_max; /* range of the scale of the amplitudes, in units of y, in (0, 1e100]; set both or none; 0 = the default: with a known unit of separations 0.05 uas to 5 uas, or to the rms
                                            of the series if that is larger. Otherwise: 0.1 s to 3 rms, with the rms of
                                            the series without the planets before, and the standard error s of an
                                            amplitude in this noise, not in that of the sigmas, which may be
                                            wrong. With several instruments s follows from the noise of each */
    double jitter_max; /* in units of y, in (0, 1e100]; 0 = the rms of the series. Not with TOLIMAN_PLANET_NO_JITTER */
} toliman_planet_prior;

/* Options of a search. */
typedef struct toliman_planet_options {
    uint32_t struct_size;
    uint32_t flags;       /* TOLIMAN_PLANET_NO_JITTER, _CLIP */
    uint32_t max_planets; /* in [1, TOLIMAN_PLANET_MOST]; 0 = 1 */
    uint32_t threads;     /* worker threads, 0 = one per processor */
    double
        parallax_arcsec; /* of the binary, in (0, 0.77] arcsec; 0 = that of the series; if that is unknown, and if the unit is, masses
                               of a separation are NaN. 0 for velocities */
    double star_mass
        [2]; /* of A and B, in [0.01, 500] solar masses; 0 = that of the series; if that is unknown, the mass for it is
                               NaN. Velocities: of A */
    toliman_planet_prior prior;
    /* Velocities of A and of B: of kind TOLIMAN_MEASURE_VELOCITY, with sigmas and a known unit. NULL: none. The series
     * must then be of separations of known unit and parallax; their times are both dates, or both plain numbers. */
    const toliman_measure *velocity_a, *velocity_b;
    double threshold; /* log10 of the Bayes factor that a planet needs, in [-100, 1e6]; 0 = 2 */
    double
        detection_fap; /* largest FAP of a planet, and FAP of a detection in limits and injections, in [1e-300, 0.5]; 0 = 0.001 */
    uint32_t samples; /* samples of each posterior, in [100, 1e6]; 0 = 4096 */
    uint32_t reserved;
    uint64_t seed;                /* of the samples */
    toliman_progress_fn progress; /* may be NULL */
    void *progress_data;
} toliman_planet_options;
#define TOLIMAN_PLANET_OPTIONS_INIT TOLIMAN_INIT(toliman_planet_options)

/* Searches a series for planets. Its functions and their priors are fitted, too.
 *   options  may be NULL
 * The series is copied. The caller destroys *out. Processor time per planet: 1 s for 836 samples with 5 nuisance
 * functions, 3 s for a strong signal; where the sigmas are much too small, 5 s for 150 velocities and 11 s for 1,000 in
 * the median, 15 s at most; about twice that with instruments or with velocities and separations; 300 MB at most. The
 * first lattice has 160 nodes for each step 0.2/T of frequency, where T is the last minus the first time; if they are
 * more than 4 million, twice the time. Errors:
 * TOLIMAN_E_ARGUMENT, naming the member, if a number is outside its limits, for separations that are not reduced, if
 * all times are equal, or a function without a prior is a combination of those before it, and for velocities with other
 * times, kinds or units than described; TOLIMAN_E_STATE if n is below the number of functions + 6; TOLIMAN_E_RANGE if
 * there are more than 2e6 steps of frequency, because period_min is too short; TOLIMAN_E_CANCELLED. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_create(const toliman_measure *series,
                                                                    const toliman_planet_options *options,
                                                                    toliman_planet **out) TOLIMAN_NOEXCEPT;

/* Destroys a result. NULL is allowed. */
TOLIMAN_API void toliman_planet_destroy(toliman_planet *planets) TOLIMAN_NOEXCEPT;

/* Properties of a result. */
typedef struct toliman_planet_info {
    uint32_t struct_size; /* in: sizeof(toliman_planet_info) */
    uint32_t planets;     /* candidates without a reason against a planet */
    uint32_t candidates;  /* candidates with a posterior: those whose log10_bayes reaches the threshold, and at most one
                             more */
    uint32_t functions;   /* mean and nuisance functions */
    double rms;           /* weighted rms of the residuals of the joint fit, in units of y */
    double chi_square;    /* as in goodness.h, of the joint fit and the sigmas without the jitter, so that a jitter does
                             not hide a poor fit; NaN without sigmas. Outliers count, except with _CLIP. Degrees of
                             freedom: samples minus the sum of their leverages. This sum is the number of coefficients
                             and orbital elements, less the part that priors determine */
    double jitter[3];     /* 16, 50 and 84 % of the jitter in the posterior of the last planet, or of the candidate
                             if there is none; 0 without one. With instruments: the largest of the series */
    double time_reference; /* weighted mean time */
    double axis_deg;       /* position angle of the mean axis, -180 to 180; NaN if the axis is fixed */
    double axis_turn_deg;  /* angle through which the axis turns in the series; 0 if it is fixed */
    double period_min, period_max, amplitude_min, amplitude_max; /* of the priors, in units of t and y */
    double chi_square_sigma, largest_residual;                   /* as in goodness.h */
    double chi_square_with_jitter; /* of the samples in use, with the jitter in their sigmas */
    int32_t goodness;              /* TOLIMAN_GOODNESS_... of chi_square */
    uint32_t outliers;             /* samples that do not belong */
} toliman_planet_info;
#define TOLIMAN_PLANET_INFO_INIT TOLIMAN_INIT(toliman_planet_info)

/* Writes the properties to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_info(const toliman_planet *planets,
                                                                      toliman_planet_info *out) TOLIMAN_NOEXCEPT;

/* Flag of toliman_planet_candidate: more than 1 % of the posterior is within 1 % of period_min, period_max or
 * eccentricity_max, or the best fit is outside the range of periods. */
#define TOLIMAN_PLANET_AT_EDGE 1u

/* Reasons against a planet, one bit each.
 *   ODDS        log10_bayes is below the threshold. A candidate has no other reason then
 *   CHI_SQUARE  chi_square_with_jitter is not good: poor without a jitter, or too good
 *   JITTER      chi_square of the samples in use is above 3 in a series of separations, more than a jitter may explain:
 *               the model of the frames, times, unit or sigmas are wrong. Velocities have the jitter of their star
 *   FAP         both log10_fap and log10_fap_orbit are above log10 of detection_fap
 *   EDGE        TOLIMAN_PLANET_AT_EDGE
 *   RANGE       a sinusoid fits better at a period outside period_min to period_max, of those from twice the median
 *               time step to twice the time span
 *   MASS        the mass is not below that of the star, for each star of known mass
 *   CROSSING    the orbit crosses that of a planet with larger odds, if both orbit the same star
 *   FRAMES      frame_chi_square of the series is above 2
 *   SAMPLES     there are outliers, and TOLIMAN_PLANET_CLIP is not set
 *   EVIDENCE    log10_bayes has not converged: it is below the threshold within its error */
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

/* A candidate. Three numbers are the 16, 50 and 84 % points of the samples of the posterior. Those of angles and epochs
 * are taken within half a turn or half a period of the best fit. */
typedef struct toliman_planet_candidate {
    uint32_t struct_size; /* in: sizeof(toliman_planet_candidate) */
    uint32_t flags;       /* TOLIMAN_PLANET_AT_EDGE */
    uint32_t reasons;     /* TOLIMAN_PLANET_REASON_...; 0: a planet */
    int32_t star;         /* with velocities: the likelier star, 0 = A, 1 = B; -1: not known */
    double log10_bayes;   /* log10 of the Bayes factor, given the other candidates */
    /* Error of the quadrature: its change from the last but one to the last resolution, and what is not resolved;
     * infinite if the odds have not converged. */
    double log10_bayes_error;
    double log10_fap;       /* Baluev's bound of the false alarm probability of the highest power of a sinusoid */
    double log10_fap_orbit; /* log10 of 20 z FAP: FAP that of a sinusoid as powerful as the joint fit, z half the
                               reduction of chi-square by it; 20 z counts the shapes of an orbit */
    double period[3];       /* units of t */
    double eccentricity[3];
    double periastron_deg[3];  /* as in the signal described at the top of planet.h */
    double epoch[3];           /* time of a passage through periastron, within half a period of best[3] */
    double amplitude[3];       /* units of y */
    double mass_a[3];          /* Earth masses, times g or sin i, if the planet orbits A. With velocities: true masses,
                                 NaN if `star` is not A */
    double mass_b[3];          /* the same if it orbits B */
    double best[5];            /* joint fit: period, eccentricity, periastron_deg (-180 to 180), epoch (within half a
                                 period of time_reference), amplitude. It may leave the prior of the period. The two
                                 components of the eccentricity have priors with a standard deviation of 0.3, the
                                 amplitudes one of their own size */
    double best_error[5];      /* standard errors of the joint fit, from its linearisation */
    double correlation[25];    /* [5][5], of the posterior of the same five */
    double power_left;         /* share of the squared signal that the nuisance functions and other planets leave */
    double log10_star;         /* with velocities: log10 of the odds of star A against star B; NaN without */
    double inclination_deg[3]; /* with velocities: of the orbit or of its mirror image, 0 to 90; NaN without */
    double node_deg[3];        /* the same: angle of the ascending node from the mean axis, to either side, 0 to 180.
                                  Inclination and node without information have the widths of their priors */
} toliman_planet_candidate;
#define TOLIMAN_PLANET_CANDIDATE_INIT TOLIMAN_INIT(toliman_planet_candidate)

/* Writes candidate `index` to *out, whose struct_size must be set. Candidates are numbered as they were found. Errors:
 * TOLIMAN_E_RANGE if index is not in [0, info.candidates). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_candidate(
    const toliman_planet *planets, int64_t index, toliman_planet_candidate *out) TOLIMAN_NOEXCEPT;

/* Writes the first `count` samples of the posterior of a candidate, of equal weight and in random order.
 *   count    number of samples, at most `samples` of the options
 *   samples  [count][TOLIMAN_PLANET_COLUMNS]: period, eccentricity, periastron_deg, epoch, amplitude, mass_a, mass_b,
 *            jitter, inclination_deg, node_deg
 * Errors: TOLIMAN_E_RANGE as toliman_planet_get_candidate; TOLIMAN_E_ARGUMENT for a bad count. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_samples(const toliman_planet *planets, int64_t index,
                                                                         size_t count,
                                                                         double *samples) TOLIMAN_NOEXCEPT;

/* Writes the signal of a candidate's joint fit at times t[n] to signal[n].
 *   position_angle_deg  [n], as in the series; NULL = the mean axis, also if the series has none
 * Errors: TOLIMAN_E_RANGE as toliman_planet_get_candidate; TOLIMAN_E_ARGUMENT for position angles of a fixed axis, or
 * numbers that are not finite. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_signal(const toliman_planet *planets, int64_t index,
                                                                        const double *t,
                                                                        const double *position_angle_deg, size_t n,
                                                                        double *signal) TOLIMAN_NOEXCEPT;

/* Writes the residuals of the joint fit of nuisance functions and all candidates that reach the threshold to
 * residuals[n], in the order of the series; velocities of A and of B follow. The signal of a candidate below the
 * threshold remains in them. Errors: TOLIMAN_E_ARGUMENT if n is not the number of all samples. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_residuals(const toliman_planet *planets, size_t n,
                                                                           double *residuals) TOLIMAN_NOEXCEPT;

/* Writes the indices of the samples that do not belong, in the order of the residuals, to indices[count]. Errors:
 * TOLIMAN_E_ARGUMENT if count is not info.outliers. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_outliers(const toliman_planet *planets, size_t count,
                                                                          int64_t *indices) TOLIMAN_NOEXCEPT;

/* Writes the instruments of the series, then those of the velocities of A and of B, in the joint fit, to
 * instruments[capacity] and their number to *count. TOLIMAN_E_CAPACITY if capacity is too small. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_instruments(const toliman_planet *planets,
                                                                             toliman_measure_instrument *instruments,
                                                                             size_t capacity,
                                                                             size_t *count) TOLIMAN_NOEXCEPT;

/* Limits at one period, for circular orbits. */
typedef struct toliman_planet_limit {
    uint32_t struct_size; /* in: sizeof(toliman_planet_limit) */
    uint32_t reserved;
    double period;
    double upper;      /* amplitude that the residuals of the planets exclude; units of y. +infinity if the functions
                          leave nothing of this period */
    double detectable; /* amplitude of an orbit that a search calls a planet with `probability`, averaged over phase
                          and noise; +infinity if there is none */
    double upper_mass_a, upper_mass_b, detectable_mass_a, detectable_mass_b; /* Earth masses, times g or sin i */
} toliman_planet_limit;
#define TOLIMAN_PLANET_LIMIT_INIT TOLIMAN_INIT(toliman_planet_limit)

/* Computes limits of one additional planet, from the separations: a planet whose orbit is seen face-on has no velocity.
 *   periods      [count], in units of t, within the prior
 *   probability  in (0, 1), for example 0.95
 *   limits       [count], with the struct_size of limits[0] set
 * Excluded: of planets of this amplitude, with a random phase, noise gives to the share `probability` a larger gain
 * (reduction of chi-square by a sinusoid of this period) than that of the series. A planet that is there is excluded
 * with a probability of 1 - probability, at all periods (promise: upper-limits-hold). A gain below the 16 % point of
 * noise counts as that point; a limit is 0 only for a probability below 0.84.
 * Detected: log10_bayes, summed over circular orbits alone, reaches the threshold, log10_fap of the sinusoid is at
 * most log10 of detection_fap, and the posterior is not at the edges of the prior: what toliman_planet_create needs
 * for a planet. The period that is found may differ: that of a planet near period_max is drawn towards shorter ones by
 * the prior of the amplitude. Amplitudes are along the mean axis. `detectable` is that of 400 simulated series, within
 * 5 % in amplitude, and agrees with toliman_planet_inject within 0.03 in probability
 * (promise: detectable-planets-are-found). 0.02 to 0.1 s of processor time per period with 200 to 1,100 samples; worker
 * threads as for the search. Errors: TOLIMAN_E_ARGUMENT for bad numbers and periods outside the prior. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_get_limits(const toliman_planet *planets,
                                                                        const double *periods, size_t count,
                                                                        double probability,
                                                                        toliman_planet_limit *limits) TOLIMAN_NOEXCEPT;

/* Planets that are injected. */
typedef struct toliman_planet_cell {
    uint32_t struct_size;
    int32_t star;                  /* the star that has the planet, 0 = A, 1 = B; sizes are then Earth masses, times g
                                      or sin i. -1: sizes are amplitudes in units of y */
    double period_min, period_max; /* in units of t, within the prior; log period is uniform between them, or they are
                                      equal */
    double size_min, size_max;     /* the same for the logarithm of the size */
    int32_t is_circular;           /* 1: eccentricity 0. 0: drawn from its prior */
    uint32_t count;                /* number of injections, at most 1,000,000 */
    uint64_t seed;
} toliman_planet_cell;
#define TOLIMAN_PLANET_CELL_INIT TOLIMAN_INIT(toliman_planet_cell)

/* Counts the detections among planets that are injected into white noise of the sigmas and the jitter of the series.
 *   cell      the planets; periastron and epoch are uniform, the amplitude across the mean axis is 0
 *   detected  receives the number of detections, as defined in toliman_planet_get_limits
 * The series also have errors of the functions with a prior, drawn from it, those of the planets that were found among
 * them. Each search fits these functions as the search of the series does. Runs in the calling thread, 0.1 ms per
 * injection with the default periods. The first call needs 16 n bytes per frequency, 32 n if the axis turns, of those
 * 1/(10 T) apart, for the lifetime of *planets; T is the last minus the first time. The same `planets` and `cell` give
 * the same number. Errors: TOLIMAN_E_ARGUMENT for bad numbers, and for masses if unit, parallax or the mass of the
 * star is unknown. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_planet_inject(const toliman_planet *planets,
                                                                    const toliman_planet_cell *cell,
                                                                    uint32_t *detected) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
