// Predictions of the frames of files, by their times.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <toliman/fit.h>

#include "common/terminal.hpp"
#include "frames/frame_times.hpp"

namespace cli {

// How times of frames are found.
struct FrameClock {
    std::optional<double> cadence;       // s from frame to frame
    std::optional<int64_t> time_zero_ns; // TAI of time 0 of the scene
    LeapSeconds leap_seconds;
};

// If time 0 of the scene is known and the header of a FITS file has a time, or if frames have stamps of the camera,
// whose clock is then TAI, they have the times of FrameTimes, as in `track`. Otherwise the time of a frame is its
// number times the cadence if one is given, or that in the table FRAMES of its file, or else that of the frame of this
// number in the scene.
class Predictions {
  public:
    // scene_times: days. It and `progress`, for warnings, must outlive this object. most: frames of one call.
    Predictions(const std::vector<double> &scene_times, size_t most, const FrameClock &clock, Progress &progress);
    // The file of the frames that follow. Throws Failure if it has more frames than there are times.
    void open(FrameFile &frames);
    // Those of frames first ... first + count - 1 of the file, until the next call.
    const toliman_fit_prediction *from(size_t first, size_t count);
    // Time of frame i of the last call.
    double days(size_t i) const { return predictions_[i].time_days; }
    // The same in TAI; nothing if time 0 is not known, or too far away.
    std::optional<int64_t> tai_ns(size_t i) const;

  private:
    const std::vector<double> &times() const { return file_times_.empty() ? scene_times_ : file_times_; }
    void check_times(size_t frames) const;
    double days_of(size_t frame) const;

    const std::vector<double> &scene_times_;
    FrameClock clock_;
    Progress &progress_;
    std::string path_;
    std::optional<FrameTimes> dated_;     // of the file, if its header has a time
    size_t first_ = 0;                    // frame of the last call
    std::vector<toliman_spread> spreads_; // of the file, if its frames are sums
    std::vector<double> file_times_;      // days, of the table FRAMES; empty without one
    std::vector<toliman_fit_prediction> predictions_;
};

} // namespace cli
