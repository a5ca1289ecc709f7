// Which frames have been seen, and what became of them: a hash table of fixed capacity, 16 bytes a slot, at most two
// thirds full.
#pragma once
#include <cstdint>
#include <string_view>

#include "base/buffer.hpp"
#include "track/scatter.hpp"

namespace toliman::track {

// Names come from the wire: [A-Za-z0-9._-]{1,64}, no leading dot. Fails naming `what` otherwise.
void check_name(std::string_view name, const char *what);

// Digest of (session, roi), and of that with a frame id. 64 bits: among 10^6 frames two keys collide with a chance of
// 3e-8.
uint64_t stream_digest(std::string_view session, std::string_view roi) noexcept;
uint64_t key_digest(uint64_t stream, int64_t frame_id) noexcept;

enum class Fate : uint32_t { none = 0, accepted = 1, outlier = 2, quarantined = 3 };

struct Seen {
    uint64_t key;
    uint32_t content; // that tells the bytes of two frames apart
    uint32_t place;   // 4 times the number of the frame's line in the ledger, and its fate
    Fate fate() const noexcept { return static_cast<Fate>(place & 3); }
    uint64_t line() const noexcept { return place >> 2; }
};

class FrameIndex {
  public:
    static constexpr int64_t kMost = int64_t{1} << 28;
    explicit FrameIndex(int64_t capacity); // 1 to kMost
    // The frame of this key, or NULL. The pointer holds until the next add.
    const Seen *find(uint64_t key) const noexcept;
    // Status::capacity if a frame more would not fit.
    void check_room() const;
    // A key that is not in yet; there must be room.
    void add(uint64_t key, uint32_t content, uint64_t line, Fate fate) noexcept;
    void quarantine(const Seen &seen) noexcept;
    int64_t count() const noexcept { return count_; }

  private:
    size_t slot_of(uint64_t key) const noexcept; // where it stands or belongs
    Scatter scatter_;
    Buffer<Seen> slots_;
    int64_t capacity_, count_ = 0;
};

} // namespace toliman::track
