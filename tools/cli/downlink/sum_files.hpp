// The pair of files that `coadd` writes, and the file from which it continues after a kill.
#pragma once
#include "common/job_journal.hpp"
#include "downlink/known_frames.hpp"

namespace cli {

// The files of one session: X_frames.bin (u32le), X_meta.jsonl and X_coadd.tlma in a folder. The state is the truth:
// what the pair has beyond it was written by a process that died before its state, and is written again.
class SumFiles {
  public:
    // Creates the files, or opens those of a run with the same digest and options. Throws Failure for a pair without
    // state, for the state of another run, and if another process writes to it.
    SumFiles(const std::string &folder, const std::string &session, const std::string &options, uint64_t digest);

    const std::vector<uint8_t> &saved() const noexcept { return saved_; } // state of the library; empty: none
    bool resumes() const noexcept { return !saved_.empty(); }
    KnownFrames &frames() noexcept { return frames_; } // that the saved sums and the state contain
    int64_t sums() const noexcept { return sums_; }
    bool has_state() const noexcept { return has_state_; } // on the disk

    // Appends a sum, on the disk when it returns.
    void append(const toliman_frame &frame, const toliman_coadd_sum &sum);
    // Replaces the state, on the disk when it returns.
    void save(const std::vector<uint8_t> &bytes);

  private:
    std::string line_of(const toliman_frame &frame, const toliman_coadd_sum &sum) const;
    void read_state();
    std::string path(const char *end) const { return stem_ + end; }

    std::string stem_, session_, options_, digest_;
    std::vector<uint8_t> saved_;
    KnownFrames frames_;
    bool has_state_ = false;
    int64_t sums_ = 0, pixel_bytes_ = 0, line_bytes_ = 0; // of the pair
    AppendFile pixels_, lines_;
};

} // namespace cli
