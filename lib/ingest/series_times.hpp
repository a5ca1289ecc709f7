// The times of a series: their format and scale, from options, the column's name and its first value.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "ingest/column_names.hpp"
#include "ingest/unit.hpp"

namespace toliman::ingest {

struct TimeOptions {
    bool plain = false;               // as TOLIMAN_SERIES_PLAIN_TIMES
    std::optional<TimeFormat> format; // empty: from the first time and the column's name
    std::optional<Scale> scale;       // empty: from the column's name, or UTC
    LeapSeconds leap_seconds = LeapSeconds({});
};

class SeriesTimes {
  public:
    explicit SeriesTimes(const TimeOptions &options) : options_(options) {}

    // The column: "" without a name. Status::mismatch for a unit that no time has.
    void use_column(const std::string &name, const Unit &unit);
    // Determines the format by a time. Until settle(), every time determines it again. Returns a warning, or "".
    std::string use_first(const std::string &time);
    void settle() noexcept { settled_ = true; }
    // Modified Julian Day of scale(), of a time that is not a plain number. Status::format naming t.
    double day_of(const std::string &text) const;

    std::optional<TimeFormat> format() const noexcept { return format_; } // empty for plain numbers
    Scale scale() const noexcept { return given() == Scale::utc ? Scale::tai : given(); }
    double unit_days() const noexcept { return format_ ? 1 : unit_days_; } // per unit of t; 0: not stated

  private:
    Scale given() const noexcept { return options_.scale.value_or(column_.scale.value_or(Scale::utc)); }

    TimeOptions options_;
    std::string name_;
    TimeName column_;
    std::optional<TimeFormat> format_;
    int64_t offset_ = 0; // days to add
    double unit_days_ = 0;
    bool settled_ = false;
};

} // namespace toliman::ingest
