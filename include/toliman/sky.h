/* libtoliman, sky: the separation of a binary as an observer sees it.
 *
 * Data flow (functions toliman_sky_...)
 *
 *   system file or "alpha-cen", observer file -> create -> toliman_sky
 *                                                 |
 *   TAI times [count]          -> predict --------+-> toliman_sky_prediction [count]
 *   exposures [count]          -> predict_mean ---+-> toliman_sky_prediction [count]
 *   measured separations       -> reduce ---------+-> reduced separations (both measure.h)
 *   measured separations       -> refit ----------+-> toliman_sky with another orbit -> save_file -> system file
 *                                                 +-> set_columns -> toliman_period_options (period_nuisance.h)
 *                                                 +-> diagnose (sky_diagnosis.h)
 *                                                 +-> get_info, get_element
 *                                              destroy
 *
 * The measured separation of alpha Centauri differs from the true one. Differential aberration by the Earth's velocity
 * contributes 746 uas with a period of one year; by the spacecraft's velocity, 205 to 257 uas every 97 minutes.
 * Parallax contributes 44 uas and light time 2.5 uas. A planet like the Earth moves a star by 2.5 uas.
 *
 * Reduction (toliman_sky_reduce): divide a measured separation by `factor` and subtract `geometric_arcsec`. The
 * residual contains planets, the error of the orbit and noise. Do not subtract `separation_arcsec`: with the published
 * errors of the elements, that leaves an annual residual of 0.36 uas (median; 95th percentile 1.4 uas). Division leaves
 * 0.08 uas (0.26 uas).
 *
 * Conventions
 *
 *   System      Elements of the orbit of B about A in three dimensions, place, parallax and motion of the barycentre
 *               on the axes of the ICRS, masses. The node must be the ascending one, at which B recedes. The
 *               descending node causes an annual error of 34.5 uas (alpha Centauri).
 *   Time        Nanoseconds of TAI since 1970-01-01T00:00:00 TAI, of the years 1900 to 2100. TAI is
 *               37 s ahead of UTC, and so of Unix time: 10 uas in a low orbit. A camera usually stamps the start of
 *               an exposure: predict its mean from start to end. Dates in a system file are Julian years of TDB at the
 *               barycentre of the solar system; light time from the catalogue distance is not subtracted.
 *   Apparent    Angle between the directions of A and B, each where it was when its light left it, seen from the
 *               observer's place, bent by the Sun, and changed by the exact aberration of the observer's velocity.
 *   Geometric   Length of the projection of the orbit on the tangential plane, at the barycentric time. "factor" is
 *               apparent over geometric.
 *   Accuracy    Predictions are within 1e-4 uas of the same equations in 50 digits
 *               (promise: predictions-keep-their-digits). The velocity of the Earth is within 5 mm/s of DE405, which is
 *               1.7e-4 uas. sky.md lists the effects that are omitted ("Omitted effects").
 *   Observer    An observer file has positions and velocities relative to the Earth's centre, on the axes of the ICRS
 *               (GCRF, EME2000). It has at least 8 states, in a low orbit at most 300 s apart. The axes TEME and ITRF
 *               are refused (promise: other-axes-are-refused). A circular orbit has an arbitrary phase. */
#ifndef TOLIMAN_SKY_H
#define TOLIMAN_SKY_H

#include <toliman/base.h>
#include <toliman/goodness.h>
#include <toliman/ingest.h>
#include <toliman/measure.h>
#include <toliman/period.h>

TOLIMAN_BEGIN_DECLS

/* Predictor for a binary and an observer. Several threads may use it at the same time. */
typedef struct toliman_sky toliman_sky;

/* Number of orbital elements. */
#define TOLIMAN_SKY_ELEMENTS 7u

/* Effects that toliman_sky_options.without leaves out. The sizes are those for alpha Centauri from 2027 to 2030: the
 * amplitude of periodic effects, and the change in these three years of secular ones. */
