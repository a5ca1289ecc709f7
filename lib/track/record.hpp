// A line of the ledger: 64 bytes, lib/FORMATS.md "TLML".
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace toliman::track {

enum class Kind : uint8_t {
    accepted = 1,    // the value is in the sums
    outlier = 2,     // a good frame whose value is beyond the limit: not in the sums
    quarantined = 3, // another payload of a key that is known: what was accepted of it is taken back
    rejected = 4,    // a frame that cannot be trusted; a good copy may still come
};

// Why a frame was rejected.
enum class Reason : uint8_t { none = 0, shape = 1, over_range = 2, hole = 3, not_finite = 4, clock = 5, estimate = 6 };
constexpr size_t kKinds = 4, kReasons = 7;

struct Record {
    uint64_t stream = 0; // digest of session and region
    int64_t frame_id = 0;
    int64_t camera_ns = 0, tai_ns = 0;
    double value = 0, sigma = 0;
    uint32_t content = 0; // CRC32 of what must be the same when the frame comes again
    Kind kind = Kind::accepted;
    Reason reason = Reason::none;
    uint16_t dropped = 0; // frames that the camera says it dropped before this one
};

constexpr size_t kRecordSize = 64;
using RecordBytes = std::array<uint8_t, kRecordSize>;

// synced: records that were on the disk when this one was written, modulo 2^32. The checksum goes on from that of the
// record before.
RecordBytes to_bytes(const Record &record, uint32_t synced, uint32_t chain) noexcept;

// The record, or false where the checksum does not fit or a member is impossible. On success synced and chain are those
// of the record.
bool from_bytes(const uint8_t *bytes, Record &record, uint32_t &synced, uint32_t &chain) noexcept;

} // namespace toliman::track
