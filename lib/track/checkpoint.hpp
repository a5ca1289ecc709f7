// The checkpoint: the periodogram's sums as of a line of the ledger, so that opening need not push all anew
// (tools/docs/formats.md "TLMC"). Losing it costs time, and the proof that the ledger lost no record at its end.
#pragma once
#include <cstdint>
#include <optional>

#include "backend/store.hpp"
#include "period/stream.hpp"
#include "track/record.hpp"

namespace toliman::track {

struct Checkpoint {
    static constexpr const char *kName = "checkpoint.tlmc";
    uint64_t salt = 0, lines = 0; // of the ledger, and how many of its lines the sums hold
    uint32_t chain = 0;           // checksum of the last of them
    uint32_t setup = 0;           // digest of what the sums were made with
    int64_t repeats = 0;          // frames that came again, which these lines do not count
};

std::vector<uint8_t> to_bytes(const Checkpoint &checkpoint, const period::Stream &sums);

// What there is, or nothing if there is none or it is damaged.
struct Loaded {
    Checkpoint checkpoint;
    period::Stream sums;
};
std::optional<Loaded> load_checkpoint(Store &store);

// Repeats that a checkpoint of the ledger counts beyond the ledger's last record of them.
int64_t unrecorded_repeats(const Checkpoint &checkpoint, const Merged &last) noexcept;

} // namespace toliman::track
