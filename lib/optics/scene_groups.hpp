// The groups of a scene, each read by one function; internal to read_scene().
#pragma once
#include "optics/reader.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

// path as the scene names it, made relative to the scene's folder.
std::string resolve(const std::string &folder, const std::string &path);

Telescope read_telescope(const Reader &scene, const std::string &folder);
std::optional<Band> read_band(const Reader &scene);
std::vector<Star> read_stars(const Reader &scene, const std::string &folder);
Binary read_binary(const Reader &scene, size_t stars);
Signal read_signal(const Reader &scene, size_t stars, double pixel_scale_arcsec);

} // namespace toliman::optics
