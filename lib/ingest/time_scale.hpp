// Converts times of all time scales to TAI.
#pragma once
#include <cstdint>

#include "ingest/leap_seconds.hpp"

namespace toliman::ingest {

enum class Scale { utc, tai, tt, tdb, gps };
enum class TimeFormat { iso, mjd, jd };

// The first date of a scale, for messages.
const char *first_date(Scale scale) noexcept;

// Text to nanoseconds since 1970-01-01T00:00:00 TAI. Status::format if it is not a time of this format, Status::range
// before 1958, in UTC before 1972, and after 2099. offset: days to add to a number of days.
int64_t parse_time(const char *text, TimeFormat format, Scale scale, const LeapSeconds &leap_seconds,
                   int64_t offset = 0);

// The same for nanoseconds since 1970-01-01T00:00:00 of the scale, where each day of UTC counts 86,400 s; empty outside
// these years.
std::optional<int64_t> to_tai(int64_t ns, Scale scale, const LeapSeconds &leap_seconds) noexcept;

// The latest day (MJD) of UTC that this thread has converted; 0 for none.
int64_t last_day_of_utc() noexcept;

} // namespace toliman::ingest
