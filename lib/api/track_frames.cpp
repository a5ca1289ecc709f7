#include "api/track_frames.hpp"

#include <cstdio>
#include <string>
#include <utility>

#include "api/members.hpp"
#include "api/pixel_frames.hpp"
#include "api/spread.hpp"
#include "api/track_results.hpp"
#include "base/error.hpp"
#include "base/name.hpp"

namespace toliman::api {

namespace {

constexpr size_t kMostIntervals = 65536;
constexpr int64_t kMostRestarts = int64_t{1} << 31;

void required_member(const void *pointer, size_t i, const char *name) {
    if (pointer == nullptr)
        fail(Status::argument, "{frames[%zu].%s} is NULL", i, name);
}

void check_name(const char *text, size_t i, const char *name) {
    required_member(text, i, name);
    if (is_name(text))
        return;
    char place[48];
    std::snprintf(place, sizeof place, "frames[%zu].%s", i, name);
    track::check_name(text, place);
}

// Checks exposure, intervals on target (increasing, within the exposure) and window position.
void check_exposure(const toliman_frame &given, size_t i) {
    if (!(given.exposure_s >= 0 && given.exposure_s <= kLongestExposure))
        fail(Status::argument, "{frames[%zu].exposure_s} = %g: must be in [0, %g]", i, given.exposure_s,
             kLongestExposure);
    for (const auto &[name, place] : {std::pair("window_row", given.window_row), {"window_col", given.window_col}})
        if (place < -kFarthestWindow || place > kFarthestWindow)
            fail(Status::argument, "{frames[%zu].%s} = %lld: must be in [-2^31, 2^31]", i, name,
                 static_cast<long long>(place));
    if (given.interval_count > kMostIntervals)
        fail(Status::argument, "{frames[%zu].interval_count} = %zu: must be at most %zu", i, given.interval_count,
             kMostIntervals);
    if (given.interval_count > 0)
        required_member(given.intervals, i, "intervals");
    double before = 0;
    for (size_t k = 0; k < given.interval_count; k++) {
        const double start = given.intervals[2 * k], end = given.intervals[2 * k + 1];
        if (!(start >= before && end > start && end <= given.exposure_s))
            fail(Status::argument,
                 "{frames[%zu].intervals[%zu]} = %g to %g: must increase, follow the previous interval and lie within "
                 "the exposure of %g s",
                 i, k, start, end, given.exposure_s);
        before = end;
    }
}

} // namespace

void check_frame(const toliman_frame &given, size_t i, const track::Terms &terms) {
    const auto refuse = [i](const char *name, int64_t value, const char *allowed) {
        fail(Status::argument, "{frames[%zu].%s} = %lld: must be %s", i, name, static_cast<long long>(value), allowed);
    };
    check_name(given.session, i, "session");
    check_name(given.roi, i, "roi");
    required_member(given.pixels, i, "pixels");
    if (!kPixels.contains(given.pixel))
        refuse("pixel", given.pixel, "one of TOLIMAN_PIXEL_..., 31 to 41");
    if (given.rows < 1 || given.rows > kLargestSide)
        refuse("rows", given.rows, "in [1, 65536]");
    if (given.cols < 1 || given.cols > kLargestSide)
        refuse("cols", given.cols, "in [1, 65536]");
    if (given.stride != 0 && (given.stride < given.cols || given.stride > INT32_MAX))
        refuse("stride", given.stride, "0 or in [cols, 2^31 - 1]");
    if (given.dropped < 0)
        refuse("dropped", given.dropped, "at least 0");
    if (given.restarts < 0 || given.restarts > kMostRestarts)
        refuse("restarts", given.restarts, "in [0, 2^31]");
    if (given.sigma != 0 && !terms.allows_sigma(given.sigma))
        fail(Status::argument, "{frames[%zu].sigma} = %g: must be 0 or in [%g, %g], 1 to 32 times the tracker's", i,
             given.sigma, terms.sigma, track::Terms::kMaxSigmaRatio * terms.sigma);
    check_exposure(given, i);
    if (given.spread != nullptr)
        spread_of(given.spread, ("frames[" + std::to_string(i) + "].spread").c_str());
    const size_t width = size_of(kPixels.to_enum(given.pixel, "pixel"));
    if (reinterpret_cast<uintptr_t>(given.pixels) % width != 0)
        fail(Status::argument, "{frames[%zu].pixels}: must be aligned to %zu bytes, the size of a pixel", i, width);
}

track::Frame frame_of(const toliman_frame &given) {
    track::Frame frame = {};
    TOLIMAN_COPY(frame, given, session, roi, frame_id, camera_ns, dropped, restarts);
    frame.sigma = given.sigma != 0 ? given.sigma : 0; // -0 becomes 0
    frame.pixel = kPixels.to_enum(given.pixel, "pixel");
    TOLIMAN_COPY(frame, given, pixels, rows, cols, intervals, interval_count, window_row, window_col);
    frame.stride = static_cast<size_t>(given.stride != 0 ? given.stride : given.cols);
    frame.exposure_s = given.exposure_s != 0 ? given.exposure_s : 0;
    frame.spread = spread_of(given.spread, "frames[].spread");
    return frame;
}

toliman_frame public_frame(const track::Frame &frame) noexcept {
    toliman_frame out = {};
    out.struct_size = sizeof out;
    TOLIMAN_COPY(out, frame, session, roi, frame_id, camera_ns, dropped, restarts, sigma, pixels);
    TOLIMAN_COPY(out, frame, rows, cols, stride, exposure_s, intervals, interval_count, window_row, window_col);
    out.pixel = kPixels.to_constant(frame.pixel);
    return out;
}

track::Retry retry_of(const toliman_track_options &options, const track::Terms &terms) {
    if (options.limits.misfit == nullptr)
        return {};
    return [call = options.limits.misfit, data = options.limits.misfit_data,
            terms](const track::Frame &frame, const track::Outcome &outcome, track::Frame &other) {
        const toliman_frame given = public_frame(frame);
        toliman_frame changed = given;
        toliman_track_outcome seen = public_outcome(outcome);
        seen.struct_size = sizeof seen;
        seen.verdict = TOLIMAN_TRACK_VERDICT_MISFIT;
        TOLIMAN_COPY(seen, outcome, value, tai_ns);
        try {
            if (call(&given, &seen, &changed, data) != 1)
                return false;
        } catch (...) {
            return false;
        }
        toliman_frame tried = given; // nothing else may be changed
        TOLIMAN_COPY(tried, changed, pixel, pixels, rows, cols, stride);
        check_frame(tried, 0, terms);
        other = frame_of(tried);
        return true;
    };
}

} // namespace toliman::api
