// Where a calibration starts.
#pragma once
#include "calibrate/problem.hpp"

namespace toliman::calibrate {

// The parameters of each frame that fit it best with the instrument at these changes (and this map), from its
// prediction or from where a search finds the stars. Status::argument for a frame whose stars are not found.
std::vector<std::array<double, kOwn>> find_frames(const Problem &problem, const std::vector<double> &changes,
                                                  const Buffer<double> &map_m);

// Whether the pupil is antisymmetric about its centre: aberrations of even azimuthal order then have no sign.
bool is_antisymmetric(const optics::Pupil &pupil);
// How far it is from that: the least rms (m of OPD) of even aberrations whose negatives are a second minimum.
double least_mirrored_m(const optics::Pupil &pupil, double wavelength_m);
// Whether a parameter is such an aberration.
bool is_even_aberration(const optics::Pupil &pupil, Parameter parameter);

} // namespace toliman::calibrate
