/* libtoliman, derivatives of a simulator's images by the parameters of its forward model.
 *
 * Data flow (functions toliman_sim_...)
 *
 *   get_parameters                                  names, units and scopes of the parameters
 *   toliman_sim, name -> get_derivative -> image[rows][cols]
 *   toliman_sim, weights[rows][cols] -> get_opd_gradient -> gradient[N][N]
 *
 * Parameters are quantities that an estimator does not assume to be known. preprocess.project of the scene lists those
 * that estimators remove (project out); it takes every name but separation. A unit change of a parameter has this
 * effect; x is towards higher columns, y towards higher rows:
 *
 *   separation          px       the star named by signal.star (A without a signal) moves away from the other one
 *   position_angle      rad      B moves around A, from x towards y; the diffraction patterns do not rotate
 *   shift_x, shift_y    px       both stars move
 *   roll                rad      both stars move around the centre of the frame, from x towards y; the diffraction
 *                                patterns do not rotate
 *   flux_a, flux_b               relative change of the photons of a star
 *   background          photons  equal light on every pixel
 *   scale                        relative stretch of the image about the centre of the frame
 *   anisotropy, shear            detector.scale_anisotropy and detector.shear: the image deforms, the stars with it
 *   focus               nm       OPD of 1 nm rms over the full aperture in Noll's fourth polynomial
 *   zernike_5 ... _36   nm       the same in the polynomial with this number
 *   mask_rotation       deg      the mask rotates, from x towards y, as telescope.mask.rotation_deg
 *   mask_shift_x, _y    m        the mask moves, as telescope.mask.shift_m
 *   jitter_xx, _yy, _xy px^2     covariance of the jitter
 *   temperature_a, _b   K        the spectrum of a star times the ratio of the black bodies of T + 1 K and T, at equal
 *                                flux. A table without a temperature has T = 5790 K for A, 5260 K for B
 *   spectrum_a_1 ... _11         coefficient of the Legendre polynomial of this degree in stars.A.spectrum.modes, at
 *                                equal flux; spectrum_b_1 ... likewise
 *   wavelength          nm       all wavelengths increase
 *
 * Everything else remains as it is: the positions of the stars, their photons in the band (also where the scene gives
 * peak_photons), the detector. Derivatives are exact, except those of the rotation and the shifts of the mask, whose
 * error is 1e-3 of their largest pixel (promise: derivatives-are-exact). */
#ifndef TOLIMAN_SIM_DERIVATIVE_H
#define TOLIMAN_SIM_DERIVATIVE_H

#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Scopes of parameters: where a parameter has one value. */
#define TOLIMAN_SIM_SCOPE_FRAME 341      /* in a frame; it varies from frame to frame */
#define TOLIMAN_SIM_SCOPE_INSTRUMENT 342 /* in all frames */

/* A parameter of the forward model. */
typedef struct toliman_sim_parameter {
    uint32_t struct_size; /* in, in the first element: sizeof(toliman_sim_parameter) */
    int32_t scope;        /* TOLIMAN_SIM_SCOPE_... */
    const char *name;     /* such as "zernike_7"; static text */
    const char *unit;     /* such as "nm", "" for a relative change; static text */
} toliman_sim_parameter;
#define TOLIMAN_SIM_PARAMETER_INIT TOLIMAN_INIT(toliman_sim_parameter)

/* Writes the parameters to parameters[capacity] and their number to *count. Later versions may append parameters.
 * TOLIMAN_E_CAPACITY if capacity is too small. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_parameters(toliman_sim_parameter *parameters,
                                                                         size_t capacity,
                                                                         size_t *count) TOLIMAN_NOEXCEPT;

/* Writes the derivative of the expected frame by the parameter with this name to image[rows][stride], in the unit of
 * the frame per unit of the parameter; stride >= cols, in elements. The simulator keeps the image: only the first call
 * for a parameter computes it.
 * Errors: TOLIMAN_E_ARGUMENT for an unknown name or a smaller stride; TOLIMAN_E_UNSUPPORTED if the scene has no such
 * derivative: flux_b, temperature_b, spectrum_b_... and position_angle of a single star; mask_... unless the mask is a
 * spiral with edges "area"; temperature_... and spectrum_... of spectral lines or a single wavelength;
 * with PADDED_FFT all but separation, shift_x, shift_y, roll, flux_a, flux_b, background, scale and focus. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_derivative(const toliman_sim *sim, const char *name,
                                                                         double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Writes the gradient by the optical path difference of the pupil to gradient[N][N]: the derivative of the sum over
 * pixels of weights[rows][stride] times the expected frame, in the unit of the frame, by the OPD (m) of each cell of
 * toliman_sim_get_pupil; 0 where the pupil is closed. stride >= cols, in elements. For any mode of the OPD, the sum
 * over cells of mode times gradient equals the sum over pixels of weights times the derivative by it
 * (promise: opd-gradients-transpose-derivatives). The gradient costs about as much as one such derivative. The photons
 * of the stars remain as they are, as for derivatives. Errors: TOLIMAN_E_ARGUMENT for a smaller stride or a weight that
 * is not finite; TOLIMAN_E_UNSUPPORTED with PADDED_FFT. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_opd_gradient(const toliman_sim *sim,
                                                                           const double *weights, size_t stride,
                                                                           double *gradient) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
