/* libtoliman, sky diagnosis: the mistake that explains why separations do not agree with their predictions.
 *
 * Data flow
 *
 *   toliman_sky (sky.h), measured separations (measure.h) -> diagnose -> toliman_sky_diagnosis
 *                                                               +-> toliman_sky_hypothesis [7]
 *
 * The velocity of an observer in a low orbit changes the separation of alpha Centauri by 205 to 257 uas every 97
 * minutes. A mistake in times or in the axes of the observer file therefore leaves residuals of a known shape: times
 * that are late by 37 s leave 10 uas. A planet leaves another shape, and other residuals count as noise. A cause is
 * named only if it explains the residuals by at least 7 standard deviations of what it leaves
 * (promise: causes-need-seven-sigmas). */
#ifndef TOLIMAN_SKY_DIAGNOSIS_H
#define TOLIMAN_SKY_DIAGNOSIS_H

#include <toliman/goodness.h>
#include <toliman/sky.h>

TOLIMAN_BEGIN_DECLS

/* Causes of residuals. TIME to CENTRE are the hypotheses of toliman_sky_diagnose, in the order of its array. All but
 * SCALE need an observer in orbit.
 *   NONE        no hypothesis explains the residuals
 *   TIME        all times are late by a common offset, s
 *   AXES        the axes of the observer are exchanged or reversed, or those of the ecliptic or of date
 *   ROTATION_X  the states of the observer are turned about the axis x of the ICRS, deg; likewise _Y and _Z
 *   SCALE       relative error of the plate scale: measured = (1 + value) true
 *   CENTRE      the separations are those at the Earth's centre */
#define TOLIMAN_SKY_CAUSE_NONE 711
#define TOLIMAN_SKY_CAUSE_TIME 712
#define TOLIMAN_SKY_CAUSE_AXES 713
#define TOLIMAN_SKY_CAUSE_ROTATION_X 714
#define TOLIMAN_SKY_CAUSE_ROTATION_Y 715
#define TOLIMAN_SKY_CAUSE_ROTATION_Z 716
#define TOLIMAN_SKY_CAUSE_SCALE 717
#define TOLIMAN_SKY_CAUSE_CENTRE 718

/* Number of hypotheses. */
#define TOLIMAN_SKY_HYPOTHESES 7u

/* A hypothesis, fitted alone, with the errors of the orbital elements and, except for SCALE, a mean and two harmonics
 * of a year: times wrong by a whole number of revolutions of the observer leave residuals of that period, and so may a
 * planet.
 *
 * Sign of times: value is the given time minus the true time. It is above 0 for times that are
 * late, such as times in TAI that were read as UTC (+37 s), and below 0 for times that are early, such as starts of
 * exposures that were taken for their middles (-30 s for 60 s). An error of the times in the observer file has the
 * opposite sign. */
typedef struct toliman_sky_hypothesis {
    uint32_t struct_size; /* in: sizeof(toliman_sky_hypothesis) */
    int32_t cause;        /* TOLIMAN_SKY_CAUSE_... */
    double value;         /* s, deg or relative; NaN for AXES and CENTRE */
    double sigma;         /* standard deviation of value, with the residuals that are left; NaN for AXES and CENTRE */
    double chi_square;    /* per degree of freedom, if the hypothesis is true; NaN if it was not tested */
    double gain;          /* by which it lowers the sum of the squared residuals and priors */
    double significance;  /* sqrt(gain/max(1, chi_square)), standard deviations; 0 if it was not tested */
    int32_t is_decisive;  /* 1 if significance is at least 7, and at least 5 measurements share the gain */
    int32_t reserved;     /* 0 */
    char text[160];       /* "times are late by 37.0 +- 0.2 s: TAI taken for UTC?" */
} toliman_sky_hypothesis;
#define TOLIMAN_SKY_HYPOTHESIS_INIT TOLIMAN_INIT(toliman_sky_hypothesis)

/* Result of a diagnosis. */
typedef struct toliman_sky_diagnosis {
    uint32_t struct_size;    /* in: sizeof(toliman_sky_diagnosis) */
    int32_t cause;           /* the simplest of the decisive hypotheses that explain the residuals equally well */
    double chi_square;       /* per degree of freedom, of the residuals and priors without a hypothesis (goodness.h) */
    double chi_square_sigma; /* its standard deviation */
    double largest_residual; /* of a measurement, in standard deviations */
    int32_t goodness;        /* TOLIMAN_GOODNESS_... */
    int32_t reserved;        /* 0 */
    uint64_t used;           /* number of measurements that were used */
} toliman_sky_diagnosis;
#define TOLIMAN_SKY_DIAGNOSIS_INIT TOLIMAN_INIT(toliman_sky_diagnosis)

/* Finds the mistake that explains the residuals of measured separations about their predictions. The arguments are
 * those of toliman_sky_refit.
 *   measured            as for toliman_sky_reduce, with sigmas
 *   scale_sigma         standard deviation of the relative error of the plate scale, in [0, 1); 0 = no error. The
 *                       hypothesis SCALE tests a larger error
 *   result              receives the cause and the goodness of fit
 *   hypotheses          [TOLIMAN_SKY_HYPOTHESES], receives all hypotheses, with the struct_size of hypotheses[0] set.
 *                       NULL: only the goodness is computed; the cause is NONE
 * At most 4096 measurements are used, evenly spread over more. Those that the observer file does not cover are left
 * out. With fewer than 20, no hypothesis is tested. Shifts of time are tested up to 25 h. Takes about 25 us per
 * measurement for the goodness, and 1 ms per measurement for all hypotheses.
 * Errors: TOLIMAN_E_ARGUMENT, naming the measurement, for those that toliman_sky_reduce refuses, and without sigmas;
 * otherwise as toliman_sky_predict_mean. Nothing is then written. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_diagnose(const toliman_sky *sky,
                                                                   const toliman_measure *measured, double scale_sigma,
                                                                   toliman_sky_diagnosis *result,
                                                                   toliman_sky_hypothesis *hypotheses) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
