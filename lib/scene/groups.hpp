// The groups of a scene, and ranges that several of them share.
#pragma once
#include "scene/table.hpp"

namespace toliman::scene {

constexpr Range kTurn = within(-360, 360, "deg");
constexpr Range kEccentricity = within(0, 0.9999, "");
constexpr Range kDate = within(-1e4, 1e4, "years");

extern const Group kTelescope, kBand, kStars, kBinary, kCadence, kDetector, kSignal, kSystematics, kCalibration;
void note_calibration(const Reader &reader, Scene &scene); // after kCalibration
extern const Group kOrbit;
extern const Group kScene;  // the scene itself
extern const Group kSystem; // a system file

} // namespace toliman::scene
