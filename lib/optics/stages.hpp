// The optional stages of the model, by name, beyond one star and a clear aperture. A stage that a scene does not name
// costs nothing. The numbers of stages are public: append new ones at the end.
#pragma once
#include "scene/scene.hpp"

namespace toliman::optics {

constexpr size_t kStages = 25;

const char *stage_name(size_t stage) noexcept;
bool has_stage(const Scene &scene, size_t stage) noexcept;

} // namespace toliman::optics