#define TOLIMAN_SKY_EARTH_ABERRATION 1u      /* the Earth's velocity: 746 uas, annual */
#define TOLIMAN_SKY_SPACECRAFT_ABERRATION 2u /* the observer's velocity about the Earth: 205 to 257 uas in 97 min */
#define TOLIMAN_SKY_PARALLAX 4u              /* the observer's place: 44 uas, annual */
#define TOLIMAN_SKY_ROEMER 8u                /* light time to the barycentre of the solar system: 2.5 uas */
#define TOLIMAN_SKY_LIGHT_TIME 16u           /* light time between the stars: 292 uas, secular */
#define TOLIMAN_SKY_RADIAL_MOTION 32u        /* of the barycentre: 304 uas, secular */
#define TOLIMAN_SKY_TRANSVERSE_MOTION 64u    /* of the barycentre: 77 uas, secular */
#define TOLIMAN_SKY_DEFLECTION 128u          /* of light by the Sun: 0.8 uas, in November */

/* Options of a predictor. */
typedef struct toliman_sky_options {
    uint32_t struct_size;
    uint32_t without; /* sum of the TOLIMAN_SKY_... that are left out, in [0, 255] */
    /* Observer: one of observer and altitude_km, or none for the Earth's centre. */
    const char *observer; /* path of an observer file: OEM, CSV, Horizons (formats.md, "Observer files"); may be NULL */
    double altitude_km; /* altitude of a circular sun-synchronous orbit, for simulations, in [200, 2000] km; 0 = none */
    double node_hours;  /* local mean time at its ascending node, in (0, 24] h; 0 = 18 h, a dawn-dusk orbit */
    const toliman_leap_second *leap_seconds; /* [leap_second_count], for observer files in UTC; NULL if it is 0 */
    size_t leap_second_count;                /* rows of the table; 0 = the table of ERFA */
    toliman_log_fn log;                      /* receives warnings, during create only; may be NULL */
    void *log_data;
} toliman_sky_options;
#define TOLIMAN_SKY_OPTIONS_INIT TOLIMAN_INIT(toliman_sky_options)

/* Creates the predictor of a system.
 *   system   "alpha-cen" (Akeson et al. 2021), the path of a system file (schema toliman-system/1), or the JSON text
 *            of a system. The first character of a JSON text that is not a blank is "{"
 *   options  NULL = the defaults: all effects, at the Earth's centre. Without an observer, a warning states by how many
 *            uas the velocity of a spacecraft in a low orbit changes the separation of this system
 * The caller destroys *out. Errors: TOLIMAN_E_NOT_FOUND; TOLIMAN_E_SCENE, with file and key, for a bad system;
 * TOLIMAN_E_FORMAT, with file, line and reason, for a bad observer file and a system that is not JSON;
 * TOLIMAN_E_ARGUMENT. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_create(const char *system, const toliman_sky_options *options,
                                                                 toliman_sky **out) TOLIMAN_NOEXCEPT;

/* Destroys a predictor. NULL is allowed. */
TOLIMAN_API void toliman_sky_destroy(toliman_sky *sky) TOLIMAN_NOEXCEPT;

/* What an observer sees at a time, or in the mean of intervals. */
typedef struct toliman_sky_prediction {
    uint32_t struct_size; /* in: sizeof(toliman_sky_prediction) */
    uint32_t reserved;
    double separation_arcsec;    /* apparent separation */
    double position_angle_deg;   /* apparent position angle of B from A, north through east, -180 to 180, ICRS */
    double geometric_arcsec;     /* separation on the orbit */
    double geometric_angle_deg;  /* position angle on the orbit */
    double factor;               /* separation_arcsec / geometric_arcsec */
    double barycentric_offset_s; /* barycentric time (TDB) minus TAI, s: time at which the light of the system's
                                    barycentre arrives at that of the solar system; without ROEMER, TDB - TAI */
    double approach_m_s;         /* velocity of the observer towards the system, without the effects left out */
    double sun_angle_deg;        /* angle between the system and the Sun */
    double partials[7];          /* derivatives of separation_arcsec by the elements, divided by factor: those of a
                                    reduced separation. arcsec per unit of the element */
} toliman_sky_prediction;
#define TOLIMAN_SKY_PREDICTION_INIT TOLIMAN_INIT(toliman_sky_prediction)

