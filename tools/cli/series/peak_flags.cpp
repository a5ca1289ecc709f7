#include "series/peak_flags.hpp"

#include <toliman/period.h>

namespace cli {

std::string flags_text(uint32_t flags) {
    return std::string((flags & TOLIMAN_PERIOD_LONG) != 0 ? ", long period" : "") +
           ((flags & TOLIMAN_PERIOD_ANNUAL) != 0 ? ", annual" : "");
}

void set_flags(uint32_t flags, Json &json) {
    json.set("long_period", (flags & TOLIMAN_PERIOD_LONG) != 0, "annual", (flags & TOLIMAN_PERIOD_ANNUAL) != 0);
}

void warn_of_peak(uint32_t flags, const std::string &hint, bool is_dated, Progress &progress) {
    if ((flags & TOLIMAN_PERIOD_LONG) != 0)
        progress.warn("the period exceeds half the time span: a trend may cause it" + hint);
    if ((flags & TOLIMAN_PERIOD_ANNUAL) != 0)
        progress.warn(std::string(is_dated ? "" : "if t is in days, ") +
                      "the period is within one resolution of a year: the motion of the Earth, seasons and observing "
                      "windows may cause it");
}

} // namespace cli
