// Runs a tracker: frames go in, JSON lines come out once the records of their frames are durable.
#pragma once
#include <chrono>
#include <deque>
#include <set>

#include "common/warnings.hpp"
#include "downlink/bank_watch.hpp"
#include "downlink/folder_facts.hpp"
#include "downlink/frame_source.hpp"
#include "downlink/on_target.hpp"
#include "downlink/realigner.hpp"
#include "downlink/state_folder.hpp"

namespace cli {

struct TrackingOptions {
    size_t every = 1;                   // accepted frames between two updates
    size_t jobs = 1;                    // if above 1, the frames between two updates are estimated together
    std::string new_folder;             // the folder, if it is new: it is removed again if no frame arrives
    std::optional<std::string> renewal; // of the bank that measures the frames, if there is one
    std::string coverage;               // of the observer file, if there is one
    double scene_exposure_s = 0;        // of the scene of the estimator; 0: unknown
    std::vector<double> on_target_s;    // of the exposures of the scene; empty: none
};

class Tracking : public FrameSink {
  public:
    // realigner: that of the tracker's options.
    Tracking(toliman::tracker &&tracker, const TrackingOptions &options, Realigner &realigner, Progress &progress);

    const toliman_track_options &settings() const noexcept override { return settings_; } // of the folder
    size_t batch() const noexcept override { return batch_; }

    // Limits the frames that follow to the windows. scene: as OnTarget::set_clock.
    void set_on_target(OnTarget windows, const std::string &scene);
    void take(const std::shared_ptr<FrameSource> &source, const toliman_frame &frame,
              const toliman_ingest_event &event) override;
    void report(Severity severity, const std::string &warning, const std::string &input,
                const std::string &text) override;
    void count_skipped(int64_t frames) noexcept override { skipped_ += frames; }
    void wait() override;

    // Prints the last update and all lines, and saves a checkpoint.
    void end();
    // The same after an error or a signal, whose message follows: the update has no fit.
    void rescue();
    int64_t damaged() const noexcept { return damaged_; } // frames and inputs of this run, for --strict

  private:
    // Where a frame of the batch comes from.
    struct Origin {
        std::shared_ptr<FrameSource> source;
        int64_t offset; // in the file of a pair
        std::string place;
        std::vector<double> intervals; // of the frame, with --on-target
    };
    struct Line {
        int64_t records; // of the ledger that must be durable before it is printed
        std::string text;
    };
    void flush();
    void settle(const toliman_frame &frame, const std::string &place, const toliman_track_outcome &outcome);
    // has_key: session, roi and frame_id are known. reason: in a word or two.
    void reject(const toliman_frame &frame, bool has_key, const std::string &place, const char *reason,
                const std::string &text);
    void warn_if_far(const std::string &place, double value, double sigma);
    void note_unknown_exposure(const std::string &place);
    bool is_other_region(const char *roi);
    bool set_intervals(toliman_frame &frame, std::vector<double> &intervals);
    PeriodFacts update(Fit fit); // prints it
    std::string summary(const PeriodFacts &period) const;
    bool remove_unused();
    void conclude();
    void say(std::string text);
    void print_acknowledged();
    void warn(const std::string &kind, const std::string &place, const std::string &text, int64_t most = 1);
    void note_shift(const std::string &place, int64_t shift, bool is_good);

    toliman::tracker tracker_;
    toliman_track_options settings_;
    TrackingOptions options_;
    Realigner &realigner_;
    Progress &progress_;
    Warnings warnings_;
    size_t batch_;
    std::vector<toliman_frame> frames_; // that wait for the estimator, with their origins
    std::vector<Origin> origins_;
    std::deque<Line> lines_;                       // that wait for the disk
    std::chrono::steady_clock::time_point oldest_; // of them
    size_t since_update_ = 0;                      // accepted frames
    int64_t records_ = 0, saved_ = 0;              // of the ledger; at the last checkpoint
    std::set<std::string> regions_;                // of the folder, or of its first frame
    std::optional<BankWatch> bank_;
    std::optional<OnTarget> on_target_;
    bool noted_exposure_ = false, noted_intervals_ = false;
    std::string shift_; // file and shift of the last frame that was not at its place
    // Counts of this run.
    int64_t accepted_ = 0, refused_ = 0;   // refused: rejected, or outliers
    int64_t known_ = 0;                    // frames of which the folder has a copy
    std::map<int32_t, int64_t> unreduced_; // TOLIMAN_TRACK_REASON_...
    int64_t realigned_ = 0;                // frames that were not at their places
    int64_t outside_clock_ = 0, far_ = 0, skipped_ = 0, damaged_ = 0, unreadable_ = 0;
    std::map<int32_t, int64_t> reasons_; // TOLIMAN_INGEST_REASON_...
};

} // namespace cli