/* Predicts the separation at times.
 *   tai_ns       [count]
 *   predictions  [count], with the struct_size of predictions[0] set
 * A prediction takes 5 to 9 us; the first one in a day up to 400 us. 100 bytes per day are kept.
 * Errors: TOLIMAN_E_RANGE, naming the time and the covered times, if the observer file has no state for it, and outside
 * the years 1900 to 2100; TOLIMAN_E_ARGUMENT if all times are within 50 days after 1970-01-01 and one of them is not a
 * whole second. So times in seconds, ms, us or days are refused (promise: time-units-are-checked), by all
 * functions. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_predict(const toliman_sky *sky, const int64_t *tai_ns,
                                                                  size_t count,
                                                                  toliman_sky_prediction *predictions) TOLIMAN_NOEXCEPT;

/* Predicts the means over exposures, that is over their on-target intervals, each weighted with its length: the
 * photon rate is assumed constant. With an observer in a low orbit, the prediction for mid-exposure differs from this
 * mean by 0.18 uas in 120 s, 4.4 uas in 600 s and up to 245 uas in a day.
 *   intervals        [sum of interval_counts][2], on-target intervals of the exposures, start and end, TAI ns; those of
 *                    an exposure in any order. For an observer at the Earth's centre, a single interval may
 *                    have zero length (an instant)
 *   interval_counts  [count], number of intervals of each; NULL: one for each, from the start to the end of an exposure
 *                    whose on-target intervals are not known
 *   predictions      [count], with the struct_size of predictions[0] set; factor is the ratio of the mean separations.
 *                    All numbers are NaN for an exposure that the observer file does not cover completely
 * Errors, after which nothing is written: TOLIMAN_E_ARGUMENT, naming the exposure if there are several, for one
 * without an interval, or if an interval does not begin before it ends, overlaps another or exceeds 400 days, and for
 * exposures that toliman_sky_reduce refuses; TOLIMAN_E_RANGE outside the years 1900 to 2100. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status
toliman_sky_predict_mean(const toliman_sky *sky, const int64_t *intervals, const size_t *interval_counts, size_t count,
                         toliman_sky_prediction *predictions) TOLIMAN_NOEXCEPT;

/* Flag of toliman_sky_reduce_options: no functions for the errors of the orbit. */
#define TOLIMAN_SKY_NO_FUNCTIONS 1u

/* Options of a reduction. */
typedef struct toliman_sky_reduce_options {
    uint32_t struct_size;
    uint32_t flags;     /* TOLIMAN_SKY_NO_FUNCTIONS */
    double scale_sigma; /* standard deviation of the relative error of the plate scale, in [0, 1) */
    toliman_log_fn log; /* receives warnings; may be NULL */
    void *log_data;
} toliman_sky_reduce_options;
#define TOLIMAN_SKY_REDUCE_OPTIONS_INIT TOLIMAN_INIT(toliman_sky_reduce_options)

/* Reduces measured separations to the orbit: reduced = measured/factor - geometric_arcsec, of toliman_sky_predict_mean
 * over the exposure, in the unit of the series.
 *   measured  of kind TOLIMAN_MEASURE_SEPARATION, with exposures; the unit of separations in px is the plate scale
 *   options   may be NULL
 *   out       receives the reduced series, of kind TOLIMAN_MEASURE_REDUCED, with position angles; the caller destroys
 *             it
 * Measurements whose exposure the observer file does not cover are left out and counted
 * (promise: uncovered-exposures-are-left-out): left_out of toliman_measure_info. A series without functions, but
 * offsets, gets those of the errors of the orbit: the derivative by each element with a standard deviation, which is
 * its prior, increased by scale_sigma for the semi-major axis. Without such standard deviations, or without sigmas, it
 * gets a trend of order 4, with a warning.
 * If the observer is in orbit, two kinds of exposures are refused (promise: unknown-exposures-are-refused):
 *   - a single interval of zero length. The prediction for an instant is wrong by up to 245 uas;
 *   - one whose on-target intervals are not known, longer than 600 s. The telescope points elsewhere during a part of
 *     it, and the mean from its start to its end is wrong by up to 245 uas.
 * The median of the measured separations must be within a factor of 2 of the predicted ones: values in mas, uas, rad,
 * deg, or px without their unit are refused (promise: separation-units-are-checked). Errors:
 * TOLIMAN_E_ARGUMENT, naming the measurement, for these; otherwise as toliman_sky_predict_mean;
 * TOLIMAN_E_RANGE if no measurement is left. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_reduce(const toliman_sky *sky,
                                                                 const toliman_measure *measured,
                                                                 const toliman_sky_reduce_options *options,
                                                                 toliman_measure **out) TOLIMAN_NOEXCEPT;

/* Observers. */
#define TOLIMAN_SKY_OBSERVER_EARTH 701    /* centre of the Earth */
#define TOLIMAN_SKY_OBSERVER_CIRCULAR 702 /* circular orbit */
#define TOLIMAN_SKY_OBSERVER_FILE 703     /* observer file */

