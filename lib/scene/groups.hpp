// The groups of a scene, and ranges that several of them share.
#pragma once
#include "scene/table.hpp"

namespace toliman::scene {

constexpr Range kTurn = within(-360, 360, "deg");
constexpr Range kEccentricity = within(0, 0.9999, "");

extern const Group kTelescope, kBand, kStars, kBinary, kCadence, kDetector, kSignal, kSystematics, kCalibration;
extern const Group kScene; // the scene itself

} // namespace toliman::scene
