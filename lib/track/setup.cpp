#include "track/setup.hpp"

#include <cmath>
#include <utility>

#include "track/framing.hpp"

namespace toliman::track {

namespace {

constexpr char kMagic[] = "TLMS", kKind[] = "setup";
constexpr uint32_t kVersion = 1;
constexpr size_t kPointSize = 16;
constexpr int64_t kLargest = int64_t{1} << 30;

Setup read(const std::vector<uint8_t> &bytes) {
    ByteReader in = checked_content(bytes, kMagic, kVersion, kKind);
    const size_t count = in.u32();
    if (count > in.left() / kPointSize)
        fail(Status::format, "%s: %zu clock points exceed the size of the file", kKind, count);
    std::vector<ClockPoint> points(count);
    for (ClockPoint &point : points) {
        point.camera_ns = in.i64();
        point.tai_ns = in.i64();
    }
    const size_t size = period::Stream::kHeaderSize;
    const period::Grid grid = period::Stream::load_header(in.raw(size), size);
    if (in.left() > 0)
        fail(Status::format, "%s: has %zu extra bytes", kKind, in.left());
    return {grid, Clock(std::move(points))};
}

} // namespace

uint32_t Setup::digest() const {
    const std::vector<uint8_t> bytes = to_bytes(*this);
    return ByteReader(bytes.data() + bytes.size() - 4, 4, kKind).u32();
}

std::vector<uint8_t> to_bytes(const Setup &setup) {
    ByteWriter out = begin_file(kMagic, kVersion);
    out.u32(static_cast<uint32_t>(setup.clock.points().size()));
    for (const ClockPoint &point : setup.clock.points()) {
        out.i64(point.camera_ns);
        out.i64(point.tai_ns);
    }
    const std::vector<uint8_t> grid = period::Stream::header(setup.grid);
    out.raw(grid.data(), grid.size());
    return finish_file(std::move(out));
}

period::Grid for_terms(period::Grid grid, const Terms &terms) {
    int exponent;
    const bool is_power = std::frexp(terms.value_limit, &exponent) == 0.5;
    grid.value_bound =
        is_power ? terms.value_limit : std::ldexp(1.0, exponent); // the smallest power of two that is not below
    grid.value_offset = grid.time_offset = 0;
    grid.sigma_floor = terms.sigma;
    grid.sigma_ceiling = Terms::kMaxSigmaRatio * terms.sigma;
    return grid;
}

std::optional<Setup> load_setup(Store &store) {
    return read_if_whole(store, Setup::kName, kFramingSize, kLargest, read);
}

} // namespace toliman::track
