#include "track/checkpoint.hpp"

#include <cstring>
#include <utility>

#include "backend/zip.hpp"
#include "base/bytes.hpp"

namespace toliman::track {

namespace {

constexpr char kMagic[] = {'T', 'L', 'M', 'C'};
constexpr uint32_t kVersion = 1;
constexpr char kKind[] = "checkpoint";
constexpr size_t kHeaderSize = 4 + 4 + 8 + 8 + 8 + 4 + 4;
constexpr size_t kPointSize = 16;
constexpr int64_t kLargest = int64_t{1} << 35, kMostRepeats = int64_t{1} << 60;

Loaded read(const std::vector<uint8_t> &bytes) {
    ByteReader in(bytes.data(), bytes.size(), kKind);
    ByteReader crc(bytes.data() + bytes.size() - 4, 4, kKind);
    if (std::memcmp(in.raw(sizeof kMagic), kMagic, sizeof kMagic) != 0 || in.u32() != kVersion ||
        crc.u32() != zip::crc32(bytes.data(), bytes.size() - 4))
        fail(Status::format, "%s: damaged, or of another version", kKind);
    Checkpoint checkpoint;
    checkpoint.salt = in.u64();
    checkpoint.lines = in.u64();
    checkpoint.repeats = in.i64();
    checkpoint.chain = in.u32();
    if (checkpoint.repeats < 0 || checkpoint.repeats > kMostRepeats)
        fail(Status::format, "%s: impossible counts", kKind);
    const size_t count = in.u32();
    if (count > in.left() / kPointSize)
        fail(Status::format, "%s: %zu points of the clock do not fit in it", kKind, count);
    std::vector<ClockPoint> points(count);
    for (ClockPoint &point : points) {
        point.camera_ns = in.i64();
        point.tai_ns = in.i64();
    }
    checkpoint.clock = Clock(std::move(points));
    const size_t size = in.left() - 4;
    return {checkpoint, period::Stream::load(in.raw(size), size)};
}

} // namespace

void save(Store &store, const Checkpoint &checkpoint, const period::Stream &sums) {
    ByteWriter out;
    out.raw(kMagic, sizeof kMagic);
    out.u32(kVersion);
    out.u64(checkpoint.salt);
    out.u64(checkpoint.lines);
    out.i64(checkpoint.repeats);
    out.u32(checkpoint.chain);
    out.u32(static_cast<uint32_t>(checkpoint.clock.points().size()));
    for (const ClockPoint &point : checkpoint.clock.points()) {
        out.i64(point.camera_ns);
        out.i64(point.tai_ns);
    }
    const std::vector<uint8_t> state = sums.save();
    out.raw(state.data(), state.size());
    out.u32(zip::crc32(out.bytes().data(), out.bytes().size()));
    replace_whole(store, Checkpoint::kName, out.bytes().data(), out.bytes().size());
}

std::optional<Loaded> load(Store &store) {
    const int64_t size = store.size(Checkpoint::kName);
    if (size < static_cast<int64_t>(kHeaderSize) + 4 || size > kLargest)
        return std::nullopt;
    std::vector<uint8_t> bytes(static_cast<size_t>(size));
    store.read(Checkpoint::kName, 0, bytes.data(), bytes.size());
    try {
        return read(bytes);
    } catch (const Error &error) {
        if (error.status() != Status::format && error.status() != Status::argument)
            throw;
        return std::nullopt;
    }
}

} // namespace toliman::track
