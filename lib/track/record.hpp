// A line of the ledger: 64 bytes, and 8 of each column, tools/docs/formats.md "TLML".
#pragma once
#include <cstddef>
#include <cstdint>

#include "track/columns.hpp"

namespace toliman::track {

enum class Kind : uint8_t {
    accepted = 1,    // the value is in the sums
    outlier = 2,     // a good frame whose value is beyond the limit: not in the sums
    quarantined = 3, // another payload of a key that is known: what was accepted of it is taken back
    rejected = 4,    // a frame that cannot be trusted; a good copy may still come
    merged = 5,      // no frame: lines of another ledger are in, see Merged
};

// Why a frame was rejected.
enum class Reason : uint8_t {
    none = 0,
    shape = 1,
    over_range = 2,
    zero_run = 3,
    not_finite = 4,
    clock = 5,
    estimate = 6
};
constexpr size_t kKinds = 5, kReasons = 7;

struct Record {
    uint64_t stream = 0; // digest of session and region
    int64_t frame_id = 0;
    int64_t camera_ns = 0, tai_ns = 0;
    double value = 0, sigma = 0;
    uint32_t content = 0; // CRC32 of what must be the same when the frame comes again
    Kind kind = Kind::accepted;
    Reason reason = Reason::none;
    uint16_t dropped = 0; // frames that the camera says it dropped before this one
    Cells cells;          // of the ledger's columns
};

// A record of kind merged, by its members' other names: the first `lines` of the ledger with this salt are in. With the
// salt of the ledger that it is in, those before it, and so it only counts repeats.
struct Merged {
    uint64_t salt = 0;
    int64_t lines = 0, repeats = 0; // repeats: frames that came again there, which have no line of their own
    uint32_t chain = 0;             // checksum of the last of the lines
};
constexpr int64_t kMostRepeats = int64_t{1} << 60; // so that sums of a few fit
Record to_record(const Merged &merged, double sigma, const Cells &empty) noexcept;
Merged merged_of(const Record &record) noexcept;

constexpr size_t line_size(size_t columns) noexcept {
    return 64 + 8 * columns;
}
constexpr size_t kMostLineSize = line_size(kMostColumns);

// To line_size(columns) bytes. synced: records that were on the disk when this one was written, modulo 2^32. The
// checksum, which is returned, goes on from that of the record before.
uint32_t to_bytes(const Record &record, size_t columns, uint32_t synced, uint32_t chain, uint8_t *bytes) noexcept;

// A line whose checksum fits was written as it is: then synced and chain become those of the record.
enum class Line { whole, torn, impossible };
Line from_bytes(const uint8_t *bytes, size_t columns, Record &record, uint32_t &synced, uint32_t &chain) noexcept;

} // namespace toliman::track
