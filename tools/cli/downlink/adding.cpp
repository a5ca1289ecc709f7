#include "downlink/adding.hpp"

#include "frames/frames_in.hpp"

namespace cli {

namespace {

using toliman::check;

constexpr double kMostVariance = 4; // px^2, of toliman_spread
constexpr int kWork = 20;           // time of work for each time of saving

std::string verdict_text(const toliman_coadd_outcome &outcome) {
    switch (outcome.verdict) {
    case TOLIMAN_COADD_VERDICT_LOST:
        return "lost: rows of zeros, a part of the frame is missing";
    case TOLIMAN_COADD_VERDICT_FAINT:
        return "faint: less than a fifth of the light of the scene, or over 5 times as much: see cadence.exposure_s";
    case TOLIMAN_COADD_VERDICT_OUTSIDE:
        return "outside: the stars are beyond --range from their predicted places: see --shift";
    case TOLIMAN_COADD_VERDICT_MISFIT:
        return formatted("misfit: chi-square %.4g: damaged, or not a frame of the scene", outcome.chi_square);
    default:
        return "not found: the stars are not in the frame as the scene has them";
    }
}

} // namespace

Adding::Adding(toliman::frame_adder &&adder, SumFiles &files, const toliman_track_options &settings, Progress &progress)
    : adder_(std::move(adder)), files_(files), settings_(settings), progress_(progress), warnings_(progress),
      saved_(std::chrono::steady_clock::now()) {
    if (files_.resumes())
        check(toliman_coadd_load(adder_.get(), files_.saved().data(), files_.saved().size()));
}

void Adding::take(const std::shared_ptr<FrameSource> &, const toliman_frame &frame, const toliman_ingest_event &event) {
    const std::string place = place_of(event);
    if (event.event != TOLIMAN_INGEST_EVENT_FRAME && event.event != TOLIMAN_INGEST_EVENT_DAMAGE)
        return report(Severity::warning, toliman_constant_name(event.reason), place, event.text);
    check_region(frame.roi, place);
    if (event.event == TOLIMAN_INGEST_EVENT_DAMAGE) {
        report(Severity::damage, toliman_constant_name(event.reason), place, event.text);
    } else if (const FrameKey key(frame, event); files_.frames().contains(key)) {
        known_++;
    } else {
        add(frame, event);
        files_.frames().insert(key);
    }
    if (std::chrono::steady_clock::now() - saved_ > patience_)
        save();
}

// roi: NULL if it is unknown.
void Adding::check_region(const char *roi, const std::string &place) {
    if (roi == nullptr || roi == region_)
        return;
    if (!region_.empty())
        throw Failure(kExitUsage, place + ": region " + roi + ": the frames before it are of " + region_ +
                                      ": --roi LABEL takes those of one region");
    region_ = roi;
}

// The pixels of a .npy or FITS file as counts; false, with a report, if they are none.
bool Adding::to_counts(toliman_frame &frame, const std::string &place) {
    const auto *const pixels = static_cast<const double *>(frame.pixels);
    counts_.resize(static_cast<size_t>(frame.rows * frame.cols));
    for (size_t i = 0; i < counts_.size(); i++) {
        if (!(pixels[i] >= 0 && pixels[i] <= UINT16_MAX && pixels[i] == std::floor(pixels[i]))) {
            report(Severity::damage, "no counts", place,
                   formatted("row %zu, column %zu: %g: must be a whole number from 0 to 65535",
                             i / static_cast<size_t>(frame.cols), i % static_cast<size_t>(frame.cols), pixels[i]));
            return false;
        }
        counts_[i] = static_cast<uint16_t>(pixels[i]);
    }
    frame.pixel = TOLIMAN_PIXEL_U16;
    frame.pixels = counts_.data();
    return true;
}

// A sum is of one session: files without lines, whose session is their name, share one.
void Adding::add(toliman_frame frame, const toliman_ingest_event &event) {
    const std::string place = place_of(event);
    if (is_dated_file(event.file))
        frame.session = "files";
    if (frame.pixel == TOLIMAN_PIXEL_F64 && !to_counts(frame, place))
        return;
    auto outcome = toliman::sized<toliman_coadd_outcome>();
    const toliman_status status = toliman_coadd_add(adder_.get(), &frame, &outcome);
    if (status == TOLIMAN_E_ARGUMENT || status == TOLIMAN_E_UNSUPPORTED)
        return report(Severity::damage, "unsuitable", place, toliman_last_error());
    check(status);
    if (outcome.verdict == TOLIMAN_COADD_VERDICT_NEXT) {
        end_sum(toliman_constant_name(outcome.reason));
        check(toliman_coadd_add(adder_.get(), &frame, &outcome));
    }
    verdicts_[outcome.verdict]++;
    if (outcome.verdict == TOLIMAN_COADD_VERDICT_ADDED)
        return;
    damaged_++;
    warnings_.warn(toliman_constant_name(outcome.verdict), place + ": " + verdict_text(outcome));
}

// The state has the inputs up to the frame before the one that begins the next sum. There is one before the first sum
// is in the pair, as a pair without state is refused.
void Adding::end_sum(const char *reason) {
    if (!files_.has_state())
        save();
    auto frame = toliman::sized<toliman_frame>();
    auto sum = toliman::sized<toliman_coadd_sum>();
    check(toliman_coadd_take(adder_.get(), &frame, &sum));
    is_written_ = false;
    files_.append(frame, sum);
    is_written_ = true;
    save();
    sums_++;
    const toliman_spread &spread = *frame.spread;
    if (std::max(spread.xx_px2, spread.yy_px2) > kMostVariance)
        warnings_.warn("spread",
                       formatted("sum %lld: the stars moved by %.2g px rms: track takes up to 2 px: give --motion 1",
                                 static_cast<long long>(frame.frame_id),
                                 std::sqrt(std::max(spread.xx_px2, spread.yy_px2))));
    print_stdout(Json("schema", "toliman-coadd/1", "number", frame.frame_id, "reason", reason, "camera_ns",
                      frame.camera_ns, "first_ns", sum.first_ns, "last_ns", sum.last_ns, "frames", sum.frames, "lost",
                      sum.lost, "faint", sum.faint, "not_found", sum.not_found, "outside", sum.outside, "misfit",
                      sum.misfit, "cosmic_rays", sum.cosmic_rays, "saturated", sum.saturated, "filled_pixels",
                      sum.filled_pixels, "flux", sum.flux, "x_px", sum.x_px, "y_px", sum.y_px, "jitter_px2",
                      std::vector<double>{spread.xx_px2, spread.yy_px2, spread.xy_px2}, "chi_square", sum.chi_square)
                     .line());
    progress_.note("coadd", formatted("%lld sums", static_cast<long long>(files_.sums())));
}

void Adding::report(Severity severity, const std::string &warning, const std::string &input, const std::string &text) {
    if (severity == Severity::note)
        return warnings_.tell(warning, input + ": " + text);
    damaged_ += severity == Severity::damage ? 1 : 0;
    warnings_.warn(warning, input + ": " + text);
}

void Adding::wait() {
    if (std::chrono::steady_clock::now() - saved_ > patience_)
        save();
}

void Adding::finish() {
    const auto info = toliman::result<toliman_coadd_info>(toliman_coadd_get_info, adder_.get());
    if (info.frames > 0)
        end_sum("end");
    else
        save();
}

// The frames of a sum that could not be written stay unknown to the state.
void Adding::save() {
    if (!is_written_)
        return;
    const auto start = std::chrono::steady_clock::now();
    size_t size = 0;
    toliman::check_asked(toliman_coadd_save(adder_.get(), nullptr, 0, &size));
    std::vector<uint8_t> bytes(size);
    check(toliman_coadd_save(adder_.get(), bytes.data(), bytes.size(), &size));
    files_.save(bytes);
    saved_ = std::chrono::steady_clock::now();
    patience_ = std::max<std::chrono::steady_clock::duration>(kPatience, kWork * (saved_ - start));
}

void Adding::end() {
    warnings_.end([](const std::string &name, int64_t count, int64_t most) {
        return formatted("%lld more: %s", static_cast<long long>(count - most), name.c_str());
    });
    if (known_ > 0)
        progress_.tell(formatted("%lld frames were known, and are not added again", static_cast<long long>(known_)));
    int64_t frames = 0;
    for (const auto &[verdict, count] : verdicts_)
        frames += count;
    progress_.close("coadd", formatted("%lld of %lld frames added to %lld sums, %lld were known",
                                       static_cast<long long>(verdicts_[TOLIMAN_COADD_VERDICT_ADDED]),
                                       static_cast<long long>(frames), static_cast<long long>(sums_),
                                       static_cast<long long>(known_)));
}

} // namespace cli