/* Properties of a predictor. */
typedef struct toliman_sky_info {
    uint32_t struct_size;      /* in: sizeof(toliman_sky_info) */
    uint32_t without;          /* effects that are left out */
    int32_t observer;          /* TOLIMAN_SKY_OBSERVER_... */
    int32_t segments;          /* of the observer file; 0 without one */
    int64_t first_ns, last_ns; /* first and last usable time of the observer file; 0 without one */
    uint64_t orbit_digest;     /* FNV-1a hash of the orbital elements: the reference orbit of geometric_arcsec */
    char name[72];             /* name of the system; "" if the file has none */
    double parallax_arcsec;    /* of the barycentre */
    double star_mass[2];       /* of A and B, solar masses */
    uint64_t states;           /* of the observer file; 0 without one */
    /* Orbit of the observer; all 0 at the Earth's centre. */
    double altitude_km[2];  /* lowest and highest of all states, above 6378.137 km */
    double inclination_deg; /* at the first state, as what follows: to the equator; above 90: retrograde */
    double node_deg;        /* right ascension of the ascending node; 0 for a circular orbit */
    double node_hours;      /* local mean time at the ascending node, in [0, 24) h */
    double orbit_minutes;   /* period; NaN if the orbit does not return */
} toliman_sky_info;
#define TOLIMAN_SKY_INFO_INIT TOLIMAN_INIT(toliman_sky_info)

/* Writes the properties to *out, whose struct_size must be set. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_get_info(const toliman_sky *sky,
                                                                   toliman_sky_info *out) TOLIMAN_NOEXCEPT;

/* Elements of the orbit, in the order of the derivatives of a prediction. toliman_constant_name gives the name with the
 * unit: "period_years". */
#define TOLIMAN_SKY_ELEMENT_PERIOD 731
#define TOLIMAN_SKY_ELEMENT_SEMI_MAJOR 732
#define TOLIMAN_SKY_ELEMENT_ECCENTRICITY 733
#define TOLIMAN_SKY_ELEMENT_INCLINATION 734
#define TOLIMAN_SKY_ELEMENT_NODE 735
#define TOLIMAN_SKY_ELEMENT_PERIASTRON 736
#define TOLIMAN_SKY_ELEMENT_EPOCH 737 /* Julian year */

