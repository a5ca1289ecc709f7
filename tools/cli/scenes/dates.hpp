// Dates of scenes whose stars follow an orbit: Julian years of 365.25 days, as binary.date.
#pragma once
#include <optional>
#include <string>

#include "scenes/scene.hpp"

namespace cli {

// The date of time 0; nothing for a scene whose stars follow no orbit. Reads the scene file again.
std::optional<double> date_of(const Scene &scene);

// "2026.5" or "2026-07-02", whose day begins at 0 h; nothing for other text.
std::optional<double> year_of(const std::string &text);

// "2026-07-02": the day of scene time `days` if time 0 is at the date `zero`.
std::string day_text(double zero, double days);

constexpr double kDaysPerYear = 365.25;

} // namespace cli
