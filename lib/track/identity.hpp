// Which frames have been seen: a hash table of fixed capacity, 24 bytes a slot, at most two thirds full.
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

namespace toliman::track {

enum class Verdict : int32_t { fresh = 0, duplicate = 1, conflict = 2 };

// Names come from the wire: [A-Za-z0-9._-]{1,64}, no leading dot. Fails naming `what` otherwise.
void check_name(std::string_view name, const char *what);

// Digest of (session, frame id, roi). 64 bits: among 10^6 frames two keys collide with a chance of 3e-8.
uint64_t key_digest(std::string_view session, int64_t frame_id, std::string_view roi) noexcept;

// What tells the bytes of two frames apart.
struct Content {
    uint64_t size;
    uint32_t crc32;
};

class FrameIndex {
  public:
    explicit FrameIndex(int64_t capacity);
    // Status::capacity when a new key no longer fits.
    Verdict push(uint64_t key, Content content);
    int64_t count() const noexcept { return count_; }

  private:
    enum State : uint32_t { kEmpty, kSeen, kConflict };
    struct Slot {
        uint64_t key, size;
        uint32_t crc32, state;
    };
    std::vector<Slot> slots_;
    int64_t capacity_, count_ = 0;
};

} // namespace toliman::track
