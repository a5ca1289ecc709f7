/* libtoliman, derivatives of a simulator's images by the parameters of its forward model.
 *
 * Data flow (toliman_sim_...)
 *
 *   get_parameters                                  names, units and scopes of the parameters
 *   toliman_sim, name -> get_derivative -> image[rows][cols]
 *   toliman_sim, weights[rows][cols] -> get_opd_gradient -> gradient[N][N]
 *
 * Effect of a unit change; x to higher columns, y to higher rows; all else remains, also photons in the band:
 *
 *   separation          px       signal.star (A without a signal) moves away from the other star
 *   position_angle      rad      B moves around A, from x to y; diffraction patterns do not rotate
 *   shift_x, shift_y    px       both stars move
 *   roll                rad      stars move around the centre of the frame, likewise
 *   flux_a, flux_b               relative change of the photons of a star
 *   background          photons  per pixel
 *   scale                        relative stretch about the centre of the frame
 *   anisotropy, shear            scale_anisotropy, shear of detector; the stars move, too
 *   focus               nm       Noll's fourth polynomial, rms over the full aperture
 *   zernike_5 ... _36   nm       the polynomial with this number
 *   mask_rotation       deg      from x to y
 *   mask_shift_x, _y    m        of its centre
 *   jitter_xx, _yy, _xy px^2     covariance of the jitter
 *   temperature_a, _b   K        spectrum times the ratio of the black bodies of T + 1 K and T; for a table without
 *                                temperature T = 5790 K (A), 5260 K (B)
 *   spectrum_a_1 ... _11         coefficients of stars.A.spectrum.modes; spectrum_b_... likewise
 *   wavelength          nm       all wavelengths increase
 *   diffusion           px^2     square of detector.diffusion_px
 *   transfer_smear, brighter_fatter (px^2/e-), interpixel_capacitance, nonlinearity (1/e-)
 *                                keys of detector
 *   flat                         the response of each pixel: a row of the budget, without derivative
 *   smear               px^2     square of the length of systematics.smear
 *
 * Derivatives are exact, except those of the rotation and the shifts of the mask, whose error is 1e-3 of their largest
 * pixel (promise: derivatives-are-exact). preprocess.project of a scene takes all but separation and flat. */
#ifndef TOLIMAN_SIM_DERIVATIVE_H
#define TOLIMAN_SIM_DERIVATIVE_H

#include <toliman/sim.h>

TOLIMAN_BEGIN_DECLS

/* Where a parameter has one value. */
#define TOLIMAN_SIM_SCOPE_FRAME 341      /* in a frame */
#define TOLIMAN_SIM_SCOPE_INSTRUMENT 342 /* in all frames */

/* A parameter of the forward model. */
typedef struct toliman_sim_parameter {
    uint32_t struct_size;
    int32_t scope; /* TOLIMAN_SIM_SCOPE_... */
    const char *name;
    const char *unit; /* "nm"; "": relative */
} toliman_sim_parameter;
#define TOLIMAN_SIM_PARAMETER_INIT TOLIMAN_INIT(toliman_sim_parameter)

/* Writes the parameters. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_parameters(toliman_sim_parameter *parameters,
                                                                         size_t capacity,
                                                                         size_t *count) TOLIMAN_NOEXCEPT;

/* Writes the derivative of the expected frame by a parameter to image[rows][stride], in the unit of the frame per unit
 * of the parameter.
 * Errors: TOLIMAN_E_UNSUPPORTED if the scene has no such derivative:
 *   - flux_b, temperature_b, spectrum_b_... and position_angle of a single star;
 *   - mask_... unless the mask is a spiral with edges "area";
 *   - temperature_... and spectrum_... of spectral lines or a single wavelength;
 *   - smear without systematics.smear;
 *   - with PADDED_FFT all but separation, shift_x, shift_y, roll, flux_a, flux_b, background, scale and focus. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_derivative(const toliman_sim *sim, const char *name,
                                                                         double *image, size_t stride) TOLIMAN_NOEXCEPT;

/* Writes the gradient of the sum of weights[rows][stride] times the expected frame by the OPD (m) of the pupil's cells
 * to gradient[N][N]; 0 where the pupil is closed. For any mode of the OPD, the sum over cells of mode times gradient
 * equals the sum over pixels of weights times the derivative by it (promise: opd-gradients-transpose-derivatives).
 * TOLIMAN_E_UNSUPPORTED with PADDED_FFT. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_sim_get_opd_gradient(const toliman_sim *sim,
                                                                           const double *weights, size_t stride,
                                                                           double *gradient) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
