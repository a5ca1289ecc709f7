// Derivative images of both stars by parameters of the forward model.
#pragma once
#include <vector>

#include "base/buffer.hpp"
#include "optics/imager.hpp"
#include "scene/parameter.hpp"

namespace toliman::optics {

// Parameters whose derivatives this file computes; the others are those of Images::disturbed(), or images themselves.
bool has_own_derivative(Parameter parameter) noexcept;

// Why the scene has no derivative by a parameter; nullptr if it has one.
const char *why_no_derivative(const Scene &scene, const Plan &plan, Parameter parameter) noexcept;

// Fails with Status::unsupported if the scene has no such derivative.
void check_parameter(const Scene &scene, const Plan &plan, Parameter parameter);

// The parameters whose derivatives cost no more if they are computed together with this one; it is among them.
std::vector<Parameter> computed_with(const Scene &scene, Parameter parameter);

// Expected photons per unit of each parameter, [rows][cols] each; of the light before detector and scaling to the peak.
// Each must have an own derivative in this scene.
std::vector<Buffer<double>> derivatives(const Scene &scene, const Pupil &pupil, const Plan &plan, const Imager &imager,
                                        const Light &light, const std::vector<Parameter> &parameters);

// Parts of derivatives(), for those that compute them together:
// What a Zernike polynomial, defocus or a motion of the mask changes in the pupil.
Mode mode_of(const Scene &scene, const Pupil &pupil, Parameter parameter);
bool is_mode(Parameter::Kind kind) noexcept; // of the pupil, defocus excepted
// The star whose spectrum a parameter changes, or 2; and the light whose image is the derivative.
size_t star_of_spectrum(Parameter::Kind kind) noexcept;
Light changed_spectrum(const Scene &scene, const Light &light, Parameter parameter);

} // namespace toliman::optics
