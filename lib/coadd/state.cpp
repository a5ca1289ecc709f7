// Format: "TLMA", version, digest of all that determines the sums, shape, number of the sum, totals, arrays, CRC32;
// every number little-endian (tools/docs/formats.md). Equal sums give equal bytes: recent counts are added to the
// others.
#include <algorithm>
#include <cmath>

#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "coadd/coadd.hpp"

namespace toliman::coadd {

namespace {

constexpr char kMagic[] = {'T', 'L', 'M', 'A'};
constexpr uint32_t kVersion = 1;
constexpr int64_t kMost = int64_t{1} << 60; // of a count, so that sums fit
constexpr double kFarthest = 1e6;           // px, of a star from the centre
constexpr char kKind[] = "state of a sum";
constexpr size_t kBeforeArrays = 4 + 4 + 8 + 4 + 4 + 8, kPixelSize = 4 + 4 + 8, kWideSize = 16;
constexpr size_t kTotalsSize = 2 * (kMostName + 1) + kWideSize + 4 * 8 + (7 + kVerdicts) * 8 +
                               (2 + fit::kSpreadTerms + 3) * kWideSize + 8 + kMostIntervals * 16;

// Visits all integers and sums of the totals in their order in the file.
template <class Integer, class Sum> void for_each(Totals &totals, Integer integer, Sum sum) {
    for (int64_t *const number : {&totals.window_row, &totals.window_col, &totals.frames, &totals.photons,
                                  &totals.dropped, &totals.cosmic_rays, &totals.saturated})
        integer(*number);
    for (int64_t &number : totals.verdicts)
        integer(number);
    sum(totals.chi_square);
    sum(totals.flux);
    sum(totals.moments);
    sum(totals.intervals);
}

void save(ByteWriter &out, Totals totals) {
    out.raw(totals.session, sizeof totals.session);
    out.raw(totals.roi, sizeof totals.roi);
    out.u64(static_cast<uint64_t>(totals.photon_ns));
    out.i64(static_cast<int64_t>(totals.photon_ns >> 64));
    for (size_t axis = 0; axis < 2; axis++) {
        out.f64(totals.first_place[axis]);
        out.f64(totals.recent_place[axis]);
    }
    for_each(
        totals, [&](int64_t number) { out.i64(number); }, [&](const auto &sum) { sum.save(out); });
}

void load_name(ByteReader &in, char *name) {
    std::memcpy(name, in.raw(kMostName + 1), kMostName + 1);
    if (name[kMostName] != 0)
        fail(Status::format, "%s: a name is longer than %zu characters", kKind, kMostName);
}

Totals load_totals(ByteReader &in) {
    Totals totals;
    load_name(in, totals.session);
    load_name(in, totals.roi);
    const uint64_t low = in.u64();
    totals.photon_ns = static_cast<Wide>(in.i64()) * (static_cast<Wide>(1) << 64) + static_cast<Wide>(low);
    for (size_t axis = 0; axis < 2; axis++) {
        totals.first_place[axis] = in.f64();
        totals.recent_place[axis] = in.f64();
    }
    for_each(
        totals, [&](int64_t &number) { number = in.i64(); }, [&](auto &sum) { sum.load(in); });
    for (const int64_t count : {totals.frames, totals.photons, totals.cosmic_rays, totals.saturated,
                                *std::min_element(totals.verdicts, totals.verdicts + kVerdicts),
                                *std::max_element(totals.verdicts, totals.verdicts + kVerdicts)})
        if (count < 0 || count > kMost)
            fail(Status::format, "%s: {count} = %lld: must be in [0, 2^60]", kKind, static_cast<long long>(count));
    for (const double place :
         {totals.first_place[0], totals.first_place[1], totals.recent_place[0], totals.recent_place[1]})
        if (!(std::fabs(place) <= kFarthest))
            fail(Status::format, "%s: {place} = %g px: impossible", kKind, place);
    const bool has_frames = totals.frames > 0;
    if (totals.dropped < 0 || has_frames != (totals.photons > 0) || has_frames != (totals.intervals.count() > 0))
        fail(Status::format, "%s: {frames} = %lld: impossible", kKind, static_cast<long long>(totals.frames));
    return totals;
}

} // namespace

size_t Coadd::saved_size() const noexcept {
    return kBeforeArrays + kTotalsSize + counts_.size() * kPixelSize + 4;
}

std::vector<uint8_t> Coadd::save() const {
    ByteWriter out;
    out.raw(kMagic, sizeof kMagic);
    out.u32(kVersion);
    out.u64(digest_);
    out.u32(static_cast<uint32_t>(rows()));
    out.u32(static_cast<uint32_t>(cols()));
    out.i64(number_);
    coadd::save(out, totals_);
    for (size_t i = 0; i < counts_.size(); i++) {
        out.u32(counts_[i] + recent_[i]);
        out.u32(left_out_[i]);
        out.i64(filled_[i]);
    }
    out.u32(zip::crc32(out.bytes().data(), out.bytes().size()));
    return out.take();
}

void Coadd::load(const void *bytes, size_t size) {
    ByteReader in(bytes, size, kKind);
    if (std::memcmp(in.raw(sizeof kMagic), kMagic, sizeof kMagic) != 0)
        fail(Status::format, "%s: does not begin with \"TLMA\"", kKind);
    if (const uint32_t version = in.u32(); version != kVersion)
        fail(Status::format, "%s: unsupported version %u (supported: %u)", kKind, version, kVersion);
    const uint64_t digest = in.u64();
    const size_t rows_of = in.u32(), cols_of = in.u32();
    if (digest != digest_ || rows_of != rows() || cols_of != cols())
        fail(Status::mismatch, "%s: is that of another scene, prediction or options", kKind);
    const int64_t number = in.i64();
    if (number < 0 || number > kMost)
        fail(Status::format, "%s: {number} = %lld: must be in [0, 2^60]", kKind, static_cast<long long>(number));
    const Totals totals = load_totals(in);
    const size_t pixels = counts_.size();
    if (in.left() != pixels * kPixelSize + 4)
        fail(Status::format, "%s: %zu bytes are left, must be %zu", kKind, in.left(), pixels * kPixelSize + 4);
    ByteReader arrays = in;
    in.raw(pixels * kPixelSize);
    if (in.u32() != zip::crc32(bytes, size - 4))
        fail(Status::format, "%s: is damaged: its CRC32 is wrong", kKind);
    number_ = number;
    totals_ = totals;
    unflushed_ = largest_ = 0;
    for (size_t i = 0; i < pixels; i++) {
        counts_[i] = arrays.u32();
        left_out_[i] = arrays.u32();
        filled_[i] = arrays.i64();
        recent_[i] = 0;
        largest_ = std::max(largest_, counts_[i]);
    }
}

} // namespace toliman::coadd
