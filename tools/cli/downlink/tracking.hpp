// A tracker at work: frames go in, and lines of JSON come out once the frames that they tell of are on the disk.
#pragma once
#include <chrono>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "common/terminal.hpp"
#include "downlink/arrival.hpp"
#include "downlink/state_folder.hpp"

namespace cli {

// Frame ids first ... end - 1.
struct FrameIds {
    int64_t first = INT64_MIN, end = INT64_MAX;
};

struct TrackingOptions {
    size_t every = 1;           // accepted frames from update to update
    size_t jobs = 1;            // more than one: frames between two updates are estimated together
    FrameIds frames;            // others are passed over
    int64_t rows = 0, cols = 0; // of the frames that the folder takes
    std::string made;           // the folder, where it is new and so removed again if no frame comes
};

class Tracking : public Receiver {
  public:
    Tracking(toliman::tracker &&tracker, const TrackingOptions &options, Progress &progress);

    Arrival &next() override { return batch_[filled_]; }
    void take() override;
    void reject(const std::string &where, const FrameFacts *facts, const char *reason, const std::string &why) override;
    void remark(Remark kind, const std::string &where, const std::string &text) override;
    void tell(const char *remark, const std::string &where, const std::string &text, bool warning) override;
    bool wants(const FrameFacts &facts) override;
    void wait() override;

    // The last update, the checkpoint, all lines.
    void end();
    // The same after an error or a signal, which is told next: an update of what is known, without the fit.
    void rescue();
    int64_t troubles() const noexcept { return troubles_; } // of this run: all that --strict minds

  private:
    struct Line {
        int64_t lines; // of the ledger, that must be on the disk
        std::string text;
    };
    void flush();
    void settled(const Arrival &arrival, const toliman_track_outcome &outcome);
    std::string why(const FrameFacts &facts, const toliman_track_outcome &outcome) const;
    void remark_far(const std::string &where, double value);
    bool is_beyond_clock(const Arrival &arrival) const noexcept;
    std::string update(Fit fit); // returns it in a line of text
    bool remove_unused();
    void save();
    void conclude();
    void say(const std::string &text);
    void print_acknowledged();
    void warn(const std::string &where, const std::string &text);

    toliman::tracker tracker_;
    TrackingOptions options_;
    Progress &progress_;
    std::vector<Arrival> batch_;
    size_t filled_ = 0;
    std::deque<Line> waiting_;                     // for the disk
    std::chrono::steady_clock::time_point oldest_; // of them
    size_t since_update_ = 0;                      // frames accepted
    int64_t lines_ = 0, saved_ = 0;                // of the ledger: all, up to the checkpoint
    double sigma_;                                 // px, of a value
    std::vector<int64_t> clock_;                   // as clock_of
    int64_t good_ = 0, refused_ = 0;               // frames of this run: accepted; rejected or outliers
    int64_t known_ = 0;                            // of which the folder has a copy
    int64_t beyond_clock_ = 0;                     // and such as no pair of the clock's table is on either side of
    int64_t far_ = 0;                              // accepted, with a value that noise does not reach
    std::map<std::string, int64_t> warned_;        // of each file
    int64_t bad_lines_ = 0, short_frames_ = 0, passed_over_ = 0, remarks_[kRemarks] = {}, troubles_ = 0;
};

} // namespace cli
