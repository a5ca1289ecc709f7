// Where the frames are in the file of pixels.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>

#include "ingest/side_line.hpp"

namespace toliman::ingest {

struct Place {
    uint64_t offset, bytes;
};

class Placement {
  public:
    // rows, cols: the expected shape; 0 = that of the first valid line.
    Placement(size_t rows, size_t cols) noexcept : usual_pixels_(rows * cols) {}

    void set_pixel_bytes(size_t bytes) noexcept { pixel_bytes_ = bytes; } // before set_size
    void count(const SideLine &line) noexcept;                            // a line was read
    void release(const SideLine &line) noexcept; // the first line that was not released is reported
    void set_size(uint64_t size) noexcept;       // of the file of pixels
    void set_shift(int64_t bytes) noexcept;      // of the frames that follow, from their places
    int64_t shift() const noexcept { return shift_; }
    // Size of the file minus that of the frames of all lines: bytes that it has gained or lost. 0 if it may be other
    // things: lines are malformed or of other shapes.
    int64_t surplus() const noexcept {
        return is_uniform_ || has_odd_ ? 0 : static_cast<int64_t>(size_) - static_cast<int64_t>(bytes());
    }

    int64_t counted() const noexcept { return all_.lines; }
    int64_t released() const noexcept { return done_.lines; }
    bool has_valid() const noexcept { return all_.lines > static_cast<int64_t>(all_.bad); }
    uint64_t pixels() const noexcept { return pixels(all_); } // of all lines
    uint64_t bytes() const noexcept { return bytes(all_); }
    bool is_odd(const SideLine &line) const noexcept;  // malformed, or of another shape than the first line
    bool has_odd() const noexcept { return has_odd_; } // among the released lines
    uint64_t bytes(const SideLine &line) const noexcept { return pixels(line) * pixel_bytes_; }
    // Bytes after the frames of all lines; 0 if positions are unknown.
    uint64_t extra_bytes() const noexcept { return static_cast<uint64_t>(std::max<int64_t>(0, surplus() - shift_)); }
    // The place of the first line that was not released, without the shift, if it is known. Its size differs from
    // bytes(line) if the line has a wrong shape.
    std::optional<Place> next(const SideLine &line) const noexcept;

  private:
    struct Sums {
        int64_t lines = 0;
        uint64_t bad = 0, valid_pixels = 0; // malformed lines; pixels of the frames of the others
    };
    uint64_t pixels(const SideLine &line) const noexcept;
    uint64_t pixels(const Sums &sums) const noexcept { return sums.valid_pixels + sums.bad * usual_pixels_; }
    uint64_t bytes(const Sums &sums) const noexcept { return pixels(sums) * pixel_bytes_; }
    void add(Sums &sums, const SideLine &line) const noexcept;

    uint64_t pixel_bytes_ = 0, usual_pixels_, first_pixels_ = 0, size_ = 0;
    int64_t shift_ = 0;
    Sums all_, done_;
    bool is_exact_ = false, is_uniform_ = false, has_odd_ = false;
};

} // namespace toliman::ingest
