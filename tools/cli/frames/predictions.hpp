// Predictions of the frames of files, by their times.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <toliman/fit.h>

#include "frames/frames_in.hpp"

namespace cli {

// The time of a frame is its number times the cadence (s) if one is given; otherwise that in the table FRAMES of its
// file, or else that of the frame of this number in the scene.
class Predictions {
  public:
    // scene_times: days, must outlive this object. most: frames of one call.
    Predictions(const std::vector<double> &scene_times, size_t most, const std::optional<double> &cadence);
    // The file of the frames that follow. Throws Failure if it has more frames than there are times.
    void open(FrameFile &frames);
    // Those of frames first ... first + count - 1 of the file.
    const toliman_fit_prediction *from(size_t first, size_t count);
    // Time of frame i of the last call.
    double days(size_t i) const { return predictions_[i].time_days; }

  private:
    const std::vector<double> &times() const { return file_times_.empty() ? scene_times_ : file_times_; }
    void check_times(size_t frames) const;
    double days_of(size_t frame) const;

    const std::vector<double> &scene_times_;
    std::optional<double> cadence_;
    std::string path_;
    std::vector<double> file_times_; // days, of the table FRAMES; empty without one
    std::vector<toliman_fit_prediction> predictions_;
};

} // namespace cli
