// Dates of scenes whose stars follow an orbit, Julian years of 365.25 days as binary.date, and of frames.
#pragma once
#include "common/common.hpp"
#include "scenes/scene.hpp"

namespace cli {

// The date of time 0; nothing for a scene whose stars follow no orbit. Reads the scene file again.
std::optional<double> date_of(const Scene &scene);

// "2026.5" or a date as "2026-07-02", whose day begins at 0 h; nothing for other text.
std::optional<double> year_of(const std::string &text);

// "2026-07-02": the day of scene time `days` if time 0 is at the date `zero`.
std::string day_text(double zero, double days);

// "2027-01-01T00:00:00" of nanoseconds since 1970, with the digits of the nanoseconds that are not 0.
std::string date_text(int64_t ns);

// The same of a Modified Julian Day, "2027-01-01", or to the minute, "2027-01-01T00:00".
std::string mjd_day(double mjd);
std::string mjd_minute(double mjd);

constexpr double kDaysPerYear = 365.25;

} // namespace cli
