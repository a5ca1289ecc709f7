// Where a calibration starts.
#pragma once
#include "calibrate/problem.hpp"

namespace toliman::calibrate {

// Edges and number of the pupil cells of the start become those of the nominal scene. Returns what changed; Lack.
uint32_t adopt_cells(const Scene &start, Scene &nominal);

// A start without frames: changes of the parameters, the same in all windows, and the map that they do not explain, of
// another simulator of the scene; NULL: none. Status::mismatch if it is not the same scene with other values.
Point start_of(const Problem &problem, const optics::Outline &nominal, const optics::Simulator *start);

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
