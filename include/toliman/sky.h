/* libtoliman, sky: the separation of a binary as an observer sees it.
 *
 * Data flow (toliman_sky_...)
 *
 *   system, observer file -> create -> toliman_sky -> get_info, get_element, destroy
 *   TAI times, exposures -> predict, predict_mean -> toliman_sky_prediction
 *   measured separations (measure.h) -> reduce -> reduced separations
 *                                       refit -> toliman_sky of another orbit -> save_file -> system file
 *                                       diagnose (sky_diagnosis.h)
 *   set_columns -> toliman_period_options (period_nuisance.h)
 *
 * A reduced separation, measured/factor - geometric_arcsec, contains planets, the error of the orbit and noise. Do not
 * subtract separation_arcsec: errors of the elements would leave an annual residual.
 *
 * System       Elements of the orbit of B about A, with the ascending node, at which B recedes; place, parallax and
 *              motion of the barycentre on the axes of the ICRS; masses. Dates are Julian years of TDB at the
 *              barycentre of the solar system: the light time from the system is not subtracted.
 * Time         TAI nanoseconds of the years 1900 to 2100.
 * Apparent     Angle between A and B at the observer's place, each star where it was when its light left it, with the
 *              deflection by the Sun and the aberration by the observer's velocity.
 * Geometric    Length of the projection of the orbit on the tangential plane, at the barycentric time.
 * Accuracy     Predictions are within 1e-4 uas of the same equations in 50 digits
 *              (promise: predictions-keep-their-digits); omitted effects: sky.md.
 * Observer     States relative to the Earth's centre, on the axes of the ICRS (GCRF, EME2000); in a low orbit at most
 *              300 s apart. The axes TEME and ITRF are refused (promise: other-axes-are-refused). An exposure is
 *              "uncovered" if states are missing for a part of it. */
#ifndef TOLIMAN_SKY_H
#define TOLIMAN_SKY_H

#include <toliman/base.h>
#include <toliman/goodness.h>
#include <toliman/ingest.h>
#include <toliman/measure.h>
#include <toliman/period.h>
#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Predictor for a binary and an observer. */
typedef struct toliman_sky toliman_sky;

/* Number of orbital elements. */
#define TOLIMAN_SKY_ELEMENTS 7u

/* Effects; sizes: sky.md. */
#define TOLIMAN_SKY_EARTH_ABERRATION 1u      /* by the Earth's velocity, annual */
#define TOLIMAN_SKY_SPACECRAFT_ABERRATION 2u /* by the velocity of the spacecraft about the Earth */
#define TOLIMAN_SKY_PARALLAX 4u              /* annual */
#define TOLIMAN_SKY_ROEMER 8u                /* light time to the barycentre of the solar system */
#define TOLIMAN_SKY_LIGHT_TIME 16u           /* between the stars, secular */
#define TOLIMAN_SKY_RADIAL_MOTION 32u        /* of the barycentre, likewise */
#define TOLIMAN_SKY_TRANSVERSE_MOTION 64u    /* of the barycentre, likewise */
#define TOLIMAN_SKY_DEFLECTION 128u          /* of light by the Sun */

/* Options of a predictor. */
typedef struct toliman_sky_options {
    uint32_t struct_size;
    uint32_t without; /* effects TOLIMAN_SKY_... to leave out, in [0, 255] */
    /* Observer: one of observer and altitude_km, or none for the Earth's centre, with a warning */
    const char *observer;                    /* path: OEM, CSV, Horizons (formats.md, "Observer files") */
    double altitude_km;                      /* circular sun-synchronous orbit, for simulations, in [200, 2000] km; 0
                                                = none */
    double node_hours;                       /* local mean time at the ascending node, in (0, 24] h; 0 = 18 h, a
                                                dawn-dusk orbit */
    const toliman_leap_second *leap_seconds; /* [leap_second_count], for observer files in UTC */
    size_t leap_second_count;                /* 0 = those of ERFA */
    toliman_log_fn log;                      /* receives warnings */
    void *log_data;
    const toliman_sim *scene; /* with system NULL and no observer: its binary.orbit and binary.observer; not needed
                                 afterwards. NULL = none */
} toliman_sky_options;
#define TOLIMAN_SKY_OPTIONS_INIT TOLIMAN_INIT(toliman_sky_options)

/* Creates the predictor of a system.
 *   system  "alpha-cen" (Akeson et al. 2021), path of a system file (schema toliman-system/1), or JSON text of a
 *           system, which begins with "{"; NULL: that of options->scene
 * Errors: TOLIMAN_E_SCENE, with file and key: bad system; TOLIMAN_E_UNSUPPORTED: the scene has no observer. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_create(const char *system, const toliman_sky_options *options,
                                                                 toliman_sky **out) TOLIMAN_NOEXCEPT;

/* Destroys a predictor. */
TOLIMAN_API void toliman_sky_destroy(toliman_sky *sky) TOLIMAN_NOEXCEPT;

