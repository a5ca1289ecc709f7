// include/toliman/coadd.h
#include <toliman/coadd.h>

#include "api/common.hpp"
#include "api/fit_values.hpp"
#include "api/handles.hpp"
#include "api/pixel_frames.hpp"
#include "api/spread.hpp"
#include "base/name.hpp"
#include "base/workers.hpp"
#include "coadd/coadd.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

constexpr double kNs = 1e9;
constexpr double kLongestShortExposure = 1e6; // s
constexpr size_t kMostPixels = size_t{1} << 22;
constexpr Choice<coadd::Verdict> kVerdicts = {TOLIMAN_COADD_VERDICT_ADDED, TOLIMAN_COADD_VERDICT_MISFIT,
                                              "TOLIMAN_COADD_VERDICT_..."};
constexpr Choice<coadd::End> kEnds = {TOLIMAN_COADD_REASON_NONE, TOLIMAN_COADD_REASON_SOURCE,
                                      "TOLIMAN_COADD_REASON_..."};

int64_t nanoseconds(double seconds) noexcept {
    return std::llround(seconds * kNs);
}

coadd::Limits limits_of(const toliman_coadd_options &options) {
    coadd::Limits limits;
    limits.range = static_cast<int>(options.range_px);
    limits.most_chi_square = options.chi_square_max;
    limits.duration_ns = nanoseconds(options.duration_s);
    limits.aligned = (options.flags & TOLIMAN_COADD_ALIGNED) != 0;
    if (limits.aligned && limits.duration_ns == 0)
        fail(Status::argument, "{options->duration_s} = %g: must be above 0 with TOLIMAN_COADD_ALIGNED",
             options.duration_s);
    limits.gap_ns = nanoseconds(options.gap_s);
    limits.motion_px = options.motion_px;
    limits.pause_ns = nanoseconds(options.pause_s);
    return limits;
}

void check_size(const fit::Windows &fit, int range) {
    if (!fit.first().model().readout().is_linear())
        fail(Status::unsupported,
             "{fit}: the scene has detector.nonlinearity_per_e or brighter_fatter_px2_per_e, which a "
             "sum of frames whose stars move does not keep: fit its frames one by one");
    if (fit.rows() * fit.cols() > kMostPixels)
        fail(Status::unsupported, "{fit}: frames of %zux%zu pixels: at most %zu pixels", fit.rows(), fit.cols(),
             kMostPixels);
    const double most =
        std::min({fit.capture_px(), 0.5 * static_cast<double>(fit.rows()), 0.5 * static_cast<double>(fit.cols())});
    if (range + 1 > most)
        fail(Status::argument,
             "{options->range_px} = %d: must be at most %g px: 1 px below capture_px of the fit and half "
             "a side of the frame",
             range, most - 1);
}

// Pixels as 16-bit integers, in place if they are.
template <class T> const uint16_t *narrowed(const T *pixels, size_t rows, size_t cols, size_t stride, uint16_t *out) {
    for (size_t r = 0; r < rows; r++)
        for (size_t c = 0; c < cols; c++) {
            const auto value = static_cast<ValueOf<T>>(pixels[r * stride + c]);
            out[r * cols + c] = value < UINT16_MAX ? static_cast<uint16_t>(value) : uint16_t{UINT16_MAX};
        }
    return out;
}

} // namespace

struct toliman_coadd : Handle<toliman_coadd> {
    toliman_coadd(std::shared_ptr<const fit::Fit> fit, const fit::Prediction &prediction, const coadd::Limits &limits,
                  unsigned workers, const Progress &progress)
        : model(*fit), shift{prediction.shift_px[0], prediction.shift_px[1]},
          coadd(std::move(fit), prediction, limits, workers, progress), pixels(coadd.rows() * coadd.cols()) {}

    static constexpr char kType[] = "toliman_coadd";
    const fit::Fit &model; // which `coadd` owns
    double shift[2];       // of the prediction
    coadd::Coadd coadd;
    Buffer<uint16_t> pixels; // of a frame of another type
    coadd::Registered registered = {};
    toliman_spread spread = {};
    double intervals[coadd::kMostIntervals][2] = {}; // of the sum that was taken
};

