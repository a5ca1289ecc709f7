// What reads frames from files: a pair (pair.hpp) or a batch (batch.hpp).
#pragma once
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "ingest/side_line.hpp"

namespace toliman::ingest {

struct ReaderOptions {
    bool growing = false;
    size_t pixel_bytes = 0; // of a pair, 2 or 4; 0: by its files
    int middle = 1;         // from a time stamp to the middle of the exposure, in halves of its length: -1, 0 or 1
    double exposure_s = 0;  // of lines without one; 0: unknown
    size_t rows = 0, cols = 0;
    std::optional<std::pair<int64_t, int64_t>> ids; // first and end; others are skipped
    std::string roi;                                // of the frames, others are skipped; empty: of all
    size_t buffers = 1;
};

// In the order of TOLIMAN_INGEST_EVENT_... and TOLIMAN_INGEST_REASON_...
enum class EventKind { nothing, frame, damage, warning };
enum class Reason {
    none,
    bad_line,
    short_file,
    place_unknown,
    clock_jump,
    clocks_differ,
    extra_bytes,
    overlap,
    restart,
    unknown_key
};

// Pointers are valid during the next `buffers` - 1 calls of next.
struct Event {
    EventKind kind = EventKind::nothing;
    Reason reason = Reason::none;
    const std::string *file = nullptr;
    int64_t number = 0; // of the line, from 1; 0: the whole file
    const char *text = "";
    SideLine line = {};           // of a frame, and of damage; of a bad line the key alone
    const void *pixels = nullptr; // of a frame
    uint64_t offset = 0;          // of a frame: its place by the lines before it, without the shift
};

// Of a line: the length of its exposure, and from its time stamp to the middle of it.
inline double exposure_of(const SideLine &line, const ReaderOptions &options) noexcept {
    return line.exposure_s > 0 ? line.exposure_s : options.exposure_s;
}
inline int64_t shift_of(const SideLine &line, const ReaderOptions &options) noexcept {
    return options.middle * std::llround(exposure_of(line, options) * 5e8);
}

struct ReaderCounts {
    int64_t lines = 0, frames = 0, damaged = 0, warnings = 0, skipped = 0;
    uint64_t bytes = 0;
};

class Reader {
  public:
    virtual ~Reader() = default;
    Reader(const Reader &) = delete;
    Reader &operator=(const Reader &) = delete;

    // Status::not_found if a file cannot be read, Status::format if it cannot be such a file.
    virtual Event next() = 0;
    virtual void finish() noexcept {}
    // Finds the frame whose place is `offset`, after the file has lost or gained bytes: reads it into pixels
    // [reference's size], and returns how far it is from its place. 0 if it is not found elsewhere.
    virtual int64_t find(uint64_t, size_t, const void *, void *) const { return 0; }
    virtual void set_shift(int64_t) noexcept {} // of the frames that were not reported yet
    virtual ReaderCounts counts() const noexcept = 0;
    virtual size_t pixel_bytes() const noexcept = 0; // of the last frame; 0: not known yet
    virtual const std::string &side_path() const noexcept = 0;
    virtual const std::string &pixel_path() const noexcept = 0;

  protected:
    explicit Reader(const ReaderOptions &options) : options_(options) {}
    // Whether a line is not to be skipped.
    bool is_wanted(const SideLine &line) const noexcept {
        if (!line.has_key)
            return true;
        const bool has_id =
            !options_.ids || (line.frame_id >= options_.ids->first && line.frame_id < options_.ids->second);
        return has_id && (options_.roi.empty() || options_.roi == line.roi);
    }

    ReaderOptions options_;
};

} // namespace toliman::ingest
