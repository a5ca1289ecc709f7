// TAI - UTC: the table of the IERS, leap-seconds.list.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cli {

struct LinePlace;

// Days are Modified Julian Days.
class LeapSeconds {
  public:
    // Of a file, or, where the path is empty, the table that is built in.
    explicit LeapSeconds(const std::string &path = "");
    // Seconds that TAI is ahead on a day of UTC; none before the table begins, on 1972-01-01.
    std::optional<int64_t> ahead(int64_t day) const;
    int64_t seconds_of(int64_t day) const; // 86400, or one more or less
    int64_t expires() const noexcept { return expires_; }

  private:
    struct Step {
        int64_t day, ahead;
    };
    void add(const std::string &line, const LinePlace &where);
    std::vector<Step> steps_;
    int64_t expires_ = 0;
};

} // namespace cli
