// Calibrates a scene with the frames of files, for `calibrate`.
#pragma once
#include "frames/frame_set.hpp"
#include "scenes/scene.hpp"

namespace cli {

// Names of the files that a calibration writes, from that of the fitted scene, which ends in .json.
class CalibrationFiles {
  public:
    explicit CalibrationFiles(const std::string &out);
    const std::string &out() const noexcept { return out_; }
    std::string scene(size_t window, size_t windows) const; // OUT itself if there is one window
    std::string journal() const { return stem_ + ".part"; }
    const std::string &stem() const noexcept { return stem_; } // of the names of all files

  private:
    std::string out_, stem_;
};

struct CalibrationRequest {
    FrameOptions frames;
    size_t most_frames = FrameChoice().most; // of a window
    std::string scene, out, free, bad_pixels;
    bool by_free = false, resume = false;
    toliman_calibration_options options = toliman::sized<toliman_calibration_options>();
};

class Calibration {
  public:
    // Reads scene and frames.
    Calibration(const CalibrationRequest &request, const CalibrationFiles &files, Progress &progress);

    // Calibrates, with a journal of each iteration. Throws Failure after a signal, and if the calibration did not
    // converge.
    void run(Progress &progress);

    const CalibrationRequest &request() const noexcept { return request_; }
    const FrameSet &frames() const noexcept { return frames_; }
    const toliman_calibration *get() const noexcept { return made_.get(); }
    const std::vector<toliman_calibration_step> &steps() const noexcept { return steps_; }

  private:
    toliman::scene_calibration calibrated(const toliman_sim *start);
    static int32_t on_step(const toliman_calibration *so_far, const toliman_calibration_step *step, void *self);
    bool reached_limit(const toliman_calibration_info &info) const;
    [[noreturn]] void refuse(const toliman::error &error) const;
    [[noreturn]] void fail_to_converge(const toliman_calibration_info &info) const;

    const CalibrationRequest &request_;
    const CalibrationFiles &files_;
    Scene scene_;
    FrameSet frames_;
    toliman::scene_calibration made_;
    std::vector<toliman_calibration_step> steps_;
    Progress *progress_ = nullptr; // during run()
};

} // namespace cli
