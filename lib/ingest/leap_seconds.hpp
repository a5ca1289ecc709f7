// TAI - UTC: the table of ERFA, of a caller, or of a leap-seconds.list. Days are Modified Julian Days.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "backend/erfa.hpp"

namespace toliman::ingest {

using LeapSecondRows = std::vector<erfa::LeapSecond>;

// A table begins on 1972-01-01 with 10 s and continues in steps of 1 s or -1 s. Whether `next` may follow the rows.
bool may_follow(const LeapSecondRows &rows, const erfa::LeapSecond &next) noexcept;
constexpr const char *kLeapSecondRule =
    "must be 10 s on MJD 41317 (1972-01-01) in the first row, in others a later day and 1 s more or less";

class LeapSeconds {
  public:
    // rows: checked by may_follow.
    explicit LeapSeconds(LeapSecondRows rows) : rows_(std::move(rows)) {}
    // TAI - UTC on a day, s; empty before 1972-01-01.
    std::optional<int32_t> tai_utc(int64_t day) const noexcept;
    int64_t seconds_of(int64_t day) const noexcept; // 86400, or one more or less

  private:
    LeapSecondRows rows_;
};

// Reads a leap-seconds.list of the IERS. Status::not_found, Status::format with file and line, also for a list that
// differs from the table of ERFA where both know the leap seconds, and for one that its own hash does not confirm.
erfa::LeapSecondTable read_leap_seconds(const std::string &path);

} // namespace toliman::ingest
