// When the frames of a .npy or FITS file were taken.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <toliman/ingest.h>

#include "frames/frames_in.hpp"

namespace cli {

// A leap-seconds.list, or the table of the library for "".
struct LeapSeconds {
    explicit LeapSeconds(const std::string &path = "");
    int64_t end_ns() const noexcept; // TAI at the beginning of the day of expiry

    std::vector<toliman_leap_second> rows;
    int64_t expires = 0; // MJD
};

// What a file says of its times goes before the cadence (s):
// - frame 0 has the TAI of the header's keywords, mid-exposure, in ns since 1970-01-01T00:00:00 TAI; without keywords
//   its time in the table FRAMES of `toliman simulate`, by the camera's clock, or else its number times the cadence;
// - the others follow as the table says, or else by the cadence.
// A Failure for a file that has no times, or bad ones.
class FrameTimes {
  public:
    // number: of the first frame.
    FrameTimes(FrameFile &file, int64_t number, const std::optional<double> &cadence, const LeapSeconds &leap_seconds);
    int64_t at(size_t frame) const;
    bool is_tai() const noexcept { return is_tai_; }
    bool by_cadence() const noexcept { return by_cadence_; }   // frame 0, or those behind it
    const std::string &rule() const noexcept { return rule_; } // in words
    bool assumed() const noexcept { return assumed_; }         // TIMESYS or the exposure is missing
    bool beyond() const noexcept { return beyond_; }           // the leap seconds of that day are not yet known

  private:
    bool read_keywords(FrameFile &file, const LeapSeconds &leap_seconds);
    std::string path_, rule_;
    std::vector<int64_t> steps_; // from frame 0 on, where the table has them
    std::optional<double> cadence_;
    int64_t first_ = 0, number_ = 0; // time of frame 0, ns; its number, where the cadence counts from it
    bool is_tai_ = false, by_cadence_ = false, assumed_ = false, beyond_ = false;
};

} // namespace cli
