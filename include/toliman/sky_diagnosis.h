/* libtoliman, sky diagnosis: the mistake that explains why separations do not agree with their predictions.
 *
 * Data flow
 *
 *   toliman_sky (sky.h), measured separations (measure.h) -> diagnose -> toliman_sky_diagnosis, _hypothesis [7]
 *
 * In a low orbit, wrong times or axes leave residuals of a known shape; planets leave another one. A cause is named
 * only if its significance, sqrt(gain/max(1, chi_square)), is at least 7 (promise: causes-need-seven-sigmas). */
#ifndef TOLIMAN_SKY_DIAGNOSIS_H
#define TOLIMAN_SKY_DIAGNOSIS_H

#include <toliman/goodness.h>
#include <toliman/sky.h>

TOLIMAN_BEGIN_DECLS

/* Causes of residuals. TIME to CENTRE are the hypotheses, in the order of the array. All but SCALE need an observer in
 * orbit.
 *   NONE        no hypothesis explains the residuals
 *   TIME        all times are late by a common offset, s
 *   AXES        the observer's axes are exchanged or reversed, or those of the ecliptic or of date
 *   ROTATION_X  the observer's states are rotated about the axis x of the ICRS, deg; likewise _Y and _Z
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

/* A hypothesis, fitted alone with the errors of the elements and, except for SCALE, a mean and two harmonics of a year.
 *
 * Sign of times: given minus true time. TAI read as UTC: +37 s; starts of 60 s exposures taken for their middles: -30
 * s. Errors of the times in the observer file have the opposite sign. */
typedef struct toliman_sky_hypothesis {
    uint32_t struct_size;
    int32_t cause;
    double value;        /* s, deg or relative; NaN for AXES and CENTRE */
    double sigma;        /* of value, from the residuals; NaN likewise */
    double chi_square;   /* per degree of freedom, if the hypothesis is true; NaN if not tested */
    double gain;         /* reduction of the sum of squared residuals and priors */
    double significance; /* sqrt(gain/max(1, chi_square)); 0 if not tested */
    int32_t is_decisive; /* 1 if significance is at least 7, and at least 5 measurements share the gain */
    int32_t reserved;
    char text[160]; /* "times are late by 37.0 +- 0.2 s: TAI taken for UTC?" */
} toliman_sky_hypothesis;
#define TOLIMAN_SKY_HYPOTHESIS_INIT TOLIMAN_INIT(toliman_sky_hypothesis)

/* Result of a diagnosis. */
typedef struct toliman_sky_diagnosis {
    uint32_t struct_size;
    int32_t cause;     /* simplest of the decisive hypotheses that explain the residuals equally well */
    double chi_square; /* goodness.h, without a hypothesis; priors included */
    double chi_square_sigma;
    double largest_residual;
    int32_t goodness;
    int32_t reserved;
    uint64_t used; /* measurements */
} toliman_sky_diagnosis;
#define TOLIMAN_SKY_DIAGNOSIS_INIT TOLIMAN_INIT(toliman_sky_diagnosis)

/* Finds the mistake that explains the residuals of measured separations about their predictions.
 *   measured     as for toliman_sky_refit
 *   scale_sigma  as toliman_sky_reduce_options; SCALE tests a larger error
 *   hypotheses   [TOLIMAN_SKY_HYPOTHESES]; NULL: goodness only, cause NONE
 * Uses at most 4096 covered measurements, evenly spread. With fewer than 30, no hypothesis is tested. Shifts of time
 * are tested up to 25 h. Takes 1 ms per measurement.
 * Errors: as toliman_sky_refit for measured; toliman_sky_predict_mean. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sky_diagnose(const toliman_sky *sky,
                                                                   const toliman_measure *measured, double scale_sigma,
                                                                   toliman_sky_diagnosis *result,
                                                                   toliman_sky_hypothesis *hypotheses) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
