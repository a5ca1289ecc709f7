#include "track/identity.hpp"

#include "base/error.hpp"
#include "base/hash.hpp"

namespace toliman::track {

namespace {

constexpr int64_t kMaxCapacity = int64_t{1} << 32;
constexpr size_t kMaxName = 64;

bool allowed(char c) noexcept {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
           c == '-';
}

size_t slots_for(int64_t capacity) {
    if (capacity < 1 || capacity > kMaxCapacity)
        fail(Status::argument, "capacity = %lld: must be in [1, 2^32]", static_cast<long long>(capacity));
    size_t slots = 2;
    while (slots < 2 * static_cast<size_t>(capacity))
        slots *= 2;
    return slots;
}

} // namespace

void check_name(std::string_view name, const char *what) {
    bool good = !name.empty() && name.size() <= kMaxName && name[0] != '.';
    for (char c : name)
        good = good && allowed(c);
    if (!good)
        fail(Status::argument, "%s = \"%.*s\": must be 1 to 64 of A-Z a-z 0-9 . _ - and not begin with a dot", what,
             static_cast<int>(name.size() < kMaxName ? name.size() : kMaxName), name.data());
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
    hash ^= hash >> 33; // spread over the low bits that choose the slot
    hash *= 0xff51afd7ed558ccdu;
    return hash ^ (hash >> 33);
}

FrameIndex::FrameIndex(int64_t capacity) : slots_(slots_for(capacity)), capacity_(capacity) {}

Verdict FrameIndex::push(uint64_t key, uint32_t content) {
    const size_t mask = slots_.size() - 1;
    size_t at = key & mask;
    while (slots_[at].state != kEmpty && slots_[at].key != key)
        at = (at + 1) & mask;
    Slot &slot = slots_[at];
    if (slot.state == kEmpty) {
        if (count_ == capacity_)
            fail(Status::capacity, "the frame index is full: %lld frames, its capacity",
                 static_cast<long long>(count_));
        slot = {key, content, kSeen};
        count_++;
        return Verdict::fresh;
    }
    if (slot.content != content)
        slot.state = kConflict;
    return slot.state == kConflict ? Verdict::conflict : Verdict::duplicate;
}

} // namespace toliman::track
