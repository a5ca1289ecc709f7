#include "track/identity.hpp"

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/name.hpp"

namespace toliman::track {

namespace {

constexpr int64_t kMaxCapacity = int64_t{1} << 32;

size_t slots_for(int64_t capacity) {
    if (capacity < 1 || capacity > kMaxCapacity)
        fail(Status::argument, "capacity = %lld: must be in [1, 2^32]", static_cast<long long>(capacity));
    return static_cast<size_t>(capacity) + static_cast<size_t>(capacity) / 2 + 1;
}

// The key's share of 2^64, taken of the slots.
size_t first_slot(uint64_t key, size_t slots) noexcept {
    __extension__ using Product = unsigned __int128;
    return static_cast<size_t>(static_cast<Product>(key) * slots >> 64);
}

} // namespace

void check_name(std::string_view name, const char *what) {
    if (!is_name(name))
        fail(Status::argument, "%s = \"%.*s\": %s", what,
             static_cast<int>(name.size() < kLongestName ? name.size() : kLongestName), name.data(), kNameRule);
}

uint64_t key_digest(std::string_view session, int64_t frame_id, std::string_view roi) noexcept {
    uint64_t hash = fnv1a(session.data(), session.size());
    hash = fnv1a("", 1, hash); // the zero byte keeps "ab" + "c" from "a" + "bc"
    hash = fnv1a(roi.data(), roi.size(), hash);
    hash = fnv1a("", 1, hash);
    for (int i = 0; i < 8; i++) {
        const char byte = static_cast<char>(static_cast<uint64_t>(frame_id) >> (8 * i));
        hash = fnv1a(&byte, 1, hash);
    }
    hash ^= hash >> 33; // spread over the high bits, which choose the slot
    hash *= 0xff51afd7ed558ccdu;
    return hash ^ (hash >> 33);
}

FrameIndex::FrameIndex(int64_t capacity) : slots_(slots_for(capacity)), capacity_(capacity) {}

Verdict FrameIndex::push(uint64_t key, Content content) {
    size_t at = first_slot(key, slots_.size());
    while (slots_[at].state != kEmpty && slots_[at].key != key)
        at = at + 1 < slots_.size() ? at + 1 : 0;
    Slot &slot = slots_[at];
    if (slot.state == kEmpty) {
        if (count_ == capacity_)
            fail(Status::capacity, "the frame index is full: %lld frames, its capacity",
                 static_cast<long long>(count_));
        slot = {key, content.size, content.crc32, kSeen};
        count_++;
        return Verdict::fresh;
    }
    if (slot.size != content.size || slot.crc32 != content.crc32)
        slot.state = kConflict;
    return slot.state == kConflict ? Verdict::conflict : Verdict::duplicate;
}

} // namespace toliman::track
