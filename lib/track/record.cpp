// Format: little-endian members of fixed width, then the columns, then a CRC32. The CRC of a record starts from the
// CRC of the record before it (a hash chain), so that a record that is changed, removed, inserted or moved is
// detected at the place where it happened, and the last checksum identifies the whole ledger.
// The number of dropped frames has 16 bits of its own and the upper halves of kind and reason, which older versions of
// the library refuse as impossible.
// Why: CRC32 of zlib detects every burst of up to 32 bits; the ledger defends against disks and crashes, not against
// an attacker. A record has no length of its own: the header states the columns, so that record n is at a known
// offset.
#include "track/record.hpp"

#include <cmath>

#include "backend/zip.hpp"
#include "base/bytes.hpp"

namespace toliman::track {

namespace {

// CRC32 of all bytes of a record but the checksum, which is last.
uint32_t checksum(const uint8_t *bytes, size_t columns, uint32_t chain) noexcept {
    return zip::crc32(bytes, record_size(columns) - 4, chain);
}

} // namespace

uint32_t to_bytes(const Record &record, size_t columns, uint32_t synced, uint32_t chain, uint8_t *bytes) noexcept {
    uint8_t *at = bytes;
    at = put_number(at, record.stream, 8);
    at = put_number(at, record.content, 4);
    for (const int64_t number : {record.frame_id, record.camera_ns, record.tai_ns})
        at = put_number(at, static_cast<uint64_t>(number), 8);
    at = put_number(at, with_bits<uint64_t>(record.value), 8);
    at = put_number(at, with_bits<uint64_t>(record.sigma), 8);
    at = put_number(at, static_cast<uint8_t>(record.kind) | (record.dropped >> 16 & 15) << 4, 1);
    at = put_number(at, static_cast<uint8_t>(record.reason) | record.dropped >> 20 << 4, 1);
    at = put_number(at, record.dropped & 0xffff, 2);
    for (size_t i = 0; i < columns; i++)
        at = put_number(at, record.cells[i], 8);
    at = put_number(at, synced, 4);
    const uint32_t crc = checksum(bytes, columns, chain);
    put_number(at, crc, 4);
    return crc;
}

Record decoded(const uint8_t *bytes, size_t columns) noexcept {
    const uint8_t *at = bytes;
    Record read;
    read.stream = take_number(at, 8);
    read.content = static_cast<uint32_t>(take_number(at, 4));
    for (int64_t *number : {&read.frame_id, &read.camera_ns, &read.tai_ns})
        *number = static_cast<int64_t>(take_number(at, 8));
    read.value = with_bits<double>(take_number(at, 8));
    read.sigma = with_bits<double>(take_number(at, 8));
    const uint64_t kind = take_number(at, 1), reason = take_number(at, 1);
    read.dropped = static_cast<uint32_t>(take_number(at, 2) | kind >> 4 << 16 | reason >> 4 << 20);
    read.kind = static_cast<Kind>(kind & 15);
    read.reason = static_cast<Reason>(reason & 15);
    for (size_t i = 0; i < columns; i++)
        read.cells[i] = take_number(at, 8);
    return read;
}

RecordStatus from_bytes(const uint8_t *bytes, size_t columns, Record &record, uint32_t &synced,
                        uint32_t &chain) noexcept {
    const uint32_t expected = checksum(bytes, columns, chain);
    const uint8_t *at = bytes + (record_size(columns) - 8);
    const auto before = static_cast<uint32_t>(take_number(at, 4));
    if (take_number(at, 4) != expected)
        return RecordStatus::torn;
    synced = before;
    chain = expected;
    const Record read = decoded(bytes, columns);
    const auto kind = static_cast<size_t>(read.kind), reason = static_cast<size_t>(read.reason);
    if (kind < 1 || kind > kKinds || reason >= kReasons || !std::isfinite(read.value))
        return RecordStatus::impossible;
    record = read;
    return RecordStatus::whole;
}

Record to_record(const MergeMark &merged, double sigma, const Cells &empty) noexcept {
    Record record;
    record.kind = Kind::merged;
    record.stream = merged.salt;
    record.frame_id = merged.records;
    record.camera_ns = merged.repeats;
    record.content = merged.chain;
    record.sigma = sigma;
    record.cells = empty;
    return record;
}

MergeMark merge_mark_of(const Record &record) noexcept {
    return {record.stream, record.frame_id, record.camera_ns, record.content};
}

} // namespace toliman::track
