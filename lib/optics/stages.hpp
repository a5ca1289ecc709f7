// What a scene can have beyond one star behind a clear aperture, by name; a stage that it does not name costs nothing.
#pragma once
#include "optics/scene.hpp"

namespace toliman::optics {

constexpr size_t kStages = 17;

const char *stage_name(size_t stage) noexcept;
bool has_stage(const Scene &scene, size_t stage) noexcept;

} // namespace toliman::optics
