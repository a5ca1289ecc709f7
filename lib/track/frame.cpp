// Method: a frame is invalid if a pixel is not finite or exceeds the bit depth, or if consecutive zero pixels reach the
// length of a lost packet. Most rows have neither: a branch-free pass per row, which vectorises, decides whether the
// row needs the scan pixel by pixel. CRC32 covers the pixels row by row, so that the stride does not change it.
#include "track/frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "base/error.hpp"

namespace toliman::track {

namespace {

// Largest allowed pixel value: below 2^bit_depth, or the largest of the type.
template <class T> T largest_pixel(uint32_t bit_depth) noexcept {
    const double end = std::ldexp(1.0, static_cast<int>(bit_depth)); // bit_depth = 0: not used
    const T largest = std::numeric_limits<T>::max();
    if (bit_depth == 0 || end > static_cast<double>(largest))
        return largest;
    if constexpr (std::is_floating_point_v<T>)
        return std::nextafter(static_cast<T>(end), T{0});
    else
        return static_cast<T>(end - 1);
}

// Returns whether no pixel of a row is zero, not finite or above the largest value; without branches.
template <class T> bool has_no_flaw_candidate(const T *row, size_t cols, ValueOf<T> largest) noexcept {
    using Value = ValueOf<T>;
    int bad = 0;
    for (size_t c = 0; c < cols; c++)
        bad |= static_cast<int>(!(row[c] <= largest)) | static_cast<int>(row[c] == 0);
    if constexpr (std::is_floating_point_v<Value>)
        for (size_t c = 0; c < cols; c++)
            bad |= static_cast<int>(!(row[c] >= -std::numeric_limits<Value>::max()));
    return bad == 0;
}

// Returns the first pixel that is not finite or above the largest value, or that completes a run of zero pixels.
template <class T> Flaw first_flaw(const T *pixels, const Frame &frame, const Geometry &geometry) noexcept {
    const auto largest = largest_pixel<ValueOf<T>>(geometry.bit_depth);
    const size_t zero_run = geometry.zero_run > 0 ? (geometry.zero_run + sizeof(T) - 1) / sizeof(T) : SIZE_MAX;
    size_t zeros = 0;
    for (size_t r = 0; r < frame.rows; r++) {
        const T *row = pixels + r * frame.stride;
        if (has_no_flaw_candidate(row, frame.cols, largest)) {
            zeros = 0;
            continue;
        }
        for (size_t c = 0; c < frame.cols; c++) {
            const auto value = static_cast<double>(row[c]);
            zeros = value == 0 ? zeros + 1 : 0;
            if (!(row[c] <= largest) || !std::isfinite(value))
                return {std::isfinite(value) ? Reason::over_range : Reason::not_finite, r, c, value};
            if (zeros >= zero_run)
                return {Reason::zero_run, r, c, value};
        }
    }
    return {};
}

template <class T>
Flaw check_and_bin_pixels(const T *pixels, const Frame &frame, const Geometry &geometry, double *out) noexcept {
    const Flaw flaw = first_flaw(pixels, frame, geometry);
    if (flaw.reason != Reason::none)
        return flaw;
    if (geometry.bin > 1)
        std::fill_n(out, geometry.out_rows * geometry.out_cols, 0.0);
    for (size_t r = 0; r < geometry.out_rows * geometry.bin; r++) {
        const T *row = pixels + (geometry.crop_row + r) * frame.stride + geometry.crop_col;
        double *sums = out + r / geometry.bin * geometry.out_cols;
        if (geometry.bin == 1)
            for (size_t c = 0; c < geometry.out_cols; c++)
                sums[c] = static_cast<double>(row[c]);
        else
            for (size_t c = 0; c < geometry.out_cols * geometry.bin; c++)
                sums[c / geometry.bin] += static_cast<double>(row[c]);
    }
    return {};
}

} // namespace

void Geometry::check() const {
    if (rows < 1 || cols < 1 || out_rows < 1 || out_cols < 1 || bin < 1)
        fail(Status::argument, "{rows} = %zu, cols = %zu, image %zux%zu, bin = %zu: must be at least 1", rows, cols,
             out_rows, out_cols, bin);
    if (out_rows > rows / bin || out_cols > cols / bin || crop_row > rows - out_rows * bin ||
        crop_col > cols - out_cols * bin)
        fail(Status::argument,
             "{crop_row} = %zu, crop_col = %zu, bin = %zu: an image of %zux%zu pixels does not fit in "
             "frames of %zux%zu",
             crop_row, crop_col, bin, out_rows, out_cols, rows, cols);
    if (bit_depth > 32)
        fail(Status::argument, "{bit_depth} = %u: must be at most 32, or 0 for any value", bit_depth);
}

double mean_shift_s(const Frame &frame) noexcept {
    double length = 0, moment = 0;
    for (size_t i = 0; i < frame.interval_count; i++) {
        const double start = frame.intervals[2 * i], end = frame.intervals[2 * i + 1];
        length += end - start;
        moment += (end - start) * (start + end) / 2;
    }
    return frame.interval_count > 0 ? moment / length - frame.exposure_s / 2 : 0;
}

uint32_t content_of(const Frame &frame) noexcept {
    const uint64_t numbers[] = {static_cast<uint64_t>(frame.camera_ns),
                                static_cast<uint64_t>(frame.dropped),
                                with_bits<uint64_t>(frame.sigma),
                                frame.rows,
                                frame.cols,
                                static_cast<uint64_t>(frame.pixel),
                                with_bits<uint64_t>(frame.exposure_s),
                                static_cast<uint64_t>(frame.window_row),
                                static_cast<uint64_t>(frame.window_col),
                                frame.interval_count};
    uint8_t bytes[sizeof numbers], *at = bytes;
    for (const uint64_t number : numbers)
        at = put_number(at, number, 8);
    uint32_t crc = zip::crc32(bytes, sizeof bytes);
    if (frame.interval_count > 0)
        crc = zip::crc32(frame.intervals, frame.interval_count * 2 * sizeof(double), crc);
    if (frame.spread.any()) {
        const Spread &spread = frame.spread;
        const double known[] = {spread.frames, spread.xx, spread.yy, spread.xy};
        crc = zip::crc32(spread.cumulants.data(), kCumulants * sizeof(double), zip::crc32(known, sizeof known, crc));
    }
    const size_t width = size_of(frame.pixel);
    if (frame.stride == frame.cols)
        return zip::crc32(frame.pixels, frame.rows * frame.cols * width, crc);
    for (size_t r = 0; r < frame.rows; r++)
        crc =
            zip::crc32(static_cast<const uint8_t *>(frame.pixels) + r * frame.stride * width, frame.cols * width, crc);
    return crc;
}

Flaw check_and_bin(const Frame &frame, const Geometry &geometry, double *out) noexcept {
    if (frame.rows != geometry.rows || frame.cols != geometry.cols)
        return {Reason::shape, frame.rows, frame.cols, 0};
    return with_pixels(frame.pixel, frame.pixels,
                       [&](auto first) { return check_and_bin_pixels(first, frame, geometry, out); });
}

} // namespace toliman::track
