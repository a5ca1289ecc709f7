// Format: magic, version, salt of the ledger, number of records and the chained checksum after them, digest of the
// setup, sums of the periodogram, CRC32. A checkpoint is valid if the ledger still has that chain at that record and
// the setup has that digest; otherwise it is ignored, and the sums are rebuilt from the records.
// Why: opening a folder then costs only the records after the checkpoint. It is also the only witness of the ledger's
// length: a ledger truncated at a record boundary is intact by its own checksums.
#include "track/checkpoint.hpp"

#include <utility>

#include "track/framing.hpp"

namespace toliman::track {

namespace {

constexpr char kCheckpointMagic[] = "TLMC", kCheckpointKind[] = "checkpoint";
constexpr uint32_t kCheckpointVersion = 1;
constexpr size_t kBeforeSums = 4 + 4 + 8 + 8 + 8 + 4 + 4;
constexpr int64_t kLargestCheckpoint = int64_t{1} << 35;

Loaded read_checkpoint(const std::vector<uint8_t> &bytes) {
    ByteReader in = checked_content(bytes, kCheckpointMagic, kCheckpointVersion, kCheckpointKind).in;
    Checkpoint checkpoint;
    checkpoint.salt = in.u64();
    checkpoint.records = in.u64();
    checkpoint.repeats = in.i64();
    checkpoint.chain = in.u32();
    checkpoint.setup = in.u32();
    if (checkpoint.repeats < 0 || checkpoint.repeats > kMaxRepeats)
        fail(Status::format, "%s: impossible counts", kCheckpointKind);
    const size_t size = in.left();
    return {checkpoint, period::Stream::load(in.raw(size), size)};
}

} // namespace

std::vector<uint8_t> to_bytes(const Checkpoint &checkpoint, const period::Stream &sums) {
    ByteWriter out = begin_file(kCheckpointMagic, kCheckpointVersion);
    out.u64(checkpoint.salt);
    out.u64(checkpoint.records);
    out.i64(checkpoint.repeats);
    out.u32(checkpoint.chain);
    out.u32(checkpoint.setup);
    const std::vector<uint8_t> state = sums.save();
    out.raw(state.data(), state.size());
    return finish_file(std::move(out));
}

// The size is checked against the header before memory is allocated for the whole file.
std::optional<Loaded> load_checkpoint(Store &store) {
    uint8_t head[kBeforeSums + period::Stream::kHeaderSize];
    const int64_t size = store.size(Checkpoint::kName);
    if (size < static_cast<int64_t>(sizeof head) || store.read(Checkpoint::kName, 0, head, sizeof head) < sizeof head)
        return std::nullopt;
    try {
        if (static_cast<size_t>(size) !=
            kBeforeSums + period::Stream::saved_size(head + kBeforeSums, period::Stream::kHeaderSize) + 4)
            return std::nullopt;
    } catch (const Error &) {
        return std::nullopt;
    }
    return read_if_whole(store, Checkpoint::kName, kFramingSize, kLargestCheckpoint, read_checkpoint);
}

int64_t unrecorded_repeats(const Checkpoint &checkpoint, const MergeMark &last) noexcept {
    const bool is_later = last.repeats > 0 && static_cast<uint64_t>(last.records) >= checkpoint.records;
    return is_later ? 0 : checkpoint.repeats;
}

} // namespace toliman::track
