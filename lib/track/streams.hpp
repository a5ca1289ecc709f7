// Counts by session and region: which frame ids there were, so that missing ones can be told.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/buffer.hpp"
#include "track/scatter.hpp"

namespace toliman::track {

struct StreamCount {
    uint64_t digest = 0;
    int64_t first = 1, last = 0; // ids; first > last: no stream
    uint32_t frames = 0;         // keys
    bool named = false;          // its names stand beside the ledger
    bool empty() const noexcept { return first > last; }
};

class Streams {
  public:
    static constexpr size_t kMost = 65536;
    explicit Streams(int64_t frames); // at most
    // Status::capacity for a stream too many.
    void check_room(uint64_t stream) const;
    // A frame of it, whose key is new; there must be room.
    void add(uint64_t stream, int64_t frame_id) noexcept;
    size_t count() const noexcept { return count_; }
    // Ids from the first to the last of every stream, together; saturates.
    int64_t expected() const noexcept;
    // False of one that is not in.
    bool is_named(uint64_t stream) const noexcept { return streams_[slot_of(stream)].named; }
    void set_named(uint64_t stream) noexcept;
    const StreamCount &find(uint64_t stream) const noexcept { return streams_[slot_of(stream)]; }
    std::vector<StreamCount> all() const; // in no order

  private:
    size_t slot_of(uint64_t stream) const noexcept;
    size_t most_, count_ = 0;
    Scatter scatter_;
    Buffer<StreamCount> streams_;
};

} // namespace toliman::track
