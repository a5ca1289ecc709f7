// Counts per session and region (stream): first and last frame id and number of frames, to report missing ones.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/buffer.hpp"
#include "track/scatter.hpp"

namespace toliman::track {

__extension__ using Wide = __int128;

struct StreamCount {
    uint64_t digest = 0;
    int64_t first = 1, last = 0; // frame ids; first > last: empty slot
    uint32_t frames = 0;         // keys
    bool named = false;          // its names are in streams.txt
    bool empty() const noexcept { return first > last; }
    Wide ids() const noexcept { return static_cast<Wide>(last) - first + 1; } // from the first to the last; 0 if empty
};

class Streams {
  public:
    static constexpr size_t kMax = 65536;
    explicit Streams(int64_t frames); // maximum number of frames
    // Fails with Status::capacity if the stream is new and the table full.
    void check_capacity(uint64_t stream) const;
    // Counts a frame with a new key; requires check_capacity().
    void add(uint64_t stream, int64_t frame_id) noexcept;
    size_t count() const noexcept { return count_; }
    // Number of ids from the first to the last of each stream, summed; saturates.
    int64_t expected() const noexcept;
    // Returns false for an unknown stream.
    bool is_named(uint64_t stream) const noexcept { return streams_[slot_of(stream)].named; }
    void set_named(uint64_t stream) noexcept;
    const StreamCount &find(uint64_t stream) const noexcept { return streams_[slot_of(stream)]; }
    std::vector<StreamCount> all() const; // in arbitrary order

  private:
    size_t slot_of(uint64_t stream) const noexcept;
    size_t most_, count_ = 0;
    Wide ids_ = 0; // of all streams
    Scatter scatter_;
    Buffer<StreamCount> streams_;
};

} // namespace toliman::track
