// Checkpoint: the periodogram's sums after a number of ledger records (tools/docs/formats.md, "TLMC"), so that resuming
// need not push all samples again. Losing it costs time, and the means to detect a ledger truncated at a record
// boundary.
#pragma once
#include <cstdint>
#include <optional>

#include "backend/store.hpp"
#include "period/stream/stream.hpp"
#include "track/record.hpp"

namespace toliman::track {

struct Checkpoint {
    static constexpr const char *kName = "checkpoint.tlmc";
    uint64_t salt = 0, records = 0; // of the ledger, and the number of its records in the sums
    uint32_t chain = 0;             // checksum of the last one
    uint32_t setup = 0;             // digest of the setup (grid and clock) of the sums
    int64_t repeats = 0;            // repeated frames not counted by these records
};

std::vector<uint8_t> to_bytes(const Checkpoint &checkpoint, const period::Stream &sums);

// A checkpoint with its sums. load_checkpoint() returns none if the file is missing or damaged.
struct Loaded {
    Checkpoint checkpoint;
    period::Stream sums;
};
std::optional<Loaded> load_checkpoint(Store &store);

// Returns the repeats that a checkpoint counts in addition to the last mark in its ledger.
int64_t unrecorded_repeats(const Checkpoint &checkpoint, const MergeMark &last) noexcept;

} // namespace toliman::track
