// Adds the frames of inputs: sums go to files, a JSON line per sum to standard output once it is durable.
#pragma once
#include <chrono>

#include "common/warnings.hpp"
#include "downlink/frame_source.hpp"
#include "downlink/sum_files.hpp"

namespace cli {

class Adding : public FrameSink {
  public:
    // settings: stamp, exposure and shape of the frames.
    Adding(toliman::frame_adder &&adder, SumFiles &files, const toliman_track_options &settings, Progress &progress);

    const toliman_track_options &settings() const noexcept override { return settings_; }
    size_t batch() const noexcept override { return 1; }
    void take(const std::shared_ptr<FrameSource> &source, const toliman_frame &frame,
              const toliman_ingest_event &event) override;
    void report(Severity severity, const std::string &warning, const std::string &input,
                const std::string &text) override;
    void count_skipped(int64_t frames) noexcept override { skipped_ += frames; }
    void wait() override;

    void finish();                                        // ends the last sum
    void save();                                          // the state
    void end();                                           // tells the counts of this run
    int64_t damaged() const noexcept { return damaged_; } // frames and inputs of this run, for --strict

  private:
    bool to_counts(toliman_frame &frame, const std::string &place);
    void add(toliman_frame frame, const toliman_ingest_event &event);
    void check_region(const char *roi, const std::string &place);
    void end_sum(const char *reason);

    toliman::frame_adder adder_;
    SumFiles &files_;
    toliman_track_options settings_;
    Progress &progress_;
    Warnings warnings_;
    std::chrono::steady_clock::time_point saved_;
    std::chrono::steady_clock::duration patience_ = std::chrono::seconds(1); // from one state to the next
    bool is_written_ = true;                                                 // all sums that were taken are in the pair
    std::vector<uint16_t> counts_;                                           // of a frame of a file of doubles
    std::string region_;                                                     // of the first frame
    std::map<int32_t, int64_t> verdicts_;                                    // of this run
    int64_t sums_ = 0, skipped_ = 0, known_ = 0, damaged_ = 0;
};

} // namespace cli
