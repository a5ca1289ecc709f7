#include "track/checkpoint.hpp"

#include <utility>

#include "track/sealed.hpp"

namespace toliman::track {

namespace {

constexpr char kMagic[] = "TLMC", kKind[] = "checkpoint";
constexpr uint32_t kVersion = 1;
constexpr int64_t kLargest = int64_t{1} << 35, kMostRepeats = int64_t{1} << 60;

Loaded read(const std::vector<uint8_t> &bytes) {
    ByteReader in = unsealed(bytes, kMagic, kVersion, kKind);
    Checkpoint checkpoint;
    checkpoint.salt = in.u64();
    checkpoint.lines = in.u64();
    checkpoint.repeats = in.i64();
    checkpoint.chain = in.u32();
    checkpoint.setup = in.u32();
    if (checkpoint.repeats < 0 || checkpoint.repeats > kMostRepeats)
        fail(Status::format, "%s: impossible counts", kKind);
    const size_t size = in.left();
    return {checkpoint, period::Stream::load(in.raw(size), size)};
}

} // namespace

void save(Store &store, const Checkpoint &checkpoint, const period::Stream &sums) {
    ByteWriter out = begin_sealed(kMagic, kVersion);
    out.u64(checkpoint.salt);
    out.u64(checkpoint.lines);
    out.i64(checkpoint.repeats);
    out.u32(checkpoint.chain);
    out.u32(checkpoint.setup);
    const std::vector<uint8_t> state = sums.save();
    out.raw(state.data(), state.size());
    const std::vector<uint8_t> bytes = sealed(std::move(out));
    replace_whole(store, Checkpoint::kName, bytes.data(), bytes.size());
}

std::optional<Loaded> load_checkpoint(Store &store) {
    return read_if_whole(store, Checkpoint::kName, kSealSize, kLargest, read);
}

} // namespace toliman::track
