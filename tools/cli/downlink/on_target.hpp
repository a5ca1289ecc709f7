// On-target windows of `track --on-target`: intervals of frames in which the telescope points at the stars.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <toliman/track.h>

#include "downlink/frame_times.hpp"

namespace cli {

class OnTarget {
  public:
    // Reads a table of windows.
    OnTarget(const std::string &path, const LeapSeconds &leap_seconds);
    // Converts the windows to the camera clock of a folder. Throws Failure if the length of its exposures is unknown.
    void set_clock(const toliman_track_options &settings);
    // Limits the intervals of a frame, by default its exposure, to the windows. `intervals` becomes their memory. False
    // if nothing remains.
    bool limit(toliman_frame &frame, std::vector<double> &intervals) const;
    // Why nothing remained of a frame.
    std::string complaint(const toliman_frame &frame) const;

  private:
    struct Window {
        int64_t start_ns, end_ns;
    };
    std::string path_;
    std::vector<Window> windows_; // TAI, by the camera clock after set_clock
    double exposure_s_ = 0;       // of frames that do not state their own
};

} // namespace cli
