// Reader of a pair of files, X_frames.bin and X_meta.jsonl, which may still grow.
#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "backend/file.hpp"
#include "base/buffer.hpp"
#include "ingest/clock_checks.hpp"
#include "ingest/placement.hpp"
#include "ingest/reader.hpp"
#include "ingest/restarts.hpp"
#include "ingest/side_file.hpp"
#include "ingest/side_line.hpp"

namespace toliman::ingest {

class Pair final : public Reader {
  public:
    // path: one of the two files, or what both have in common. Status::not_found if a file cannot be read.
    Pair(const std::string &path, const ReaderOptions &options);

    Event next() override;
    void finish() noexcept override { is_finished_ = options_.growing; }
    // Of growing files the size says nothing: no frame is found.
    int64_t find(uint64_t offset, size_t pixels, const void *reference, void *found) const override;
    void set_shift(int64_t bytes) noexcept override { placement_.set_shift(bytes); }
    ReaderCounts counts() const noexcept override;
    size_t pixel_bytes() const noexcept override { return pixel_bytes_; }
    const std::string &side_path() const noexcept override { return side_path_; }
    const std::string &pixel_path() const noexcept override { return pixel_path_; }

  private:
    struct Slot {
        Buffer<uint8_t> pixels;
        std::shared_ptr<const std::vector<double>> on_target_s; // of the frame
        std::shared_ptr<const Spread> spread;
        std::string text;
    };
    void look();
    void restart() noexcept;
    void forget_lines() noexcept {
        lines_.clear();
        first_ = 0;
    }
    void read_lines(const file::Reader &side);
    void add_line(const std::string &text, int64_t number, int64_t most);
    void use_type(SideLine &line);
    void find_type();
    void check_type(bool certain);
    void begin_rest();
    std::optional<Event> give(Slot &slot);
    std::optional<Event> give_placed(Slot &slot, const Place &place);
    std::optional<Event> give_rest(Slot &slot);
    Event report(Slot &slot, EventKind kind, Reason reason, std::string text);
    Event damage(Slot &slot, Reason reason, std::string text);
    Event frame(Slot &slot, const Place &place);
    SideLine &front() noexcept { return lines_[first_]; }
    bool is_empty() const noexcept { return first_ == lines_.size(); }
    int64_t front_number() const noexcept { return is_empty() ? 0 : lines_[first_].number; }
    void judge(const SideLine &line);
    void release();
    void skip();

    std::string side_path_, pixel_path_;
    std::set<std::string> names_; // of all lines: frames point to them
    std::vector<Slot> slots_;
    size_t slot_ = 0, calls_since_frame_ = 0;
    ReaderCounts counts_;

    // State of the files.
    file::Stamp side_stamp_, pixel_stamp_;
    std::optional<file::Reader> pixels_; // open while frames are read
    bool is_idle_ = true;                // the next call examines the files
    bool is_settled_ = false;            // the last examination was completed and left no doubt
    bool is_other_type_ = false;         // the last examination found the size of the other pixel type
    bool rests_ = false;                 // the last examination found the files unchanged
    bool is_finished_ = false;

    // Lines that were read, from the first that was not reported.
    SideFile side_;
    std::vector<SideLine> lines_;
    size_t first_ = 0;
    size_t pixel_bytes_;           // 0 until the first valid line
    bool is_type_written_ = false; // a line has had the key dtype
    Placement placement_;
    ClockChecks clock_;
    Restarts restarts_;
    std::deque<std::pair<Reason, std::string>> warnings_; // of the first line, not reported yet
    bool is_judged_ = false;                              // its warnings are known
    unsigned told_ = 0;                                   // bits of the reasons that were reported

    // The end of the files.
    bool is_over_ = false;
    Reason rest_reason_ = Reason::none; // of lines without pixels
    uint64_t extra_bytes_ = 0;          // pixels without line, until they are reported
};

} // namespace toliman::ingest
