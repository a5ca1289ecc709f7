// Parameters of the instrument as numbers of a scene, which a calibration changes.
#pragma once
#include <vector>

#include "scene/scene.hpp"

namespace toliman {

// Why a calibration cannot change a parameter of this kind; nullptr if it can.
const char *why_not_adjustable(Parameter parameter) noexcept;

// Changes a parameter by `change` in its unit (include/toliman/sim_derivative.h). It must be adjustable.
void adjust(Scene &scene, Parameter parameter, double change);

// By how much a parameter of `scene` exceeds that of `nominal`.
double change_of(const Scene &scene, const Scene &nominal, Parameter parameter);

// Temperature of a star (K); a table without temperatures is one of 5790 K for A and 5260 K for B.
double temperature_of(const Scene &scene, size_t star) noexcept;

// Whether a scene file may have the values of these parameters.
bool is_readable(const Scene &scene) noexcept;

// Changes the covariance (px^2) to the nearest one whose variances are not negative along any axis. Whether it changed.
bool make_possible(Jitter &jitter) noexcept;

// Covariance of the blur of a frame: jitter and diffusion of charge.
Jitter blur_of(const Scene &scene) noexcept;

} // namespace toliman