namespace {

const char *required_name(const char *name, const char *member) {
    const std::string place = std::string("frame->") + member;
    required(name, place.c_str());
    if (!is_name(name))
        fail(Status::argument, "{%s} = \"%s\": must be 1 to 64 characters A-Z a-z 0-9 . _ -, not starting with a dot",
             place.c_str(), name);
    return name;
}

void check_members(const toliman_frame &given, size_t rows, size_t cols) {
    const auto refuse = [](const char *name, int64_t value, const char *allowed) {
        fail(Status::argument, "{frame->%s} = %lld: must be %s", name, static_cast<long long>(value), allowed);
    };
    required(given.pixels, "frame->pixels");
    if (given.rows != static_cast<int64_t>(rows))
        refuse("rows", given.rows, (std::to_string(rows) + ", those of the fit").c_str());
    if (given.cols != static_cast<int64_t>(cols))
        refuse("cols", given.cols, (std::to_string(cols) + ", those of the fit").c_str());
    if (given.stride != 0 && (given.stride < given.cols || given.stride > INT32_MAX))
        refuse("stride", given.stride, "0 or in [cols, 2^31 - 1]");
    if (given.dropped < 0)
        refuse("dropped", given.dropped, "at least 0");
    if (!(given.exposure_s >= 0 && given.exposure_s <= kLongestShortExposure))
        fail(Status::argument, "{frame->exposure_s} = %g: must be in [0, %g]", given.exposure_s, kLongestShortExposure);
    constexpr int64_t kFarthest = int64_t{1} << 62;
    if (given.camera_ns < -kFarthest || given.camera_ns > kFarthest)
        refuse("camera_ns", given.camera_ns, "in [-2^62, 2^62]");
    if (given.spread != nullptr)
        fail(Status::argument, "{frame->spread}: must be NULL: sums cannot be added");
    if (given.interval_count != 0)
        fail(Status::argument, "{frame->interval_count} = %zu: must be 0: the exposure of a frame is one interval",
             given.interval_count);
}

const uint16_t *pixels_of(const toliman_frame &given, size_t stride, toliman_coadd &object) {
    const size_t rows = object.coadd.rows(), cols = object.coadd.cols();
    const Pixel pixel = kPixels.to_enum(given.pixel, "frame->pixel");
    if (reinterpret_cast<uintptr_t>(given.pixels) % size_of(pixel) != 0)
        fail(Status::argument, "{frame->pixels}: must be aligned to %zu bytes, the size of a pixel", size_of(pixel));
    uint16_t *const out = object.pixels.data();
    switch (pixel) {
    case Pixel::u16:
        return static_cast<const uint16_t *>(given.pixels);
    case Pixel::u8:
        return narrowed(static_cast<const uint8_t *>(given.pixels), rows, cols, stride, out);
    case Pixel::u32:
        return narrowed(static_cast<const uint32_t *>(given.pixels), rows, cols, stride, out);
    case Pixel::u16be:
        return narrowed(static_cast<const BigEndian<uint16_t> *>(given.pixels), rows, cols, stride, out);
    case Pixel::u32be:
        return narrowed(static_cast<const BigEndian<uint32_t> *>(given.pixels), rows, cols, stride, out);
    default:
        fail(Status::argument, "{frame->pixel} = %d: must be one of TOLIMAN_PIXEL_U8, U16, U32, U16BE, U32BE",
             given.pixel);
    }
}

coadd::Frame short_frame_of(const toliman_frame *frame, toliman_coadd &object) {
    const toliman_frame given = copied(&required(frame, "frame"), "frame");
    check_members(given, object.coadd.rows(), object.coadd.cols());
    const DetectorWindow window = {given.window_row, given.window_col};
    if (!(window == DetectorWindow()) &&
        (object.model.known_bad().move_with(window) || object.model.scene().detector.response_moves_with(window)))
        fail(Status::unsupported,
             "{frame->window_row} = %lld, window_col = %lld: must be detector.window of the scene, which has bad "
             "pixels or detector.response",
             static_cast<long long>(window.row), static_cast<long long>(window.col));
    coadd::Frame out = {};
    out.session = required_name(given.session, "session");
    out.roi = required_name(given.roi, "roi");
    const auto stride = static_cast<size_t>(given.stride != 0 ? given.stride : given.cols);
    const uint16_t *const pixels = pixels_of(given, stride, object);
    out.pixels = {pixels, pixels == object.pixels.data() ? object.coadd.cols() : stride, object.coadd.rows(),
                  object.coadd.cols()};
    out.middle_ns = given.camera_ns;
    out.exposure_ns = nanoseconds(given.exposure_s);
    TOLIMAN_COPY(out, given, dropped, window_row, window_col);
    return out;
}

toliman_coadd_outcome coadd_outcome(const toliman_coadd &object, coadd::End end) {
    const coadd::Registered &found = object.registered;
    toliman_coadd_outcome out = {};
    out.verdict = kVerdicts.to_constant(found.verdict);
    out.reason = kEnds.to_constant(end);
    if (found.verdict != coadd::Verdict::added && found.verdict != coadd::Verdict::misfit)
        return out;
    TOLIMAN_COPY(out, found, left_out, saturated, flux, chi_square);
    out.x_px = object.shift[0] + found.x;
    out.y_px = object.shift[1] + found.y;
    out.x_sigma_px = std::sqrt(found.xx);
    out.y_sigma_px = std::sqrt(found.yy);
    return out;
}

toliman_coadd_sum public_sum(const coadd::Coadd::Taken &taken, const double *shift) {
    const coadd::Totals &totals = taken.totals;
    const auto verdicts = [&](coadd::Verdict verdict) { return totals.verdicts[static_cast<size_t>(verdict)]; };
    toliman_coadd_sum out = {};
    TOLIMAN_COPY(out, totals, frames, cosmic_rays, saturated);
    out.lost = verdicts(coadd::Verdict::lost);
    out.faint = verdicts(coadd::Verdict::faint);
    out.not_found = verdicts(coadd::Verdict::not_found);
    out.outside = verdicts(coadd::Verdict::outside);
    out.misfit = verdicts(coadd::Verdict::misfit);
    out.filled_pixels = std::count_if(taken.left_out.begin(), taken.left_out.end(),
                                      [&](uint32_t frames) { return 2 * int64_t{frames} > totals.frames; });
    out.first_ns = totals.intervals.first();
    out.last_ns = totals.intervals.last();
    out.mean_ns = coadd::mean_ns(totals);
    out.photons = static_cast<double>(totals.photons);
    out.flux = static_cast<double>(totals.flux.over(totals.frames));
    double place[2];
    totals.moments.mean(totals.photons, place);
    out.x_px = shift[0] + place[0];
    out.y_px = shift[1] + place[1];
    out.registration_xx_px2 = totals.moments.registered(0, totals.photons);
    out.registration_xy_px2 = totals.moments.registered(1, totals.photons);
    out.registration_yy_px2 = totals.moments.registered(2, totals.photons);
    out.chi_square = static_cast<double>(totals.chi_square.over(totals.frames));
    out.left_out = taken.left_out.data();
    return out;
}

toliman_frame public_sum_frame(toliman_coadd &object) {
    const coadd::Coadd::Taken &taken = object.coadd.taken();
    const coadd::Totals &totals = taken.totals;
    Spread spread = totals.moments.spread(totals.photons);
    spread.frames = static_cast<double>(totals.frames);
    object.spread = public_spread(spread);
    toliman_frame out = {};
    out.pixel = TOLIMAN_PIXEL_U32;
    out.session = totals.session;
    out.roi = totals.roi;
    out.dropped = totals.dropped;
    out.frame_id = taken.number;
    out.camera_ns = coadd::mean_ns(totals);
    out.pixels = taken.counts.data();
    out.rows = static_cast<int64_t>(object.coadd.rows());
    out.cols = out.stride = static_cast<int64_t>(object.coadd.cols());
    const int64_t half = std::max(out.camera_ns - totals.intervals.first(), totals.intervals.last() - out.camera_ns);
    out.exposure_s = 2 * static_cast<double>(half) / kNs;
    out.interval_count = totals.intervals.count();
    const auto seconds = [&](int64_t ns) { return static_cast<double>(ns - (out.camera_ns - half)) / kNs; };
    for (size_t i = 0; i < out.interval_count; i++) {
        object.intervals[i][0] = std::max(0.0, seconds(totals.intervals[i].start));
        object.intervals[i][1] = std::min(out.exposure_s, seconds(totals.intervals[i].end));
    }
    out.intervals = object.intervals[0];
    if (!(out.exposure_s > 0)) { // frames of unknown exposure
        out.intervals = nullptr;
        out.interval_count = 0;
    }
    TOLIMAN_COPY(out, totals, window_row, window_col);
    out.spread = &object.spread;
    return out;
}

int64_t rejected(const coadd::Totals &totals) noexcept {
    int64_t frames = -totals.frames;
    for (const int64_t verdict : totals.verdicts)
        frames += verdict;
    return frames;
}

} // namespace

