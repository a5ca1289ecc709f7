// Method: open addressing with linear probing. All memory is allocated at creation, so that a push allocates nothing; a
// slot is written when it is taken, so that an index for a million frames is created at once. A frame is identified by
// the 64-bit FNV-1a digest of session, region, restarts and frame id, since packet counters wrap and times repeat. The
// slot depends on a random secret (scatter.hpp): crafted keys cannot make all probes collide.
#include "track/identity.hpp"

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/name.hpp"

namespace toliman::track {

void check_name(std::string_view name, const char *what) {
    if (!is_name(name))
        fail(Status::argument, "{%s} = \"%.*s\": %s", what,
             static_cast<int>(name.size() < kLongestName ? name.size() : kLongestName), name.data(), kNameRule);
}

uint64_t stream_digest(std::string_view session, std::string_view roi, int64_t restarts) noexcept {
    uint64_t hash = fnv1a(session.data(), session.size());
    hash = fnv1a("", 1, hash); // the zero byte separates "ab" + "c" from "a" + "bc"
    hash = fnv1a(roi.data(), roi.size(), hash);
    return restarts == 0 ? hash : fnv1a(static_cast<uint64_t>(restarts), fnv1a("", 1, hash));
}

uint64_t key_digest(uint64_t stream, int64_t frame_id) noexcept {
    uint64_t hash = fnv1a(static_cast<uint64_t>(frame_id), fnv1a("", 1, stream));
    hash ^= hash >> 33;
    hash *= 0xff51afd7ed558ccdu;
    return hash ^ (hash >> 33);
}

FrameIndex::FrameIndex(int64_t capacity)
    : slots_(static_cast<size_t>(capacity) + static_cast<size_t>(capacity) / 2 + 1), chi_squares_(slots_.size()),
      taken_(slots_.size() / 64 + 1), capacity_(capacity) {}

size_t FrameIndex::slot_of(uint64_t key) const noexcept {
    size_t at = scatter_.slot(key, slots_.size());
    while (is_taken(at) && slots_[at].key != key)
        at = at + 1 < slots_.size() ? at + 1 : 0;
    return at;
}

const KnownFrame *FrameIndex::find(uint64_t key) const noexcept {
    const size_t at = slot_of(key);
    return is_taken(at) ? &slots_[at] : nullptr;
}

void FrameIndex::check_capacity() const {
    if (count_ == capacity_)
        fail(Status::capacity, "the frame index is full: capacity = %lld frames", static_cast<long long>(count_));
}

void FrameIndex::add(uint64_t key, uint32_t content, uint64_t record, FrameState state, ChiBin chi_square) noexcept {
    const size_t at = slot_of(key);
    slots_[at] = {key, content, static_cast<uint32_t>(record << 3 | static_cast<uint32_t>(state))};
    chi_squares_[at] = chi_square;
    taken_[at / 64] |= uint64_t{1} << at % 64;
    count_++;
}

void FrameIndex::set_state(const KnownFrame &known, FrameState state) noexcept {
    KnownFrame &slot = slots_[slot_of(known.key)];
    slot.packed = static_cast<uint32_t>(slot.record() << 3 | static_cast<uint32_t>(state));
}

} // namespace toliman::track
