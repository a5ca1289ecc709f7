// Method: the time of a frame, in TAI, is that of its encoder. It is the middle of the exposure, whose length and
// on-target intervals are those of the scene's cadence.
#include "frames/reducing_encoder.hpp"

#include <cmath>
#include <utility>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "options/command.hpp"
#include "scenes/leap_seconds.hpp"
#include "scenes/scene_json.hpp"
#include "scenes/sky_times.hpp"

namespace cli {

namespace {

struct Interval {
    int64_t start_ns, end_ns; // from the middle of the exposure
};

// Modified Julian Day of a time in ns since 1970; whole days are exact.
double mjd_of(int64_t ns) {
    constexpr int64_t kDay = 86400000000000, kMjdOf1970 = 40587;
    const int64_t days = ns / kDay;
    return static_cast<double>(kMjdOf1970 + days) + static_cast<double>(ns - days * kDay) / static_cast<double>(kDay);
}

int64_t ns_of(double seconds) {
    return std::llround(seconds * 1e9);
}

// Of the scene's cadence; a whole exposure if it has no on_target_s, an instant if it has no exposure_s.
std::vector<Interval> intervals_of(const cJSON *on_target, double exposure_s) {
    const int64_t length = ns_of(exposure_s), start = -(length / 2);
    if (on_target == nullptr)
        return {{start, start + length}};
    std::vector<Interval> intervals;
    for (const cJSON *item = on_target->child; item != nullptr && item->next != nullptr; item = item->next->next)
        intervals.push_back({start + ns_of(item->valuedouble), start + ns_of(item->next->valuedouble)});
    return intervals;
}

class ReducingEncoder final : public Encoder {
  public:
    ReducingEncoder(std::unique_ptr<Encoder> encoder, const FrameReductionOptions &options, const Estimator &estimator,
                    Progress &progress)
        : encoder_(std::move(encoder)), options_(options), scene_(estimator.fit_scene),
          plate_scale_(plate_scale_of(options.plate_scale, estimator.pixel_scale_arcsec)),
          sky_(options.observer.predictor(*options.system, 0, progress)),
          columns_(std::string(encoder_->columns()) + ",mjd,factor,geometric_arcsec,reduced_px"),
          exposure_s_(estimator.exposure_s) {
        const JsonTree tree = read_scene_json(scene_);
        const cJSON *const on_target = item_of(item_of(tree.get(), "cadence"), "on_target_s");
        on_target_ = on_target != nullptr;
        intervals_ = intervals_of(on_target, exposure_s_);
    }

    const char *columns() const override { return columns_.c_str(); }
    void open(FrameFile &frames) override { encoder_->open(frames); }

    toliman_status encode(const toliman_image &image, size_t first, size_t count) override {
        const toliman_status status = encoder_->encode(image, first, count);
        if (status == TOLIMAN_OK)
            reduce(count);
        return status;
    }

    std::string line(size_t i) const override {
        const toliman_sky_prediction &seen = seen_[i];
        std::string columns = encoder_->line(i) + formatted(",%.17g", mjd_of(times_[i]));
        for (const double number : {seen.factor, seen.geometric_arcsec, reduced_[i] / plate_scale_})
            columns += std::isnan(number) ? ",nan" : formatted(",%.17g", number);
        return columns;
    }

    std::vector<Doubt> doubts(size_t i) const override { return encoder_->doubts(i); }
    Separation separation(size_t i) const override { return encoder_->separation(i); }

    void end(Progress &progress) const override {
        encoder_->end(progress);
        if (unreduced_ > 0)
            progress.warn(formatted("%zu of %zu frames are not reduced, as the observer is not known for their times: ",
                                    unreduced_, frames_) +
                          options_.observer.coverage(sky_.get()));
    }

  private:
    int64_t time_of(const Separation &measured) const {
        if (!measured.tai_ns)
            malformed(scene_, formatted("a frame at %g days: must be within 100,000 days of time 0, and within 64 bits "
                                        "of TAI in ns",
                                        measured.time_days));
        return *measured.tai_ns;
    }

