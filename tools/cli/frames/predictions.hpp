// When frames were taken, by their files, and the predictions of a fit at these times.
#pragma once
#include <toliman/frame.h>

#include "frames/frames_in.hpp"
#include "scenes/leap_seconds.hpp"

namespace cli {

// Words of TOLIMAN_FRAME_STAMP_START and those that follow it.
inline constexpr const char *kStamps[] = {"start", "middle", "end"};
inline const char *stamp_name(int32_t stamp) noexcept {
    return kStamps[stamp - TOLIMAN_FRAME_STAMP_START];
}
// 0 without a word.
int32_t stamp_of(const std::string &word) noexcept;

// What a file states of its times goes before the cadence (s):
// - frame 0 has the TAI of the header's keywords; without keywords its time in the table FRAMES of `toliman simulate`,
//   or else the stamp of the camera; or else its number times the cadence; both by the camera's clock, the table and
//   the cadence from time 0 on;
// - the others follow as the table says, or else by the cadence.
// A Failure for a file that has no times, or bad ones.
class FrameTimes {
  public:
    // Nothing for a file that has neither a time in its header nor stamps of the camera.
    static std::optional<FrameTimes> of_header(FrameFile &file, const std::optional<double> &cadence,
                                               const LeapSeconds &leap_seconds);
    // number: of the first frame. time_zero_ns: time 0 of the table and the cadence.
    FrameTimes(FrameFile &file, int64_t number, const std::optional<double> &cadence, const LeapSeconds &leap_seconds,
               int64_t time_zero_ns = 0);
    int64_t at(size_t frame) const;
    double exposure_s() const noexcept { return exposure_s_; } // of each frame, from start to end; 0: unknown
    // In words, for a message that is a warning if TIMESYS or the exposure is missing.
    const std::string &rule() const noexcept { return rule_; }
    bool is_assumed() const noexcept { return header_ && (header_->flags & TOLIMAN_INGEST_ASSUMED) != 0; }
    bool by_camera() const noexcept { return !stamps_.empty(); } // times of its clock, frame by frame
    bool is_tai() const noexcept { return header_.has_value(); }
    bool by_cadence() const noexcept { return by_cadence_; } // frame 0, or those behind it

  private:
    std::string path_, rule_;
    std::optional<toliman_ingest_header_time> header_;
    std::vector<int64_t> stamps_; // by the camera's clock; empty where the file has none, or better ones
    std::vector<int64_t> steps_;  // from frame 0 on, where the table has them
    std::optional<double> cadence_;
    double exposure_s_ = 0;
    int64_t first_ = 0, number_ = 0; // time of frame 0, ns; its number, where the cadence counts from it
    bool by_cadence_ = false;
};

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
