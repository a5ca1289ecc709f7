// The times of a series: plain numbers, or dates, Modified Julian Days or Julian Days of a time scale.
#pragma once
#include <cstdint>
#include <string>

namespace CLI {
class App;
}

namespace cli {

struct TimeOptions {
    std::string format, scale; // of --time-format and --time-scale; empty: from the input, and UTC
    bool of_state = false;     // the samples continue sums, whose time scale is unknown: `scale` must be given
};
void add_times(CLI::App &command, TimeOptions &options);

// The scale of the resulting times: TAI for UTC, otherwise the same scale.
std::string result_scale(const std::string &scale);

// Names of time columns that imply the format.
constexpr const char *kDayNames[] = {"mjd", "jd", "MJD", "JD"};

class Times {
  public:
    explicit Times(const TimeOptions &options) : options_(options) {}
    // Determines the format from the column's name and its first value. Failure if the options do not suit it.
    void begin(const std::string &column, const std::string &first);
    bool plain() const noexcept { return format_ == 0; }
    // Empty for plain numbers.
    std::string scale() const;
    // Modified Julian Day of the scale; not for plain numbers. Failure without the place of the text.
    double day_of(const std::string &text) const;

  private:
    TimeOptions options_;
    int32_t format_ = 0; // TOLIMAN_INGEST_FORMAT_..., 0: plain
};

} // namespace cli