/* Prediction for a time, or for the mean of intervals. */
typedef struct toliman_sky_prediction {
    uint32_t struct_size;
    uint32_t reserved;
    double separation_arcsec;
    double position_angle_deg;   /* apparent, of B from A (sim.h, "Angle"), -180 to 180, ICRS */
    double geometric_arcsec;     /* on the orbit */
    double geometric_angle_deg;  /* on the orbit */
    double factor;               /* separation_arcsec/geometric_arcsec */
    double barycentric_offset_s; /* TDB when light of the system's barycentre arrives at that of the solar system,
                                    minus TAI */
    double approach_m_s;         /* velocity of the observer towards the system, by the motions not left out */
    double sun_angle_deg;        /* between system and Sun */
    double partials[7];          /* of separation_arcsec by the elements, divided by factor; arcsec per unit */
} toliman_sky_prediction;
#define TOLIMAN_SKY_PREDICTION_INIT TOLIMAN_INIT(toliman_sky_prediction)

/* Predicts the separation at times tai_ns[count].
 * Errors: TOLIMAN_E_RANGE, naming time and covered times: no state in the observer file, or outside 1900 to 2100.
 * TOLIMAN_E_ARGUMENT: times in s, ms, us or days, which all functions refuse: all within 50 days after 1970-01-01, and
 * one not a whole second (promise: time-units-are-checked). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_predict(const toliman_sky *sky, const int64_t *tai_ns,
                                                                  size_t count,
                                                                  toliman_sky_prediction *predictions) TOLIMAN_NOEXCEPT;

/* Predicts the means over the on-target intervals of exposures, weighted with their lengths.
 *   intervals        [sum of interval_counts][2], start and end, TAI ns; in any order within an exposure; at the
 *                    Earth's centre also of zero length
 *   interval_counts  [count], of each exposure; NULL: one each, start and end of an exposure whose on-target intervals
 *                    are not known
 *   predictions      [count]; factor is the ratio of the means. NaN for an uncovered exposure
 * Errors: TOLIMAN_E_ARGUMENT, naming the exposure: no interval, or intervals that are reversed, overlap, exceed 400
 * days, or are refused by toliman_sky_reduce; TOLIMAN_E_RANGE outside 1900 to 2100. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_sky_predict_mean(const toliman_sky *sky, const int64_t *intervals, const size_t *interval_counts, size_t count,
                         toliman_sky_prediction *predictions) TOLIMAN_NOEXCEPT;

/* Flag: no functions for the errors of the orbit. */
#define TOLIMAN_SKY_NO_FUNCTIONS 1u

/* Options of a reduction. */
typedef struct toliman_sky_reduce_options {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_SKY_NO_FUNCTIONS */
    double scale_sigma; /* standard deviation of the relative error of the plate scale, in [0, 1) */
    toliman_log_fn log; /* receives warnings */
    void *log_data;
} toliman_sky_reduce_options;
#define TOLIMAN_SKY_REDUCE_OPTIONS_INIT TOLIMAN_INIT(toliman_sky_reduce_options)

/* Reduces measured separations to the orbit, in the unit of the series, with the factors of toliman_sky_predict_mean.
 *   measured  TOLIMAN_MEASURE_SEPARATION, with exposures; the unit of px is the plate scale
 *   out       TOLIMAN_MEASURE_REDUCED, with position angles
 * Uncovered exposures are left out and counted (promise: uncovered-exposures-are-left-out) in
 * toliman_measure_info.left_out. If the series has no functions other than offsets of instruments, it gets those of the
 * errors of the orbit (toliman_sky_set_columns). Without sigmas, or without standard deviations of elements, it gets a
 * trend of order 4 and a warning is logged.
 * Errors: as toliman_sky_predict_mean; TOLIMAN_E_RANGE no measurement is left; TOLIMAN_E_ARGUMENT, naming the
 * measurement:
 *   - for an observer in orbit, two kinds of exposures are refused (promise: unknown-exposures-are-refused): a single
 *     interval of zero length, and more than 600 s without on-target intervals;
 *   - a median more than a factor of 2 from the predictions: values in mas, uas, rad, deg, or px without their unit are
 *     refused (promise: separation-units-are-checked). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_reduce(const toliman_sky *sky,
                                                                 const toliman_measure *measured,
                                                                 const toliman_sky_reduce_options *options,
                                                                 toliman_measure **out) TOLIMAN_NOEXCEPT;

#define TOLIMAN_SKY_OBSERVER_EARTH 701 /* centre of the Earth */
#define TOLIMAN_SKY_OBSERVER_CIRCULAR 702
#define TOLIMAN_SKY_OBSERVER_FILE 703