    // The library refuses the exposure of all frames, which is that of the scene.
    void check(toliman_status status) const {
        const toliman::error error(status);
        if (status == TOLIMAN_E_ARGUMENT && error.field() == "intervals")
            malformed(scene_, formatted("cadence.exposure_s = %g: ", exposure_s_) + kOrbitExposure +
                                  ", or with cadence.on_target_s");
        throw error;
    }

    void reduce(size_t count) {
        std::vector<int64_t> intervals;
        std::vector<double> separations;
        times_.clear();
        for (size_t i = 0; i < count; i++) {
            const Separation measured = encoder_->separation(i);
            const int64_t middle = times_.emplace_back(time_of(measured));
            for (const Interval &interval : intervals_)
                intervals.insert(intervals.end(), {moved(middle, interval.start_ns), moved(middle, interval.end_ns)});
            separations.push_back(measured.px * plate_scale_);
        }
        const std::vector<size_t> counts(count, intervals_.size());
        reduced_.resize(count);
        seen_.assign(count, toliman::sized<toliman_sky_prediction>());
        size_t unreduced = 0;
        const toliman_status status =
            toliman_sky_reduce(sky_.get(), intervals.data(), on_target_ ? counts.data() : nullptr, separations.data(),
                               count, reduced_.data(), seen_.data(), &unreduced);
        if (status != TOLIMAN_OK)
            check(status);
        unreduced_ += unreduced;
        frames_ += count;
    }

    int64_t moved(int64_t middle, int64_t offset) const {
        int64_t time = 0;
        if (__builtin_add_overflow(middle, offset, &time))
            malformed(scene_, formatted("a frame at %lld ns of TAI: its exposure must be within 64 bits",
                                        static_cast<long long>(middle)));
        return time;
    }

    std::unique_ptr<Encoder> encoder_;
    const FrameReductionOptions &options_;
    std::string scene_;
    double plate_scale_; // arcsec per px
    toliman::sky_predictor sky_;
    std::string columns_;
    double exposure_s_;
    bool on_target_;                  // intervals_ are those of cadence.on_target_s
    std::vector<Interval> intervals_; // of one exposure
    std::vector<int64_t> times_;      // TAI, of the last call
    std::vector<double> reduced_;     // arcsec, of the last call
    std::vector<toliman_sky_prediction> seen_;
    size_t frames_ = 0, unreduced_ = 0;
};

} // namespace

void FrameReductionOptions::add_to(CLI::App &command) {
    CLI::Option *const chosen =
        add_option(&command, "--system", system, "SYSTEM",
                   "with --fit: reduce separations to the orbit of this binary: alpha-cen, or a system file");
    observer.add_to(command);
    add_option(&command, "--plate-scale", plate_scale, "ARCSEC_PER_PX",
               "with --system: size of a pixel, default that of the scene");
    add_option(&command, "--epoch", epoch, "TIME",
               "with --system: time 0 of a scene without binary.observer, a date of UTC or TAI in ns");
    chosen->needs(command.get_option("--fit"));
    for (const char *name : {"--observer", "--altitude", "--leap-seconds", "--plate-scale", "--epoch"})
        command.get_option(name)->needs(chosen);
}

int64_t time_zero_of(const FrameReductionOptions &options, const Estimator &estimator) {
    if (options.epoch && estimator.time_zero_ns != 0)
        throw Failure(kExitUsage, "--epoch " + *options.epoch + ": the scene has a date, that of binary.observer");
    if (options.epoch)
        return read_epoch("--epoch", *options.epoch, LeapSeconds(options.observer.leap_seconds()).rows);
    if (estimator.time_zero_ns == 0)
        throw Failure(kExitUsage, estimator.fit_scene +
                                      ": has no binary.observer, so the date of its time 0 is not exact: "
                                      "give it by --epoch");
    return estimator.time_zero_ns;
}

std::unique_ptr<Encoder> make_reducing_encoder(std::unique_ptr<Encoder> encoder, const FrameReductionOptions &options,
                                               const Estimator &estimator, Progress &progress) {
    return std::make_unique<ReducingEncoder>(std::move(encoder), options, estimator, progress);
}

} // namespace cli
