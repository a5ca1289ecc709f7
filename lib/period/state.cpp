// State bytes of a periodogram, "TLMP" of lib/FORMATS.md.
#include <cmath>

#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "period/stream.hpp"

namespace toliman::period {

namespace {

constexpr char kMagic[] = {'T', 'L', 'M', 'P'};
constexpr uint32_t kVersion = 1;
constexpr uint32_t kFixedMean = 1;
constexpr char kKind[] = "periodogram state";
constexpr size_t kHeaderSize = 4 + 4 + 4 + 4 + 7 * 8 + 8;
constexpr size_t kExactSize = size_t{ExactSum::kPlaces} * 8;
constexpr size_t kSumSize = 12; // i64 upper part, u32 lower part
constexpr size_t kTotalsSize = 8 + 3 * kSumSize + 5 * kExactSize;
constexpr size_t kCrcSize = 4;

size_t state_size(int64_t nf) noexcept {
    return kHeaderSize + kTotalsSize + static_cast<size_t>(nf) * kernels::kSums * kSumSize + kCrcSize;
}

// A carry-save pair in its one canonical form.
void save_pair(ByteWriter &out, int64_t lo, int64_t hi) {
    out.i64(hi + (lo >> 32));
    out.u32(static_cast<uint32_t>(lo & (kernels::kFoldBase - 1)));
}

void load_pair(ByteReader &in, int64_t &lo, int64_t &hi) {
    constexpr int64_t limit = int64_t{1} << 61; // 2^43 samples of weight 1; leaves room for as many more
    hi = in.i64();
    lo = in.u32();
    if (hi < -limit || hi > limit)
        fail(Status::format, "%s: a sum is out of range", kKind);
}

void save_exact(ByteWriter &out, const ExactSum &sum) {
    for (int64_t place : sum.canonical())
        out.i64(place);
}

void load_exact(ByteReader &in, ExactSum &sum) {
    ExactSum::Places digits;
    for (size_t i = 0; i < digits.size(); i++) {
        digits[i] = in.i64();
        if (i + 1 < digits.size() && (digits[i] < 0 || digits[i] >= kernels::kFoldBase))
            fail(Status::format, "%s: digit %zu of an exact sum is out of range", kKind, i);
    }
    sum.assign(digits);
}

Grid load_header(ByteReader &in) {
    if (std::memcmp(in.raw(sizeof kMagic), kMagic, sizeof kMagic) != 0)
        fail(Status::format, "%s: does not begin with \"TLMP\"", kKind);
    const uint32_t version = in.u32();
    if (version != kVersion)
        fail(Status::format, "%s: version %u, this library reads %u", kKind, version, kVersion);
    const uint32_t flags = in.u32();
    if ((flags & ~kFixedMean) != 0 || in.u32() != 0)
        fail(Status::format, "%s: unknown flags 0x%x", kKind, flags);
    Grid grid;
    grid.fixed_mean = (flags & kFixedMean) != 0;
    grid.nf = in.i64();
    for (double *value :
         {&grid.f0, &grid.df, &grid.time_offset, &grid.value_offset, &grid.value_bound, &grid.sigma_floor})
        *value = in.f64();
    try {
        grid.check();
    } catch (const Error &error) {
        fail(Status::format, "%s: %s", kKind, error.what());
    }
    if (in.u64() != grid.digest())
        fail(Status::format, "%s: the identity digest does not fit the header", kKind);
    return grid;
}

} // namespace

std::vector<uint8_t> Stream::save() const {
    ByteWriter out;
    out.raw(kMagic, sizeof kMagic);
    out.u32(kVersion);
    out.u32(grid_.fixed_mean ? kFixedMean : 0);
    out.u32(0);
    out.i64(grid_.nf);
    for (double value :
         {grid_.f0, grid_.df, grid_.time_offset, grid_.value_offset, grid_.value_bound, grid_.sigma_floor})
        out.f64(value);
    out.u64(grid_.digest());
    out.i64(totals_.count);
    save_pair(out, totals_.weight, totals_.weight_high);
    save_pair(out, totals_.value, totals_.value_high);
    save_pair(out, totals_.value_low, totals_.value_low_high);
    for (const ExactSum *sum : {&totals_.w, &totals_.wy, &totals_.wyy, &totals_.wt, &totals_.wtt})
        save_exact(out, *sum);
    for (size_t sum = 0; sum < kernels::kSums; sum++)
        for (size_t k = 0; k < static_cast<size_t>(grid_.nf); k++)
            save_pair(out, lo_[sum * padded() + k], hi_[sum * padded() + k]);
    out.u32(zip::crc32(out.bytes().data(), out.bytes().size()));
    return out.take();
}

Stream Stream::load(const void *bytes, size_t size) {
    ByteReader in(bytes, size, kKind);
    const Grid grid = load_header(in);
    if (size != state_size(grid.nf))
        fail(Status::format, "%s: %zu bytes, a grid of %lld frequencies takes %zu", kKind, size,
             static_cast<long long>(grid.nf), state_size(grid.nf));
    ByteReader trailer(static_cast<const uint8_t *>(bytes) + size - kCrcSize, kCrcSize, kKind);
    if (trailer.u32() != zip::crc32(bytes, size - kCrcSize))
        fail(Status::format, "%s: checksum mismatch, the bytes are damaged", kKind);
    Stream stream(grid);
    Totals &totals = stream.totals_;
    totals.count = in.i64();
    if (totals.count < 0)
        fail(Status::format, "%s: count = %lld", kKind, static_cast<long long>(totals.count));
    load_pair(in, totals.weight, totals.weight_high);
    load_pair(in, totals.value, totals.value_high);
    load_pair(in, totals.value_low, totals.value_low_high);
    for (ExactSum *sum : {&totals.w, &totals.wy, &totals.wyy, &totals.wt, &totals.wtt})
        load_exact(in, *sum);
    for (size_t sum = 0; sum < kernels::kSums; sum++)
        for (size_t k = 0; k < static_cast<size_t>(grid.nf); k++)
            load_pair(in, stream.lo_[sum * stream.padded() + k], stream.hi_[sum * stream.padded() + k]);
    return stream;
}

} // namespace toliman::period