/* Properties of a predictor. */
typedef struct toliman_sky_info {
    uint32_t struct_size;
    uint32_t without;
    int32_t observer;
    int32_t segments;          /* of the observer file; else 0 */
    int64_t first_ns, last_ns; /* usable times of the observer file; else 0 */
    uint64_t orbit_digest;     /* hash of the elements */
    char name[72];             /* of the system; may be "" */
    double parallax_arcsec;    /* of the barycentre */
    double star_mass[2];       /* of A and B, solar masses */
    uint64_t states;           /* of the observer file; else 0 */
    /* Orbit of the observer at its first state; all 0 at the Earth's centre */
    double altitude_km[2];  /* lowest and highest of all states, above 6378.137 km */
    double inclination_deg; /* to the equator; above 90: retrograde */
    double node_deg;        /* right ascension of the ascending node; 0 for a circular orbit */
    double node_hours;      /* local mean time there, in [0, 24) h */
    double orbit_minutes;   /* period; NaN if the orbit does not return */
} toliman_sky_info;
#define TOLIMAN_SKY_INFO_INIT TOLIMAN_INIT(toliman_sky_info)
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_get_info(const toliman_sky *sky,
                                                                   toliman_sky_info *out) TOLIMAN_NOEXCEPT;

/* Elements of the orbit, in the order of partials. toliman_constant_name gives name and unit: "period_years". */
#define TOLIMAN_SKY_ELEMENT_PERIOD 731
#define TOLIMAN_SKY_ELEMENT_SEMI_MAJOR 732
#define TOLIMAN_SKY_ELEMENT_ECCENTRICITY 733
#define TOLIMAN_SKY_ELEMENT_INCLINATION 734
#define TOLIMAN_SKY_ELEMENT_NODE 735
#define TOLIMAN_SKY_ELEMENT_PERIASTRON 736
#define TOLIMAN_SKY_ELEMENT_EPOCH 737 /* Julian year */

/* Writes an element, TOLIMAN_SKY_ELEMENT_..., and its standard deviation, 0 if unknown. value and sigma may be NULL. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_get_element(const toliman_sky *sky, int32_t element,
                                                                      double *value, double *sigma) TOLIMAN_NOEXCEPT;

/* Declares the errors of the orbit as nuisance functions of a periodogram of reduced separations (period_nuisance.h): a
 * column with partials[element] of each sample's prediction per element with a standard deviation, its prior. Sigmas
 * must be absolute.
 *   unit_arcsec  arcsec per unit of the values: 1, or the plate scale for px
 *   scale_sigma  as toliman_sky_reduce_options; increases the standard deviation of the semi-major axis
 *   options      receives columns, column_bound and, after mean and trend, prior_precision
 *   elements     [7], index in partials of each column; -1 after the last one */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_set_columns(const toliman_sky *sky, double unit_arcsec,
                                                                      double scale_sigma,
                                                                      toliman_period_options *options,
                                                                      int32_t *elements) TOLIMAN_NOEXCEPT;

/* Flag: chi_square is poor and above 3. Do not use the new orbit: times, unit, sigmas or the model of the frames are
 * wrong. */
#define TOLIMAN_SKY_UNUSABLE 1u

/* Result of a refit. */
typedef struct toliman_sky_refit_result {
    uint32_t struct_size;
    int32_t iterations;
    double chi_square; /* goodness.h, without the jitter */
    double rms_arcsec;
    double scale; /* relative error of the plate scale: measured = (1 + scale) true */
    double scale_sigma;
    double covariance[49]; /* [7][7], of the elements */
    double chi_square_sigma, largest_residual;
    double jitter_arcsec; /* white noise added to the sigmas; 0 unless chi_square is poor */
    int32_t goodness;
    uint32_t flags;
    uint32_t left_out; /* uncovered */
    uint32_t outliers; /* farther than 6 robust standard deviations, at least their sigmas, from the fit */
} toliman_sky_refit_result;
#define TOLIMAN_SKY_REFIT_RESULT_INIT TOLIMAN_INIT(toliman_sky_refit_result)

/* Refits the orbital elements to measured separations, with the standard deviations of the system file as Gaussian
 * priors. Elements without one, parallax, motion and masses are fixed. To add measurements, refit the original system
 * to all of them. The new orbit has absorbed a part of the planets with long periods: toliman_planet_create and another
 * refit refuse measurements of the same dates with it (promise: refitted-orbits-are-not-searched).
 *   measured     as for toliman_sky_reduce, with sigmas
 *   scale_sigma  as toliman_sky_reduce_options; only priors distinguish this error from one of the semi-major axis
 *   out          predictor of the new orbit, with the errors after the fit
 * Errors: as toliman_sky_reduce; TOLIMAN_E_ARGUMENT also for no sigmas, no standard deviation of an element, or a fit
 * that is singular, does not converge, moves an element by more than 10 standard deviations or leaves the limits of a
 * system file. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_refit(const toliman_sky *sky, const toliman_measure *measured,
                                                                double scale_sigma, toliman_sky_refit_result *result,
                                                                toliman_sky **out) TOLIMAN_NOEXCEPT;

/* Writes the system to a file (schema toliman-system/1). */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_save_file(const toliman_sky *sky,
                                                                    const char *path) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
