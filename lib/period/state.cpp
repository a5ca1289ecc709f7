// State bytes of a periodogram, "TLMP" of tools/docs/formats.md.
#include <cmath>

#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "period/stream.hpp"

namespace toliman::period {

namespace {

constexpr char kMagic[] = {'T', 'L', 'M', 'P'};
constexpr uint32_t kVersion = 3;
constexpr uint32_t kFixedMean = 1, kWide = 2, kTurned = 4;
constexpr size_t kFlagsAt = 8;
constexpr char kKind[] = "periodogram state";
constexpr size_t kExactSize = size_t{ExactSum::kPlaces} * 8;
constexpr size_t kSumSize = 12; // i64 upper part, u32 lower part
constexpr size_t kTotalsSize = 8 + 3 * kSumSize + 5 * kExactSize;
constexpr size_t kCrcSize = 4;

size_t state_size(const Grid &grid) noexcept {
    return Stream::kHeaderSize + kTotalsSize + static_cast<size_t>(grid.nf) * grid.sums() * kSumSize + kCrcSize;
}

// A carry-save pair in its one canonical form.
void save_pair(ByteWriter &out, int64_t lo, int64_t hi) {
    out.i64(hi + (lo >> 32));
    out.u32(static_cast<uint32_t>(lo & (kernels::kFoldBase - 1)));
}

void load_pair(ByteReader &in, int64_t &lo, int64_t &hi) {
    hi = in.i64();
    lo = in.u32();
}

// Its size is at most `most` 2^50, up to rounding.
void check_pair(int64_t lo, int64_t hi, double most) {
    const auto limit = static_cast<int64_t>((most + 1) * 0x1p18);
    const int64_t upper = hi + (lo >> 32);
    if (upper < -limit || upper > limit)
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
    if (digits.back() != 0 && digits.back() != -1) // the sign
        fail(Status::format, "%s: the last digit of an exact sum is out of range", kKind);
    sum.assign(digits);
}

void check_exact(const ExactSum &sum, double limit) {
    const Quad value = sum.value(), most = static_cast<Quad>(limit);
    if (value > most || value < -most)
        fail(Status::format, "%s: an exact sum is out of range", kKind);
}

// A pair in units of one sample of weight 1.
double number_of(int64_t lo, int64_t hi) noexcept {
    return (static_cast<double>(hi) * kernels::kFoldBase + static_cast<double>(lo)) / kernels::kOne;
}

// Sums that no samples have: queries would divide by them.
void check_totals(const Totals &totals, const Grid &grid, bool turned) {
    const auto samples = static_cast<double>(totals.count),
               most = 2 * samples; // weights and values are at most 1, nearly
    check_pair(totals.weight, totals.weight_high, samples);
    check_pair(totals.value, totals.value_high, samples);
    check_pair(totals.value_low, totals.value_low_high, samples);
    for (const ExactSum *sum : {&totals.w, &totals.wy, &totals.wyy})
        check_exact(*sum, most);
    check_exact(totals.wt, most * kMostTime);
    check_exact(totals.wtt, most * kMostTime * kMostTime);
    constexpr double kRounding = 1e-9;
    const auto w = static_cast<double>(totals.w.value()), wy = static_cast<double>(totals.wy.value()),
               wyy = static_cast<double>(totals.wyy.value());
    const double lightest = std::pow(grid.sigma_floor / grid.sigma_ceiling, 2), rounding = kRounding * samples;
    if (!(w >= samples * lightest * (1 - kRounding) && w <= samples * (1 + kRounding)))
        fail(Status::format, "%s: {count} = %g, sum of weights %g: must be %g to 1 a sample", kKind, samples, w,
             lightest);
    if (!(std::fabs(wy) <= w * (1 + kRounding) && wyy >= -rounding && wyy <= w * (1 + kRounding)))
        fail(Status::format, "%s: sums of values %g and of their squares %g: at most the sum of weights, %g", kKind, wy,
             wyy, w);
    if (grid.double_limb() ||
        turned) // the pairs are for narrow sums; of other references they were rounded more coarsely
        return;
    const double value =
        number_of(totals.value, totals.value_high) + number_of(totals.value_low, totals.value_low_high) / kernels::kOne;
    if (!(std::fabs(number_of(totals.weight, totals.weight_high) - w) <= rounding && std::fabs(value - wy) <= rounding))
        fail(Status::format, "%s: the sums of weights or of values do not fit each other", kKind);
}

Grid take_grid(ByteReader &in) {
    if (std::memcmp(in.raw(sizeof kMagic), kMagic, sizeof kMagic) != 0)
        fail(Status::format, "%s: does not begin with \"TLMP\"", kKind);
    const uint32_t version = in.u32();
    if (version != kVersion)
        fail(Status::format, "%s: version %u, this library reads %u only: push the samples anew", kKind, version,
             kVersion);
    const uint32_t flags = in.u32();
    if ((flags & ~(kFixedMean | kWide | kTurned)) != 0 || in.u32() != 0)
        fail(Status::format, "%s: unknown flags 0x%x", kKind, flags);
    Grid grid;
    grid.fixed_mean = (flags & kFixedMean) != 0;
    grid.double_limb_sums = (flags & kWide) != 0;
    grid.nf = in.i64();
    for (double *value : {&grid.f0, &grid.df, &grid.time_offset, &grid.value_offset, &grid.value_bound,
                          &grid.sigma_floor, &grid.sigma_ceiling})
        *value = in.f64();
    grid.time_offset_ns = in.i64();
    grid.unit_ns = in.f64();
    try {
        grid.check();
    } catch (const Error &error) {
        fail_within(error, Status::format, "%s: %s", kKind, error.what());
    }
    if (grid.double_limb_sums != grid.double_limb())
        fail(Status::format, "%s: flags 0x%x: sums of these sigmas are wide", kKind, flags);
    if (in.u64() != grid.digest())
        fail(Status::format, "%s: the identity digest does not fit the header", kKind);
    return grid;
}

} // namespace

size_t Stream::saved_size() const noexcept {
    return state_size(grid_);
}

size_t Stream::saved_size(const void *header, size_t size) {
    ByteReader in(header, size, kKind);
    return state_size(take_grid(in));
}

Grid Stream::load_header(const void *header, size_t size) {
    ByteReader in(header, size, kKind);
    return take_grid(in);
}

std::vector<uint8_t> Stream::header(const Grid &grid) {
    ByteWriter out;
    out.raw(kMagic, sizeof kMagic);
    out.u32(kVersion);
    out.u32((grid.fixed_mean ? kFixedMean : 0) | (grid.double_limb() ? kWide : 0));
    out.u32(0);
    out.i64(grid.nf);
    for (double value : {grid.f0, grid.df, grid.time_offset, grid.value_offset, grid.value_bound, grid.sigma_floor,
                         grid.sigma_ceiling})
        out.f64(value);
    out.i64(grid.time_offset_ns);
    out.f64(grid.unit_ns);
    out.u64(grid.digest());
    return out.take();
}

// Sums that can have come from samples; Status::format else.
void Stream::check_sums() const {
    check_totals(totals_, grid_, turned_);
    if (!possible())
        fail(Status::format, "%s: the sums of values, of times and of their squares do not fit each other", kKind);
    const auto samples = static_cast<double>(totals_.count), weight = static_cast<double>(totals_.w.value());
    for (size_t sum = 0; sum < grid_.sums(); sum++)
        for (size_t k = 0; k < static_cast<size_t>(grid_.nf); k++)
            check_pair(lo_[sum * padded() + k], hi_[sum * padded() + k], sum < kernels::kYCLow ? weight : samples);
}

std::vector<uint8_t> Stream::save() const {
    try {
        check_sums();
    } catch (const Error &error) { // it could not be loaded again
        fail_within(error, Status::state, "%s: were samples taken back that never came, or came by a merge?",
                    error.what());
    }
    ByteWriter out;
    std::vector<uint8_t> start = header(grid_);
    start[kFlagsAt] = static_cast<uint8_t>(start[kFlagsAt] | (turned_ ? kTurned : 0));
    out.raw(start.data(), start.size());
    out.i64(totals_.count);
    save_pair(out, totals_.weight, totals_.weight_high);
    save_pair(out, totals_.value, totals_.value_high);
    save_pair(out, totals_.value_low, totals_.value_low_high);
    for (const ExactSum *sum : {&totals_.w, &totals_.wy, &totals_.wyy, &totals_.wt, &totals_.wtt})
        save_exact(out, *sum);
    for (size_t sum = 0; sum < grid_.sums(); sum++)
        for (size_t k = 0; k < static_cast<size_t>(grid_.nf); k++)
            save_pair(out, lo_[sum * padded() + k], hi_[sum * padded() + k]);
    out.u32(zip::crc32(out.bytes().data(), out.bytes().size()));
    return out.take();
}

Stream Stream::load(const void *bytes, size_t size) {
    ByteReader in(bytes, size, kKind);
    const Grid grid = take_grid(in);
    if (size != state_size(grid))
        fail(Status::format, "%s: %zu bytes, a grid of %lld frequencies takes %zu", kKind, size,
             static_cast<long long>(grid.nf), state_size(grid));
    ByteReader trailer(static_cast<const uint8_t *>(bytes) + size - kCrcSize, kCrcSize, kKind);
    if (trailer.u32() != zip::crc32(bytes, size - kCrcSize))
        fail(Status::format, "%s: checksum mismatch, the bytes are damaged", kKind);
    Stream stream(grid);
    stream.turned_ = (static_cast<const uint8_t *>(bytes)[kFlagsAt] & kTurned) != 0;
    Totals &totals = stream.totals_;
    totals.count = in.i64();
    const int64_t count = totals.count;
    if (count < 0 || count > kMostSamples)
        fail(Status::format, "%s: {count} = %lld: must be in [0, %lld]", kKind, static_cast<long long>(count),
             static_cast<long long>(kMostSamples));
    load_pair(in, totals.weight, totals.weight_high);
    load_pair(in, totals.value, totals.value_high);
    load_pair(in, totals.value_low, totals.value_low_high);
    for (ExactSum *sum : {&totals.w, &totals.wy, &totals.wyy, &totals.wt, &totals.wtt})
        load_exact(in, *sum);
    for (size_t sum = 0; sum < grid.sums(); sum++)
        for (size_t k = 0; k < static_cast<size_t>(grid.nf); k++)
            load_pair(in, stream.lo_[sum * stream.padded() + k], stream.hi_[sum * stream.padded() + k]);
    stream.check_sums();
    stream.taken_back_ = true; // nobody knows
    return stream;
}

} // namespace toliman::period
