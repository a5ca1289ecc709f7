#include "track/setup.hpp"

#include <utility>

#include "track/sealed.hpp"

namespace toliman::track {

namespace {

constexpr char kMagic[] = "TLMS", kKind[] = "setup";
constexpr uint32_t kVersion = 1;
constexpr size_t kPointSize = 16;
constexpr int64_t kLargest = int64_t{1} << 30;

std::vector<uint8_t> to_bytes(const Setup &setup) {
    ByteWriter out = begin_sealed(kMagic, kVersion);
    out.u32(static_cast<uint32_t>(setup.clock.points().size()));
    for (const ClockPoint &point : setup.clock.points()) {
        out.i64(point.camera_ns);
        out.i64(point.tai_ns);
    }
    const std::vector<uint8_t> grid = period::Stream::header(setup.grid);
    out.raw(grid.data(), grid.size());
    return sealed(std::move(out));
}

Setup read(const std::vector<uint8_t> &bytes) {
    ByteReader in = unsealed(bytes, kMagic, kVersion, kKind);
    const size_t count = in.u32();
    if (count > in.left() / kPointSize)
        fail(Status::format, "%s: %zu points of the clock do not fit in it", kKind, count);
    std::vector<ClockPoint> points(count);
    for (ClockPoint &point : points) {
        point.camera_ns = in.i64();
        point.tai_ns = in.i64();
    }
    const size_t size = period::Stream::kHeaderSize;
    const period::Grid grid = period::Stream::load_header(in.raw(size), size);
    if (in.left() > 0)
        fail(Status::format, "%s: %zu bytes too many", kKind, in.left());
    return {grid, Clock(std::move(points))};
}

} // namespace

uint32_t Setup::digest() const {
    const std::vector<uint8_t> bytes = to_bytes(*this);
    return ByteReader(bytes.data() + bytes.size() - 4, 4, kKind).u32();
}

void save(Store &store, const Setup &setup) {
    const std::vector<uint8_t> bytes = to_bytes(setup);
    replace_whole(store, Setup::kName, bytes.data(), bytes.size());
}

std::optional<Setup> load_setup(Store &store) {
    return read_if_whole(store, Setup::kName, kSealSize, kLargest, read);
}

} // namespace toliman::track