/* Writes the value of an element, TOLIMAN_SKY_ELEMENT_..., and its standard deviation, 0 if unknown. value and sigma
 * may be NULL. Errors: TOLIMAN_E_RANGE for an unknown element. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_get_element(const toliman_sky *sky, int32_t element,
                                                                      double *value, double *sigma) TOLIMAN_NOEXCEPT;

/* Declares the errors of the reference orbit as nuisance functions of a periodogram of reduced separations (see
 * period_nuisance.h). Each element with a standard deviation is a column: its value for a sample is
 * partials[element] of the prediction of toliman_sky_reduce, the coefficient is the error of the element, and its prior
 * is the standard deviation in the system file.
 *   unit_arcsec  arcsec per unit of the values of the periodogram: 1, or the plate scale for pixels
 *   scale_sigma  standard deviation of the relative error of the plate scale, in [0, 1); 0 = no error. It changes the
 *                separation as an error of the semi-major axis does, and is added to the variance of that
 *   options      receives columns, column_bound and the precisions of the columns in prior_precision, after those of
 *                the mean and of its trend; its other members remain. Its struct_size must be set
 *   elements     [7], receives the index in partials of the element of each column; -1 after the last one
 * The sigmas of the samples must be absolute. Errors: TOLIMAN_E_ARGUMENT for a bad number, or if trend and columns
 * exceed 8 functions. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_set_columns(const toliman_sky *sky, double unit_arcsec,
                                                                      double scale_sigma,
                                                                      toliman_period_options *options,
                                                                      int32_t *elements) TOLIMAN_NOEXCEPT;

/* Flag of toliman_sky_refit_result: chi_square is poor and above 3. No jitter excuses it: times, unit or sigmas are
 * wrong, or the model of the frames lacks an effect. The new orbit must not be used. */
#define TOLIMAN_SKY_UNUSABLE 1u

/* Result of a refit. */
typedef struct toliman_sky_refit_result {
    uint32_t struct_size;  /* in: sizeof(toliman_sky_refit_result) */
    int32_t iterations;    /* number of Gauss-Newton steps */
    double chi_square;     /* as in goodness.h, of the measurements and their sigmas without the jitter */
    double rms_arcsec;     /* rms of the residuals */
    double scale;          /* relative error of the plate scale: measured = (1 + scale) true */
    double scale_sigma;    /* its standard deviation */
    double covariance[49]; /* [7][7], of the elements, in their units */
    double chi_square_sigma, largest_residual; /* as in goodness.h */
    double jitter_arcsec; /* white noise that is added to the sigmas if chi_square is poor, so that the errors are those
                             of the residuals; otherwise 0 */
    int32_t goodness;     /* TOLIMAN_GOODNESS_... of chi_square */
    uint32_t flags;       /* TOLIMAN_SKY_UNUSABLE */
    uint32_t left_out;    /* measurements for which the observer file has no states */
    uint32_t outliers; /* measurements farther than 6 robust standard deviations, at least their sigmas, from the fit:
                          they do not belong to the others */
} toliman_sky_refit_result;
#define TOLIMAN_SKY_REFIT_RESULT_INIT TOLIMAN_INIT(toliman_sky_refit_result)

/* Refits the orbital elements to measured separations. The standard deviations of the elements in the system file are
 * Gaussian priors (maximum a posteriori). Elements without one keep their
 * values; parallax, motion and masses are not fitted. Only the priors distinguish an error of the plate scale from one
 * of the semi-major axis.
 *   sky          system and observer
 *   measured     as for toliman_sky_reduce, with sigmas
 *   scale_sigma  standard deviation of the relative error of the plate scale, in [0, 1); 0 = no error
 *   result       receives errors and residuals, with its struct_size set; must not be NULL
 *   out          receives the predictor of the new orbit, with the errors after the fit; the caller destroys it
 * A saved file has the standard deviations of the elements, but not their correlations. To add measurements, refit the
 * original system to all of them.
 * Errors, after which neither result nor out is written:
 *   - TOLIMAN_E_ARGUMENT, naming the measurement, for those that toliman_sky_reduce refuses, and without sigmas;
 *   - TOLIMAN_E_ARGUMENT if no element has a standard deviation, if the fit is singular or does not
 *     converge, if it moves an element by more than 10 of its standard deviations, and if the fitted orbit is outside
 *     the limits of a system file;
 *   - TOLIMAN_E_RANGE if no measurement is left: those that the observer file does not cover are left out. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_refit(const toliman_sky *sky, const toliman_measure *measured,
                                                                double scale_sigma, toliman_sky_refit_result *result,
                                                                toliman_sky **out) TOLIMAN_NOEXCEPT;

/* Writes the system to a file (schema toliman-system/1), replacing it atomically. Errors: TOLIMAN_E_WRITE.
 */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_save_file(const toliman_sky *sky,
                                                                    const char *path) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
