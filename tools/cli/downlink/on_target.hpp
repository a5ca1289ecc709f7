// On-target windows of `track --on-target`: intervals of frames in which the telescope points at the stars.
#pragma once
#include "common/common.hpp"
#include "scenes/leap_seconds.hpp"

namespace cli {

class OnTarget {
  public:
    // Reads a table of windows.
    OnTarget(const std::string &path, const LeapSeconds &leap_seconds);
    // Converts the windows to the camera clock of a folder. Throws Failure if the length of its exposures is unknown.
    // scene: whose cadence.exposure_s is that length, without on-target intervals; "": the length is known otherwise.
    void set_clock(const toliman_track_options &settings, const std::string &scene);
    // Limits the intervals of a frame, by default its exposure, to the windows. `intervals` becomes their memory. False
    // if nothing remains. Throws Failure for an exposure of the scene that is not inside one window.
    bool limit(toliman_frame &frame, std::vector<double> &intervals);
    // Warns if exposures over several windows often end in a window that continues, and in which no other exposure
    // begins, and if the table begins or ends in an exposure of which it has less time than of any other.
    void conclude(Progress &progress) const;
    // Why nothing remained of a frame.
    std::string complaint(const toliman_frame &frame) const;

  private:
    struct Window {
        int64_t start_ns, end_ns;
        bool is_cut = false;       // by the end of an exposure over several windows, or follows it
        bool is_continued = false; // by another exposure
    };
    void mark_end(const toliman_frame &frame);
    void mark_cut(const toliman_frame &frame);
    void warn_of_cut(Progress &progress) const;

    void check_length(const toliman_frame &frame) const;

    std::string path_, scene_;
    std::string cut_;  // warning of the exposure with the least time, of those in which the table begins or ends
    double cut_s_ = 0; // its time in the windows
    double least_s_ = INFINITY;   // the least of the other frames that have some
    int64_t sums_ = 0;            // exposures over several windows
    std::vector<Window> windows_; // TAI, by the camera clock after set_clock
    double exposure_s_ = 0;       // of frames that do not state their own
};

} // namespace cli
