// Method: every sample is pushed to the exact sums as it arrives, so that saved and continued sums have the same bits
// as all samples at once. A new periodogram takes its references from the first sample and its limits from the options;
// if that sample is refused, the next one becomes the first. While the input is idle, once per second, signals are
// checked and the state is saved if the minute alarm has expired: no thread and no work in a signal handler is needed.
#include "series/period_stream.hpp"

#include <tuple>

#include "common/warnings.hpp"

namespace cli {

namespace {

using toliman::check;

constexpr int64_t kFewest = 5; // samples before the first peak

// False if there is no peak yet.
bool print_update(const toliman::periodogram &periodogram, double t, const std::string &time_scale) {
    auto peak = toliman::sized<toliman_period_peak>();
    const toliman_status status = toliman_period_query_peak(periodogram.get(), &peak);
    if (status == TOLIMAN_E_STATE || status == TOLIMAN_E_RANGE) // too few samples, or nearly equal ones
        return false;
    check(status);
    double sequential = 0;
    check(toliman_period_query_fap(periodogram.get(), TOLIMAN_PERIOD_FAP_SEQUENTIAL, peak.log10_residual, &sequential));
    const std::string period = std::isfinite(peak.period) ? formatted("%.10g", peak.period) : "null"; // at frequency 0
    print_stdout(formatted("{\"schema\":\"toliman-period-update/1\",\"n\":%lld,\"t\":%.17g,\"period\":%s,"
                           "\"frequency\":%.10g,\"power\":%.10g,\"log10_fap\":%.6g,\"log10_fap_sequential\":%.6g,"
                           "\"at_edge\":%s,\"time_scale\":%s}\n",
                           static_cast<long long>(info_of(periodogram).count), t, period.c_str(), peak.frequency,
                           peak.power, peak.log10_fap, sequential,
                           (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0 ? "true" : "false",
                           time_scale.empty() ? "null" : ("\"" + time_scale + "\"").c_str()));
    return true;
}

class Stream {
  public:
    Stream(const PeriodStreamOptions &options, Progress &progress)
        : options_(options), progress_(progress), warnings_(progress) {
        if (!options.from_state.empty()) {
            periodogram_ = load_state(options.from_state);
            check_columns();
        }
        if (options.follow && !options.save_state.empty())
            set_alarm();
    }

    void read() {
        const auto on_idle = [this] {
            stop_if_asked();
            save_if_due();
        };
        SampleReader reader(options_.file, options_.samples, options_.follow ? on_idle : std::function<void()>());
        name_ = reader.name();
        while (step(reader)) {
        }
        progress_.clear();
        for (const std::string &warning : reader.end(static_cast<bool>(periodogram_)))
            progress_.warn(warning);
    }

    // After an error or a signal, whose message follows.
    void save_after_failure() {
        if (!options_.follow)
            return;
        warn_skipped();
        try {
            save();
            if (saved_ >= 0)
                progress_.tell("state saved: " + std::to_string(saved_) + " samples");
        } catch (const std::exception &error) {
            progress_.warn(error.what());
        }
    }

    void finish() {
        save();
        if (!options_.follow)
            return;
        if (!printed_)
            warn_without_output();
        if (skipped_ > 0 && options_.strict)
            throw Failure(kExitRejected, total());
        warn_skipped();
    }

    toliman::periodogram release() { return std::move(periodogram_); }

  private:
    int64_t count() const { return periodogram_ ? info_of(periodogram_).count : 0; }

    // Refuses to mix samples with and without sigma: those without would have the weight of the smallest sigma.
    void check_weights(const Sample &sample, const std::string &where) const {
        const toliman_period_info info = info_of(periodogram_);
        if (info.count > 0 && (info.weighted != 0) != (sample.sigma > 0))
            malformed(where, (sample.sigma > 0 ? "has a sigma: the samples in " : "has no sigma: the samples in ") +
                                 options_.from_state + (sample.sigma > 0 ? " have none" : " have one"));
    }

    // Options of a new periodogram, by the first sample.
    toliman_period_options options_by(const Sample &sample, const SampleReader &reader) const {
        toliman_period_options options =
            options_for(&sample.t, &sample.y, sample.sigma > 0 ? &sample.sigma : nullptr, 1, options_.sums);
        options.trend = options_.nuisance.trend.value_or(0);
        std::tie(options.trend_start, options.trend_end) = span_of(options.trend, options_.nuisance, options_.samples,
                                                                   reader.info().time_format, reader.info().time_scale);
        return options;
    }

    // Values of columns come with each sample, but not in a series.
    void check_columns() const {
        const toliman_period_info info = info_of(periodogram_);
        if (info.columns > 0 && !options_.file.empty())
            malformed(options_.from_state, formatted("has %d columns of nuisance functions, whose values later samples "
                                                     "would lack: no samples can be added",
                                                     info.columns));
    }

    // The first sample gives the references of a new periodogram.
    void push(const Sample &sample, const SampleReader &reader) {
        if (!periodogram_)
            periodogram_ = make_periodogram(*options_.grid, options_by(sample, reader));
        if (sigma_floor_ == 0) {
            check_weights(sample, reader.where());
            sigma_floor_ = info_of(periodogram_).sigma_floor;
        }
        const double sigma = sample.sigma > 0 ? sample.sigma : sigma_floor_;
        if (toliman_period_push(periodogram_.get(), sample.t, sample.y, sigma) == TOLIMAN_OK)
            return;
        const BadLine bad(reader.where() + ": " +
                          refusal(periodogram_, sample.t, sample.y, sigma, !options_.from_state.empty()));
        if (count() == 0 && options_.from_state.empty()) { // the next sample gives the references
            periodogram_.reset();
            sigma_floor_ = 0;
        }
        throw bad;
    }

    void report(double t, const std::string &time_scale) {
        if (count() >= kFewest && print_update(periodogram_, t, time_scale))
            printed_ = true;
        warn_of_grid(periodogram_, nullptr, false, 0, warned_, progress_);
    }

    // False at the end of the input.
    bool step(SampleReader &reader) {
        Sample sample = {};
        try {
            if (!reader.next(sample))
                return false;
            push(sample, reader);
        } catch (const BadLine &bad) {
            if (!options_.follow)
                throw;
            skipped_++;
            warnings_.warn("skipped", std::string(bad.what()) + ": skipped", kMostInputs);
            return true;
        }
        for (const std::string &warning : reader.take_warnings())
            progress_.warn(warning);
        if (options_.follow)
            report(sample.t, reader.time_scale());
        return true;
    }

    void save() {
        if (options_.save_state.empty() || !periodogram_)
            return;
        save_state(periodogram_, options_.save_state);
        saved_ = count();
    }

    // A failure is only a warning: a disk that is full now may have space a minute later.
    void save_if_due() {
        if (!alarm_expired() || count() == saved_)
            return;
        try {
            save();
        } catch (const Failure &failure) {
            progress_.warn(failure.what());
        }
    }

    // States why no update was printed.
    void warn_without_output() {
        auto peak = toliman::sized<toliman_period_peak>();
        const bool peaks = toliman_period_query_peak(periodogram_.get(), &peak) == TOLIMAN_OK;
        progress_.warn(std::string("no update was printed: ") +
                       (peaks ? "there were no samples" : toliman_last_error()));
    }

    std::string total() const {
        return name_ + ": " + std::to_string(skipped_) + (skipped_ == 1 ? " line" : " lines") + " skipped";
    }

    void warn_skipped() {
        if (skipped_ > 0)
            progress_.warn(total());
    }

    const PeriodStreamOptions &options_;
    Progress &progress_;
    Warnings warnings_;                // of lines
    toliman::periodogram periodogram_; // empty before the first sample
    double sigma_floor_ = 0;           // sigma of samples without one; 0 before the first sample
    std::string name_;                 // of the input
    int64_t skipped_ = 0, saved_ = -1; // lines; samples
    bool printed_ = false;             // at least one update
    uint32_t warned_ = 0;              // flags of the grid that were reported
};

} // namespace

toliman::periodogram stream_samples(const PeriodStreamOptions &options, Progress &progress) {
    Stream stream(options, progress);
    try {
        if (!options.file.empty())
            stream.read();
    } catch (...) {
        stream.save_after_failure();
        throw;
    }
    stream.finish();
    return stream.release();
}

} // namespace cli
