// Method: integer sums of the counts of each pixel. Where a pixel of a frame is left out, the counts that the
// registered model expects there are summed in its place, so that the pixel of the sum has the expectation of all
// frames, wherever the stars were in those frames. (Counts scaled by N/n, N frames of which n were used, would be
// biased: a pixel saturates when the stars are near.) Its variance lacks that of the expected counts: it is (N - n)/N
// smaller. A model that is wrong by a relative e in that pixel adds the error e (N - n)/N.
// All sums are integers, also those of places and times, so that their bits do not depend on the order of frames.
// A sum ends before a frame that is beyond a limit. That of motion compares a running mean of the last kRecent places
// with that of the first: it alone depends on the order.
#include "coadd/coadd.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/hash.hpp"

namespace toliman::coadd {

namespace {

constexpr int kFillBits = 12;
constexpr int64_t kRecent = 128;    // frames
constexpr uint32_t kFlushed = 4096; // frames between two flushes
constexpr uint32_t kMostFrames = 1u << 30;
constexpr int64_t kMostPhotons = int64_t{1} << 30; // of a frame

int64_t floor_div(int64_t a, int64_t b) noexcept {
    return a / b - (a % b < 0 ? 1 : 0);
}

int64_t integer(double value, int64_t most) noexcept {
    return std::clamp(static_cast<int64_t>(std::llround(value)), int64_t{1}, most);
}

uint64_t digest_of(const fit::Fit &fit, const fit::Prediction &prediction, const Limits &limits) noexcept {
    return fnv1a(std::array<double, 9>{prediction.days, prediction.shift_px[0], prediction.shift_px[1],
                                       prediction.separation_px, prediction.position_angle_deg,
                                       static_cast<double>(limits.range), limits.most_chi_square,
                                       static_cast<double>(limits.pause_ns), 1},
                 fit.digest());
}

} // namespace

int64_t mean_ns(const Totals &totals) noexcept {
    const Wide photons = totals.photons, twice = 2 * totals.photon_ns + photons, mean = twice / (2 * photons);
    return static_cast<int64_t>(mean - (twice % (2 * photons) < 0 ? 1 : 0));
}

Coadd::Coadd(std::shared_ptr<const fit::Fit> fit, const fit::Prediction &prediction, const Limits &limits,
             unsigned workers, const Progress &progress)
    : fit_(std::move(fit)), limits_(limits),
      registration_(*fit_, prediction, limits.range, limits.most_chi_square, workers, progress),
      digest_(digest_of(*fit_, prediction, limits)) {
    const size_t pixels = rows() * cols();
    for (Buffer<uint32_t> *const array : {&recent_, &counts_, &left_out_, &taken_.counts, &taken_.left_out})
        array->resize(pixels);
    filled_.resize(pixels);
}

End Coadd::end_before(const Frame &frame) const noexcept {
    const int64_t start = frame.middle_ns - frame.exposure_ns / 2, end = start + frame.exposure_ns;
    const Intervals &intervals = totals_.intervals;
    if (std::strcmp(totals_.session, frame.session) != 0 || std::strcmp(totals_.roi, frame.roi) != 0 ||
        totals_.window_row != frame.window_row || totals_.window_col != frame.window_col)
        return End::source;
    if (limits_.duration_ns > 0) {
        const bool other =
            limits_.aligned
                ? floor_div(frame.middle_ns, limits_.duration_ns) !=
                      floor_div((intervals.first() + intervals.last()) / 2, limits_.duration_ns)
                : std::max(end, intervals.last()) - std::min(start, intervals.first()) > limits_.duration_ns;
        if (other)
            return End::time;
    }
    if (limits_.gap_ns > 0 && (start - intervals.last() > limits_.gap_ns || intervals.first() - end > limits_.gap_ns))
        return End::gap;
    if (limits_.motion_px > 0 && totals_.frames >= 2 * kRecent &&
        std::hypot(totals_.recent_place[0] - totals_.first_place[0], totals_.recent_place[1] - totals_.first_place[1]) >
            limits_.motion_px)
        return End::motion;
    if (!intervals.accepts(start, end, limits_.pause_ns) || totals_.frames >= kMostFrames ||
        (largest_ > UINT32_MAX - kFlushed * UINT16_MAX - UINT16_MAX && unflushed_ == 0))
        return End::full;
    return End::none;
}

void Coadd::add(const Frame &frame, Registered &out, End &end) noexcept {
    end = totals_.frames > 0 ? end_before(frame) : End::none;
    if (end != End::none) {
        out.verdict = Verdict::next;
        return;
    }
    registration_.frame(frame.pixels, out);
    totals_.verdicts[static_cast<size_t>(out.verdict)]++;
    totals_.dropped = std::min(totals_.dropped, INT64_MAX - frame.dropped) + frame.dropped; // saturates
    if (out.verdict != Verdict::added)
        return;
    if (totals_.frames == 0) {
        std::strncpy(totals_.session, frame.session, kMostName);
        std::strncpy(totals_.roi, frame.roi, kMostName);
        totals_.window_row = frame.window_row;
        totals_.window_col = frame.window_col;
    }
    const int64_t photons = integer(out.flux * registration_.photons(), kMostPhotons);
    const int64_t start = frame.middle_ns - frame.exposure_ns / 2;
    totals_.intervals.add(start, start + frame.exposure_ns, limits_.pause_ns);
    add_place(out);
    totals_.frames++;
    totals_.photons += photons;
    totals_.photon_ns += static_cast<Wide>(photons) * frame.middle_ns;
    totals_.moments.add(photons, out.x, out.y, out.xx, out.xy, out.yy);
    totals_.chi_square.add(1, out.chi_square);
    totals_.flux.add(1, out.flux);
    totals_.cosmic_rays += static_cast<int64_t>(out.left_out - out.saturated);
    totals_.saturated += static_cast<int64_t>(out.saturated);
    add_pixels(frame.pixels, out);
}

void Coadd::add_place(const Registered &found) noexcept {
    const double place[2] = {found.x, found.y};
    const auto seen = static_cast<double>(std::min(totals_.frames, kRecent - 1)) + 1;
    for (size_t axis = 0; axis < 2; axis++) {
        totals_.recent_place[axis] += (place[axis] - totals_.recent_place[axis]) / seen;
        if (totals_.frames < kRecent)
            totals_.first_place[axis] = totals_.recent_place[axis];
    }
}

void Coadd::add_pixels(const kernels::CoaddFrame &frame, const Registered &found) noexcept {
    kernels::coadd_kernels().add(frame, recent_.data());
    for (size_t i = 0; i < found.left_out; i++) {
        const uint32_t pixel = found.pixels[i];
        recent_[pixel] -= frame.counts[pixel / frame.cols * frame.stride + pixel % frame.cols];
        left_out_[pixel]++;
        filled_[pixel] += std::llround(static_cast<double>(found.expected[i]) * (1 << kFillBits));
    }
    if (++unflushed_ == kFlushed)
        flush();
}

void Coadd::flush() noexcept {
    unflushed_ = 0;
    for (size_t i = 0; i < counts_.size(); i++) {
        counts_[i] += recent_[i];
        recent_[i] = 0;
        largest_ = std::max(largest_, counts_[i]);
    }
}

void Coadd::take() noexcept {
    flush();
    for (size_t i = 0; i < counts_.size(); i++) {
        const int64_t filled = (filled_[i] + (1 << (kFillBits - 1))) >> kFillBits;
        taken_.counts[i] = static_cast<uint32_t>(std::clamp<int64_t>(counts_[i] + filled, 0, UINT32_MAX));
    }
    std::swap(taken_.left_out, left_out_);
    std::swap(taken_.totals, totals_);
    taken_.number = number_++;
    std::fill(counts_.begin(), counts_.end(), 0);
    std::fill(left_out_.begin(), left_out_.end(), 0);
    std::fill(filled_.begin(), filled_.end(), 0);
    largest_ = 0;
    totals_ = {};
}

size_t Coadd::bytes() const noexcept {
    return registration_.bytes() + counts_.size() * (3 * sizeof(uint32_t) + sizeof(int64_t));
}

} // namespace toliman::coadd