toliman_status toliman_coadd_create(const toliman_fit *handle, const toliman_fit_prediction *prediction,
                                    const toliman_coadd_options *options, toliman_coadd **out) noexcept {
    return call(handle, "fit", [&](auto &self) {
        const toliman_coadd_options known = accept(options, "options");
        const MemoryScope scope(memory_of(known.allocator));
        const coadd::Limits limits = limits_of(known);
        check_size(self.fit, limits.range);
        const fit::Prediction place = prediction_of(prediction);
        if (place.spread.any())
            fail(Status::argument, "{prediction->spread}: must be NULL: the frames are not sums");
        toliman_coadd *&made = required(out, "out");
        made = new toliman_coadd(self.fit.at(place), place, limits, worker_count(known.threads),
                                 {known.progress, known.progress_data});
    });
}

void toliman_coadd_destroy(toliman_coadd *coadd) noexcept {
    destroy(coadd);
}

toliman_status toliman_coadd_add(toliman_coadd *coadd, const toliman_frame *frame,
                                 toliman_coadd_outcome *outcome) noexcept {
    return call(coadd, "coadd", [&](toliman_coadd &object) {
        check_struct_size("outcome", required(outcome, "outcome"));
        const coadd::Frame given = short_frame_of(frame, object);
        coadd::End end = coadd::End::none;
        object.coadd.add(given, object.registered, end);
        deliver(coadd_outcome(object, end), outcome, "outcome");
    });
}

