// State bytes of a periodogram ("TLMP", tools/docs/formats.md): header, totals, accumulators, CRC32.
// Method: every carry-save pair and exact sum is written in its one canonical form, so that equal sums give equal bytes
// in whatever order their samples came, and files of shards can be compared. On loading, a correct checksum is not
// trusted: sums that no set of samples has (found by fuzzing: a query converted 2e71 to an integer) are refused, by the
// bounds W <= count, |Wy| <= W, Wyy <= W, the Cauchy-Schwarz inequalities, and the range of every accumulator.
#include <cmath>

#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "period/stream/stream.hpp"

namespace toliman::period {

namespace {

constexpr char kMagic[] = {'T', 'L', 'M', 'P'};
constexpr uint32_t kVersion = 4, kVersionWithoutBasis = 3;
constexpr uint32_t kFixedMean = 1, kDoubleLimb = 2, kRereferenced = 4;
constexpr size_t kFlagsAt = 8;
constexpr uint32_t kColumnsAt = 8; // bit of the first: trend and columns share a number
constexpr char kKind[] = "periodogram state";
constexpr size_t kExactSize = size_t{ExactSum::kPlaces} * 8;
constexpr size_t kSumSize = 12; // i64 upper part, u32 lower part
constexpr size_t kTotalsSize = 8 + 3 * kSumSize + 5 * kExactSize;
constexpr size_t kCrcSize = 4;

size_t state_size(const Grid &grid, bool with_basis) noexcept {
    const size_t basis = with_basis ? grid.basis.saved_size() : 0;
    return Stream::kHeaderSize + basis + kTotalsSize + BasisSums::count(grid.basis.functions()) * kExactSize +
           static_cast<size_t>(grid.nf) * grid.sums() * kSumSize + kCrcSize;
}

// Writes a carry-save pair in its canonical form: the lower part in [0, 2^32).
void save_pair(ByteWriter &out, int64_t lo, int64_t hi) {
    out.i64(hi + (lo >> 32));
    out.u32(static_cast<uint32_t>(lo & (kernels::kFoldBase - 1)));
}

void load_pair(ByteReader &in, int64_t &lo, int64_t &hi) {
    hi = in.i64();
    lo = in.u32();
}

// Checks that the magnitude of a pair is at most `bound` 2^50, up to rounding.
void check_pair(int64_t lo, int64_t hi, double bound) {
    const auto limit = static_cast<int64_t>((bound + 1) * 0x1p18);
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
    const Quad value = sum.value(), bound = static_cast<Quad>(limit);
    if (value > bound || value < -bound)
        fail(Status::format, "%s: an exact sum is out of range", kKind);
}

// Value of a pair, in units of one sample of weight 1.
double pair_value(int64_t lo, int64_t hi) noexcept {
    return (static_cast<double>(hi) * kernels::kFoldBase + static_cast<double>(lo)) / kernels::kOne;
}

// Fails for totals that no set of samples has: queries would divide by them.
void check_totals(const Totals &totals, const Grid &grid, bool rereferenced) {
    const auto samples = static_cast<double>(totals.count),
               bound = 2 * samples; // weights and |values| are at most 1, up to rounding
    check_pair(totals.weight, totals.weight_high, samples);
    check_pair(totals.value, totals.value_high, samples);
    check_pair(totals.value_low, totals.value_low_high, samples);
    for (const ExactSum *sum : {&totals.w, &totals.wy, &totals.wyy})
        check_exact(*sum, bound);
    check_exact(totals.wt, bound * kMaxTime);
    check_exact(totals.wtt, bound * kMaxTime * kMaxTime);
    constexpr double kRounding = 1e-9;
    const auto w = static_cast<double>(totals.w.value()), wy = static_cast<double>(totals.wy.value()),
               wyy = static_cast<double>(totals.wyy.value());
    const double lightest = std::pow(grid.sigma_floor / grid.sigma_ceiling, 2), rounding = kRounding * samples;
    if (!(w >= samples * lightest * (1 - kRounding) && w <= samples * (1 + kRounding)))
        fail(Status::format, "%s: {count} = %g, sum of weights = %g: must be in [%g, 1] per sample", kKind, samples, w,
             lightest);
    if (!(std::fabs(wy) <= w * (1 + kRounding) && wyy >= -rounding && wyy <= w * (1 + kRounding)))
        fail(Status::format,
             "%s: sum of values = %g, sum of squared values = %g: must be at most the sum of weights, %g", kKind, wy,
             wyy, w);
    if (grid.double_limb() ||
        rereferenced) // only single-limb queries use the pairs; re-referencing rounded them more coarsely
        return;
    const double value = pair_value(totals.value, totals.value_high) +
                         pair_value(totals.value_low, totals.value_low_high) / kernels::kOne;
    if (!(std::fabs(pair_value(totals.weight, totals.weight_high) - w) <= rounding &&
          std::fabs(value - wy) <= rounding))
        fail(Status::format, "%s: the exact and the quantised sums of weights or of values are inconsistent", kKind);
}

// The numbers of functions; 0 of both, with which a version 4 has a prior of the mean, in version 3.
void read_functions(uint32_t numbers, uint32_t version, Basis &basis) {
    basis.trend = static_cast<int32_t>(numbers & 0xff);
    basis.columns = static_cast<int32_t>(numbers >> kColumnsAt);
    const int64_t total = int64_t{basis.trend} + basis.columns;
    if (total >= static_cast<int64_t>(kMaxFunctions) || (version == kVersionWithoutBasis && total > 0))
        fail(Status::format, "%s: version %u with %d trends and %d columns", kKind, version, basis.trend,
             basis.columns);
}

// The part of the header that determines its size. Sets `digest` to the digest that follows.
Grid read_start(ByteReader &in, uint32_t &version, uint64_t &digest) {
    if (std::memcmp(in.raw(sizeof kMagic), kMagic, sizeof kMagic) != 0)
        fail(Status::format, "%s: does not begin with \"TLMP\"", kKind);
    version = in.u32();
    if (version != kVersion && version != kVersionWithoutBasis)
        fail(Status::format, "%s: unsupported version %u (supported: %u, %u): push the samples again", kKind, version,
             kVersionWithoutBasis, kVersion);
    const uint32_t flags = in.u32();
    if ((flags & ~(kFixedMean | kDoubleLimb | kRereferenced)) != 0)
        fail(Status::format, "%s: unknown flags 0x%x", kKind, flags);
    Grid grid;
    read_functions(in.u32(), version, grid.basis);
    grid.fixed_mean = (flags & kFixedMean) != 0;
    grid.double_limb_sums = (flags & kDoubleLimb) != 0;
    grid.nf = in.i64();
    for (double *value : {&grid.f0, &grid.df, &grid.time_offset, &grid.value_offset, &grid.value_bound,
                          &grid.sigma_floor, &grid.sigma_ceiling})
        *value = in.f64();
    grid.time_offset_ns = in.i64();
    grid.unit_ns = in.f64();
    digest = in.u64();
    return grid;
}

void check_grid(const Grid &grid) {
    try {
        grid.check();
    } catch (const Error &error) {
        fail_within(error, Status::format, "%s: %s", kKind, error.what());
    }
}

Grid read_grid(ByteReader &in) {
    uint32_t version;
    uint64_t digest;
    Grid grid = read_start(in, version, digest);
    if (version == kVersion)
        grid.basis.load(in);
    check_grid(grid);
    if (grid.double_limb_sums != grid.double_limb())
        fail(Status::format, "%s: flags: these sigmas require double-limb accumulators", kKind);
    if (grid.basis.any() != (version == kVersion))
        fail(Status::format, "%s: version %u without nuisance functions", kKind, version);
    if (digest != grid.digest())
        fail(Status::format, "%s: the identity digest does not match the header", kKind);
    return grid;
}

} // namespace

size_t Stream::saved_size() const noexcept {
    return state_size(grid_, grid_.basis.any());
}

size_t Stream::saved_size(const void *header, size_t size) {
    ByteReader in(header, size, kKind);
    uint32_t version;
    uint64_t digest;
    const Grid grid = read_start(in, version, digest);
    if (version == kVersion) { // the rest of the header follows kHeaderSize
        Grid plain = grid;
        plain.basis = {};
        check_grid(plain);
        return state_size(grid, true);
    }
    ByteReader whole(header, size, kKind);
    return state_size(read_grid(whole), false);
}

Grid Stream::load_header(const void *header, size_t size) {
    ByteReader in(header, size, kKind);
    return read_grid(in);
}

std::vector<uint8_t> Stream::header(const Grid &grid) {
    ByteWriter out;
    out.raw(kMagic, sizeof kMagic);
    const Basis &basis = grid.basis;
    out.u32(basis.any() ? kVersion : kVersionWithoutBasis);
    out.u32((grid.fixed_mean ? kFixedMean : 0) | (grid.double_limb() ? kDoubleLimb : 0));
    out.u32(static_cast<uint32_t>(basis.trend) | static_cast<uint32_t>(basis.columns) << kColumnsAt);
    out.i64(grid.nf);
    for (double value : {grid.f0, grid.df, grid.time_offset, grid.value_offset, grid.value_bound, grid.sigma_floor,
                         grid.sigma_ceiling})
        out.f64(value);
    out.i64(grid.time_offset_ns);
    out.f64(grid.unit_ns);
    out.u64(grid.digest());
    if (basis.any())
        basis.save(out);
    return out.take();
}

// Fails with Status::format for sums that no set of samples has.
void Stream::check_sums() const {
    check_totals(totals_, grid_, rereferenced_);
    const auto samples = static_cast<double>(totals_.count), weight = static_cast<double>(totals_.w.value());
    for (const ExactSum &sum : basis_sums_.all())
        check_exact(sum, 2 * samples);
    if (!consistent())
        fail(Status::format, "%s: the sums of values, of times and of their squares are inconsistent", kKind);
    for (size_t sum = 0; sum < grid_.sums(); sum++)
        for (size_t k = 0; k < static_cast<size_t>(grid_.nf); k++)
            check_pair(lo_[sum * padded() + k], hi_[sum * padded() + k], sum < kernels::kYCLow ? weight : samples);
}

std::vector<uint8_t> Stream::save() const {
    try {
        check_sums();
    } catch (const Error &error) { // load() would refuse them
        fail_within(
            error, Status::state,
            "%s: samples may have been retracted that were never pushed, or that were merged from other references",
            error.what());
    }
    ByteWriter out;
    std::vector<uint8_t> start = header(grid_);
    start[kFlagsAt] = static_cast<uint8_t>(start[kFlagsAt] | (rereferenced_ ? kRereferenced : 0));
    out.raw(start.data(), start.size());
    out.i64(totals_.count);
    save_pair(out, totals_.weight, totals_.weight_high);
    save_pair(out, totals_.value, totals_.value_high);
    save_pair(out, totals_.value_low, totals_.value_low_high);
    for (const ExactSum *sum : {&totals_.w, &totals_.wy, &totals_.wyy, &totals_.wt, &totals_.wtt})
        save_exact(out, *sum);
    for (const ExactSum &sum : basis_sums_.all())
        save_exact(out, sum);
    for (size_t sum = 0; sum < grid_.sums(); sum++)
        for (size_t k = 0; k < static_cast<size_t>(grid_.nf); k++)
            save_pair(out, lo_[sum * padded() + k], hi_[sum * padded() + k]);
    out.u32(zip::crc32(out.bytes().data(), out.bytes().size()));
    return out.take();
}

size_t Stream::header_size(const void *start) {
    ByteReader in(start, kHeaderSize, kKind);
    uint32_t version;
    uint64_t digest;
    const Grid grid = read_start(in, version, digest);
    return kHeaderSize + (version == kVersion ? grid.basis.saved_size() : 0);
}

Stream Stream::load(const void *bytes, size_t size) {
    ByteReader in(bytes, size, kKind);
    const Grid grid = read_grid(in);
    const size_t whole = state_size(grid, grid.basis.any());
    if (size != whole)
        fail(Status::format, "%s: %zu bytes: must be %zu for a grid of %lld frequencies", kKind, size, whole,
             static_cast<long long>(grid.nf));
    ByteReader trailer(static_cast<const uint8_t *>(bytes) + size - kCrcSize, kCrcSize, kKind);
    if (trailer.u32() != zip::crc32(bytes, size - kCrcSize))
        fail(Status::format, "%s: checksum mismatch: the bytes are damaged", kKind);
    Stream stream(grid);
    stream.rereferenced_ = (static_cast<const uint8_t *>(bytes)[kFlagsAt] & kRereferenced) != 0;
    Totals &totals = stream.totals_;
    totals.count = in.i64();
    const int64_t count = totals.count;
    if (count < 0 || count > kMaxSamples)
        fail(Status::format, "%s: {count} = %lld: must be in [0, %lld]", kKind, static_cast<long long>(count),
             static_cast<long long>(kMaxSamples));
    load_pair(in, totals.weight, totals.weight_high);
    load_pair(in, totals.value, totals.value_high);
    load_pair(in, totals.value_low, totals.value_low_high);
    for (ExactSum *sum : {&totals.w, &totals.wy, &totals.wyy, &totals.wt, &totals.wtt})
        load_exact(in, *sum);
    for (ExactSum &sum : stream.basis_sums_.all())
        load_exact(in, sum);
    for (size_t sum = 0; sum < grid.sums(); sum++)
        for (size_t k = 0; k < static_cast<size_t>(grid.nf); k++)
            load_pair(in, stream.lo_[sum * stream.padded() + k], stream.hi_[sum * stream.padded() + k]);
    stream.check_sums();
    stream.retracted_ = true; // not part of the state bytes: assume it
    return stream;
}

} // namespace toliman::period
