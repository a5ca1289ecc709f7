// Readers of the scene's groups of keys, one function per group; internal to read_scene().
#pragma once
#include "optics/reader.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

constexpr const char *kStarNames[] = {"A", "B"};
constexpr Range kTurn = within(-360, 360, "deg");
constexpr Range kEccentricity = within(0, 0.9999, "");

Telescope read_telescope(const Reader &scene, const std::string &folder);
std::optional<Band> read_band(const Reader &scene);
Cadence read_cadence(const Reader &scene, const std::vector<Star> &stars, const std::string &folder);
std::vector<Star> read_stars(const Reader &scene, const std::string &folder);
Binary read_binary(const Reader &scene, size_t stars);
Detector read_detector(const Reader &scene, const Cadence &cadence);
Systematics read_systematics(const Reader &scene, const Cadence &cadence);
// Uses the stars, the binary and the detector of `known`.
Signal read_signal(const Reader &scene, const Scene &known);

} // namespace toliman::optics
