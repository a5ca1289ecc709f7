// Index of known frames and their states: a hash table of fixed capacity, 18 bytes and a bit per slot, at most two
// thirds full.
#pragma once
#include <cstdint>
#include <string_view>

#include "base/buffer.hpp"
#include "track/misfit.hpp"
#include "track/scatter.hpp"

namespace toliman::track {

// Checks a name from the downlink: [A-Za-z0-9._-]{1,64}, no leading dot. Fails naming `what`.
void check_name(std::string_view name, const char *what);

// Digests of (session, roi, restarts), and of that with a frame id. With 64 bits, the probability of a collision among
// 10^6 frames is 3e-8.
uint64_t stream_digest(std::string_view session, std::string_view roi, int64_t restarts) noexcept;
uint64_t key_digest(uint64_t stream, int64_t frame_id) noexcept;

enum class FrameState : uint8_t { accepted = 1, outlier = 2, unreduced = 3, misfit = 4, quarantined = 7 };

struct KnownFrame {
    uint64_t key;
    uint32_t content; // CRC32 of the frame
    uint32_t packed;  // 8 times the number of the frame's record in the ledger, plus its state
    FrameState state() const noexcept { return static_cast<FrameState>(packed & 7); }
    uint64_t record() const noexcept { return packed >> 3; }
};

class FrameIndex {
  public:
    static constexpr int64_t kMax = int64_t{1} << 28;
    explicit FrameIndex(int64_t capacity); // 1 to kMax
    // Returns the frame with this key, or NULL. The pointer is valid until the next add.
    const KnownFrame *find(uint64_t key) const noexcept;
    // Fails with Status::capacity if the index is full.
    void check_capacity() const;
    // Adds a new key; requires check_capacity().
    void add(uint64_t key, uint32_t content, uint64_t record, FrameState state, ChiBin chi_square) noexcept;
    void set_state(const KnownFrame &known, FrameState state) noexcept;
    ChiBin chi_square(const KnownFrame &known) const noexcept {
        return chi_squares_[static_cast<size_t>(&known - slots_.data())];
    }
    // Passes the frames with a chi-square in (low, high] that are not quarantined, in any order.
    template <class Each> void visit_between(ChiBin low, ChiBin high, const Each &each) const {
        for (size_t slot = 0; slot < slots_.size(); slot++)
            if (is_taken(slot) && chi_squares_[slot] > low && chi_squares_[slot] <= high &&
                slots_[slot].state() != FrameState::quarantined)
                each(slots_[slot]);
    }
    int64_t count() const noexcept { return count_; }

  private:
    size_t slot_of(uint64_t key) const noexcept; // of the key, or the free slot for it
    bool is_taken(size_t slot) const noexcept { return (taken_[slot / 64] >> slot % 64 & 1) != 0; }
    Scatter scatter_;
    UnsetBuffer<KnownFrame> slots_; // those not taken are unset, here and in chi_squares_
    UnsetBuffer<ChiBin> chi_squares_;
    Buffer<uint64_t> taken_; // a bit per slot
    int64_t capacity_, count_ = 0;
};

} // namespace toliman::track