toliman_status toliman_coadd_take(toliman_coadd *coadd, toliman_frame *frame, toliman_coadd_sum *sum) noexcept {
    return call(coadd, "coadd", [&](toliman_coadd &object) {
        check_struct_size("frame", required(frame, "frame"));
        check_struct_size("sum", required(sum, "sum"));
        if (object.coadd.totals().frames == 0)
            fail(Status::state, "{coadd}: no frame was added to the sum");
        object.coadd.take();
        deliver(public_sum_frame(object), frame, "frame");
        deliver(public_sum(object.coadd.taken(), object.shift), sum, "sum");
    });
}

toliman_status toliman_coadd_get_info(const toliman_coadd *coadd, toliman_coadd_info *out) noexcept {
    return call(coadd, "coadd", [&](const toliman_coadd &object) {
        const coadd::Coadd &adder = object.coadd;
        const coadd::Totals &totals = adder.totals();
        toliman_coadd_info info = {};
        info.range_px = static_cast<uint32_t>(adder.limits().range);
        info.rows = static_cast<int64_t>(adder.rows());
        info.cols = static_cast<int64_t>(adder.cols());
        info.frames = totals.frames;
        info.rejected = rejected(totals);
        info.number = adder.number();
        if (totals.frames > 0) {
            info.first_ns = totals.intervals.first();
            info.last_ns = totals.intervals.last();
        }
        info.photons = adder.photons_per_frame();
        info.bytes = adder.bytes();
        info.digest = adder.digest();
        deliver(info, out, "out");
    });
}

toliman_status toliman_coadd_save(const toliman_coadd *coadd, void *bytes, size_t capacity, size_t *needed) noexcept {
    return call(coadd, "coadd", [&](const toliman_coadd &object) {
        if (capacity < object.coadd.saved_size()) // known without saving
            check_bytes(object.coadd.saved_size(), bytes, capacity, needed);
        deliver_bytes(object.coadd.save(), bytes, capacity, needed);
    });
}

toliman_status toliman_coadd_load(toliman_coadd *coadd, const void *bytes, size_t size) noexcept {
    return call(coadd, "coadd", [&](toliman_coadd &object) {
        required_array(bytes, size, 1, "bytes");
        object.coadd.load(bytes, size);
    });
}
