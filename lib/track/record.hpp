// Ledger record: 64 bytes plus 8 per column (tools/docs/formats.md, "TLML").
#pragma once
#include <cstddef>
#include <cstdint>

#include "track/columns.hpp"

namespace toliman::track {

enum class Kind : uint8_t {
    accepted = 1,    // the value is in the sums
    outlier = 2,     // a valid frame whose value exceeds the limit: not in the sums
    quarantined = 3, // another payload of a known key: the accepted sample is retracted
    rejected = 4,    // an invalid frame; a valid copy may still arrive
    merged = 5,      // not a frame: records of another ledger were merged, see MergeMark
    intervals = 6,   // not a frame: on-target intervals of the frame whose record follows, see interval_records.hpp
};

// Why a frame was rejected.
enum class Reason : uint8_t {
    none = 0,
    shape = 1,
    over_range = 2,
    zero_run = 3,
    not_finite = 4,
    clock = 5,
    estimate = 6,
    // Of an accepted frame that is not reduced:
    no_orbit = 7,     // the observer file has no state at its time
    no_intervals = 8, // its on-target intervals, or its exposure, are not known
};
constexpr size_t kKinds = 6, kReasons = 9;

constexpr uint32_t kMostDropped = (1u << 24) - 1;

struct Record {
    uint64_t stream = 0; // digest of session, region and restarts
    int64_t frame_id = 0;
    int64_t camera_ns = 0, tai_ns = 0;
    double value = 0, sigma = 0;
    uint32_t content = 0; // CRC32 of everything that a duplicate has in common
    Kind kind = Kind::accepted;
    Reason reason = Reason::none;
    uint32_t dropped = 0; // frames that the camera reports to have dropped before this one, at most kMostDropped
    Cells cells;          // in the order of the ledger's columns
};

// A record of kind merged, in other members: the first `records` of the ledger with this salt were merged. With the
// salt of its own ledger, `records` is the number of records before it, and it only counts repeats.
struct MergeMark {
    uint64_t salt = 0;
    int64_t records = 0, repeats = 0; // repeats: repeated frames there, which have no record of their own
    uint32_t chain = 0;               // checksum of the last of these records
};
constexpr int64_t kMaxRepeats = int64_t{1} << 60; // so that sums of several fit
Record to_record(const MergeMark &merged, double sigma, const Cells &empty) noexcept;
MergeMark merge_mark_of(const Record &record) noexcept;

constexpr size_t record_size(size_t columns) noexcept {
    return 64 + 8 * columns;
}
constexpr size_t kMaxRecordSize = record_size(kMaxColumns);

// Encodes to record_size(columns) bytes. synced: number of durable records when this one was written, modulo 2^32.
// Returns the checksum, which continues that of the record before, `chain`.
uint32_t to_bytes(const Record &record, size_t columns, uint32_t synced, uint32_t chain, uint8_t *bytes) noexcept;

// Decodes a record that from_bytes() has found whole before.
Record decoded(const uint8_t *bytes, size_t columns) noexcept;

// Decodes a record. Unless it is torn (wrong checksum), synced and chain become those of the record. A record with a
// correct checksum and invalid content is impossible.
enum class RecordStatus { whole, torn, impossible };
RecordStatus from_bytes(const uint8_t *bytes, size_t columns, Record &record, uint32_t &synced,
                        uint32_t &chain) noexcept;

} // namespace toliman::track
