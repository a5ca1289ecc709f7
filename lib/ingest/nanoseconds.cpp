#include "ingest/nanoseconds.hpp"

#include <algorithm>
#include <iterator>

#include "base/error.hpp"

namespace toliman::ingest {

namespace {

struct UnitScale {
    double factor;
    const char *unit;
};

// The unit whose numbers are this many times those in the right unit; "" for none. The factors are apart by more than
// twice `likeness`.
const char *unit_of(double factor, const UnitScale *units, size_t count, double likeness) noexcept {
    for (size_t i = 0; i < count; i++)
        if (factor > units[i].factor / likeness && factor < units[i].factor * likeness)
            return units[i].unit;
    return "";
}

} // namespace

// A date in these weeks is usually a whole second; a number in another unit is one rarely.
void check_nanoseconds(const char *name, const int64_t *times, size_t count) {
    constexpr int64_t kLeast = 10000, kMost = 50 * INT64_C(86400000000000); // days; microseconds until 2100
    const auto is_near = [](int64_t time) { return time >= kLeast && time <= kMost; };
    const auto is_broken = [](int64_t time) { return time % 1000000000 != 0; };
    if (count == 0 || !std::all_of(times, times + count, is_near) || std::none_of(times, times + count, is_broken))
        return;
    // Of the years 1971 to 2100.
    constexpr double kNow = 1.8e9;
    constexpr UnitScale kUnits[] = {{6.1e4, "days (MJD)"},
                                    {2.46e6, "days (JD)"},
                                    {kNow, "seconds"},
                                    {kNow * 1e3, "milliseconds"},
                                    {kNow * 1e6, "microseconds"}};
    const char *const unit = unit_of(static_cast<double>(times[0]), kUnits, std::size(kUnits), 3);
    fail(Status::argument,
         "{%s}: %lld ns is near 1970-01-01, as are all times of the call: must be nanoseconds of TAI%s%s%s", name,
         static_cast<long long>(times[0]), *unit != '\0' ? "; are they in " : "", unit, *unit != '\0' ? "?" : "");
}

} // namespace toliman::ingest
