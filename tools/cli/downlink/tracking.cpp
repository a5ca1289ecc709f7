#include "downlink/tracking.hpp"

#include <unistd.h>

#include "downlink/folder_facts.hpp"
#include "downlink/ledger_report.hpp"

namespace cli {

namespace {

using toliman::check;

constexpr size_t kBatch = 64;         // frames that are estimated together, at most
constexpr int64_t kCheckpoint = 4096; // records of the ledger
constexpr double kFar = 20;           // sigma, beyond the reach of noise

std::string rejection_text(const toliman_track_outcome &outcome, const toliman_track_options &settings) {
    const std::string pixel = "pixel " + std::to_string(outcome.row) + ", " + std::to_string(outcome.col);
    switch (outcome.reason) {
    case TOLIMAN_TRACK_REASON_SHAPE:
        return " " + shape_text(outcome.row, outcome.col) + ", must be " +
               shape_text(settings.frames.rows, settings.frames.cols) +
               ": a new folder takes others by --shape and --crop";
    case TOLIMAN_TRACK_REASON_OVER_RANGE:
        return ", " + pixel + " is " + formatted("%.12g", outcome.pixel) + ", more than --bit-depth allows";
    case TOLIMAN_TRACK_REASON_ZERO_RUN:
        return ", only zeros up to " + pixel;
    case TOLIMAN_TRACK_REASON_NOT_FINITE:
        return " at " + pixel;
    case TOLIMAN_TRACK_REASON_CLOCK:
        return ": no TAI for its time, or outside the span of the periodogram or of its trend; see --clock, --epoch "
               "and --trend";
    default:
        return ": no finite value, as it differs too much from frames of the scene or weights; with --fit, see --epoch";
    }
}

std::string outlier_text(const toliman_track_outcome &outcome, const toliman_track_options &settings) {
    const Apart size = apart(std::fabs(outcome.value), settings.limits.value, 4);
    return std::string("outlier: a value of ") + (outcome.value < 0 ? "-" : "") + size.value + " px, beyond the " +
           size.limit + formatted(" px of --value-limit, chi-square %.4g: not in the periodogram", outcome.chi_square);
}

// The verdict on a frame that is not accepted, and its reason.
std::string verdict_text(const toliman_frame &frame, const toliman_track_outcome &outcome,
                         const toliman_track_options &settings) {
    if (outcome.verdict == TOLIMAN_TRACK_VERDICT_QUARANTINED)
        return "quarantined: frame " + std::to_string(frame.frame_id) + " of session " + frame.session +
               " arrived before with other pixels, time or count of drops; neither copy counts, nor does any later one";
    if (outcome.verdict == TOLIMAN_TRACK_VERDICT_OUTLIER)
        return outlier_text(outcome, settings);
    if (outcome.verdict == TOLIMAN_TRACK_VERDICT_MISFIT)
        return formatted("misfit: a chi-square of %.4g, largest residual %.3g sigma: damaged, or not a frame of the "
                         "scene: not in the periodogram",
                         outcome.chi_square, outcome.largest_residual);
    return std::string("rejected: ") + toliman_constant_name(outcome.reason) + rejection_text(outcome, settings);
}

std::string rejected_as(const std::string &reason) {
    return "rejected: " + reason;
}

// Of warnings that are told once.
std::string kind_of(const toliman_track_outcome &outcome) {
    return outcome.verdict == TOLIMAN_TRACK_VERDICT_REJECTED ? rejected_as(toliman_constant_name(outcome.reason))
                                                             : toliman_constant_name(outcome.verdict);
}

// The rule of the times is told once for each rule, that an input is back for each input.
std::string kind_of(Severity severity, const std::string &warning, const std::string &input, const std::string &text) {
    if (warning == "time")
        return text;
    return severity == Severity::note ? warning + " " + input : warning;
}

bool has_value(const toliman_track_outcome &outcome) noexcept {
    return outcome.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED || outcome.verdict == TOLIMAN_TRACK_VERDICT_UNREDUCED ||
           outcome.verdict == TOLIMAN_TRACK_VERDICT_OUTLIER || outcome.verdict == TOLIMAN_TRACK_VERDICT_MISFIT;
}

std::string unreduced_text(int32_t reason, int64_t frames, const std::string &folder, const std::string &coverage) {
    const bool one = frames == 1;
    const std::string text = std::to_string(frames) + (one ? " frame is" : " frames are") +
                             " recorded, but not reduced and not in the periodogram: ";
    if (reason == TOLIMAN_TRACK_REASON_NO_ORBIT)
        return text + (coverage.empty() ? "the observer has no state then" : coverage) + "; `toliman rebuild " +
               folder + " --observer FILE` adds " + (one ? "it" : "them");
    return text + (one ? "its" : "their") +
           " time on target is not known: give --exposure, and for exposures above 600 s cadence.on_target in the "
           "scene, or --on-target, and a new folder";
}

// A line toliman-frame/2. has_key, has_time: the frame's name and time are known; reason: NULL unless it is rejected or
// unreduced.
std::string frame_line(const toliman_frame &frame, bool has_key, bool has_time, const std::string &place,
                       const char *reason, const toliman_track_outcome &outcome, int64_t shift) {
    const bool known = has_value(outcome);
    return Json("schema", "toliman-frame/2", "session", if_known(has_key, frame.session), "roi",
                if_known(has_key, frame.roi), "restarts", if_known(has_key, frame.restarts), "frame_id",
                if_known(has_key, frame.frame_id), "verdict", toliman_constant_name(outcome.verdict), "reason",
                if_known(reason != nullptr, reason), "camera_ns", if_known(has_time, frame.camera_ns), "input", place,
                "tai_ns", if_known(known, outcome.tai_ns), "value", Exact{known ? outcome.value : NAN}, "chi_square",
                outcome.chi_square, "chi_square_sigma", outcome.chi_square_sigma, "largest_residual",
                outcome.largest_residual, "goodness", if_known(known, toliman_constant_name(outcome.goodness)),
                "bad_pixels", if_known(known, outcome.bad_pixels), "shift_bytes", shift) // null if there is none
        .line();
}

// Whether the clock table was extrapolated for a time. A single pair is a difference of clocks that has no ends.
bool is_outside_clock(const toliman_track_options &settings, int64_t camera_ns) noexcept {
    return settings.clock.count > 1 &&
           (camera_ns < settings.clock.pairs[0] || camera_ns > settings.clock.pairs[2 * settings.clock.count - 2]);
}

// Advice at the end of a run that could not save.
const char *advice_after(const std::exception &error) {
    const auto *failed = dynamic_cast<const toliman::error *>(&error);
    return failed != nullptr && failed->status() == TOLIMAN_E_LOST
               ? "frames printed as accepted may be lost with the ledger: give all frames again"
               : "printed lines are safe on the disk; the same command resumes";
}

} // namespace

Tracking::Tracking(toliman::tracker &&tracker, const TrackingOptions &options, Realigner &realigner, Progress &progress)
    : tracker_(std::move(tracker)), settings_(settings_of(tracker_)), options_(options), realigner_(realigner),
      progress_(progress), warnings_(progress), batch_(options.jobs > 1 ? std::min(kBatch, options.every) : 1),
      records_(info_of(tracker_).records), saved_(records_) {
    for (const toliman_track_stream &stream : streams_of(tracker_))
        if (stream.roi[0] != '\0')
            regions_.insert(stream.roi);
    if (options.renewal)
        bank_.emplace(records_, *options.renewal);
}

void Tracking::set_on_target(OnTarget windows, const std::string &scene) {
    windows.set_clock(settings_, scene);
    on_target_ = std::move(windows);
}

void Tracking::take(const std::shared_ptr<FrameSource> &source, const toliman_frame &given,
                    const toliman_ingest_event &event) {
    const std::string place = place_of(event);
    if (event.event != TOLIMAN_INGEST_EVENT_FRAME)
        reasons_[event.reason]++;
    if (event.event == TOLIMAN_INGEST_EVENT_DAMAGE)
        return reject(given, event.has_key != 0, place, toliman_constant_name(event.reason), event.text);
    if (event.event == TOLIMAN_INGEST_EVENT_WARNING)
        return report(event.reason == TOLIMAN_INGEST_REASON_CLOCK_JUMP ||
                              event.reason == TOLIMAN_INGEST_REASON_EXTRA_BYTES
                          ? Severity::damage
                          : Severity::warning,
                      toliman_constant_name(event.reason), place, event.text);
    if (dynamic_cast<const PairSource *>(source.get()) != nullptr) {
        if (is_other_region(given.roi))
            return reject(given, true, place, "other region",
                          std::string("region ") + given.roi + ": the folder has frames of " + *regions_.begin() +
                              ": --roi takes those of one region, for a folder of its own");
        note_unknown_exposure(place);
    }
    toliman_frame frame = given;
    std::vector<double> intervals;
    if (!set_intervals(frame, intervals))
        return reject(frame, true, place, "off target", on_target_->complaint(frame));
    frames_.push_back(frame);
    origins_.push_back({source, event.offset, place, std::move(intervals)}); // does not move the numbers
    // No update is skipped: a batch ends at the next update at the latest.
    if (frames_.size() >= std::min(batch_, std::max<size_t>(1, options_.every - since_update_))) {
        flush();
        print_acknowledged();
    }
}

// The intervals of --on-target, or else those of the scene, for exposures of its length that state none. False if no
// time on target remains.
bool Tracking::set_intervals(toliman_frame &frame, std::vector<double> &intervals) {
    const std::vector<double> &of_scene = options_.on_target_s;
    if (on_target_) {
        if (!of_scene.empty() && frame.interval_count == 0 && !std::exchange(noted_intervals_, true))
            progress_.tell("--on-target: instead of cadence.on_target_s of the scene");
        return on_target_->limit(frame, intervals);
    }
    const double exposure_s = frame.exposure_s > 0 ? frame.exposure_s : settings_.frames.exposure_s;
    if (of_scene.empty() || frame.interval_count > 0 || exposure_s != options_.scene_exposure_s)
        return true;
    intervals = of_scene;
    frame.exposure_s = exposure_s;
    frame.intervals = intervals.data();
    frame.interval_count = intervals.size() / 2;
    return true;
}

// Only pairs name their regions.
bool Tracking::is_other_region(const char *roi) {
    if (regions_.empty())
        regions_.insert(roi);
    return regions_.count(roi) == 0;
}

void Tracking::note_unknown_exposure(const std::string &place) {
    const bool shifted = settings_.frames.stamp != TOLIMAN_FRAME_STAMP_MIDDLE;
    if (!shifted || settings_.frames.exposure_s > 0 || options_.new_folder.empty() ||
        std::exchange(noted_exposure_, true))
        return;
    progress_.tell(place + ": times are those of the stamps, the " + stamp_name(settings_.frames.stamp) +
                   " of the exposure: --exposure SECONDS moves them to its middle");
}

void Tracking::flush() {
    if (frames_.empty())
        return;
    std::vector<toliman_track_outcome> outcomes(frames_.size(), toliman::sized<toliman_track_outcome>());
    const auto frames = std::exchange(frames_, {});
    const auto origins = std::exchange(origins_, {});
    size_t done = 0;
    realigner_.begin();
    for (size_t i = 0; i < frames.size(); i++)
        realigner_.expect(frames[i], origins[i].source, origins[i].offset);
    const toliman_status status =
        toliman_track_push(tracker_.get(), frames.data(), frames.size(), outcomes.data(), &done);
    const toliman::error error(status);
    records_ = info_of(tracker_).records;
    for (size_t i = 0; i < done; i++)
        settle(frames[i], origins[i].place, outcomes[i]);
    if (status != TOLIMAN_OK)
        throw error;
    if (bank_)
        bank_->read(tracker_, progress_);
    if (since_update_ >= options_.every) {
        const PeriodFacts period = update(Fit::none);
        if (progress_.is_due())
            progress_.note("track", summary(period));
    }
    if (records_ - saved_ >= kCheckpoint) {
        check(toliman_track_save(tracker_.get()));
        saved_ = records_;
    }
}

void Tracking::settle(const toliman_frame &frame, const std::string &place, const toliman_track_outcome &outcome) {
    const int32_t verdict = outcome.verdict;
    const bool is_good = verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED,
               is_rejected = verdict == TOLIMAN_TRACK_VERDICT_REJECTED;
    const bool has_reason = is_rejected || verdict == TOLIMAN_TRACK_VERDICT_UNREDUCED;
    const bool is_whole = is_good || verdict == TOLIMAN_TRACK_VERDICT_UNREDUCED ||
                          verdict == TOLIMAN_TRACK_VERDICT_DUPLICATE ||
                          (verdict == TOLIMAN_TRACK_VERDICT_OUTLIER && outcome.goodness != TOLIMAN_GOODNESS_POOR);
    const int64_t shift = is_whole ? realigner_.shift_of(frame) : 0;
    realigner_.settle(frame, is_good || verdict == TOLIMAN_TRACK_VERDICT_UNREDUCED,
                      verdict == TOLIMAN_TRACK_VERDICT_DUPLICATE);
    note_shift(place, shift, is_whole);
    say(frame_line(frame, true, true, place, has_reason ? toliman_constant_name(outcome.reason) : nullptr, outcome,
                   shift));
    since_update_ += is_good;
    accepted_ += is_good;
    known_ += verdict == TOLIMAN_TRACK_VERDICT_DUPLICATE || verdict == TOLIMAN_TRACK_VERDICT_QUARANTINED;
    if (verdict == TOLIMAN_TRACK_VERDICT_UNREDUCED)
        unreduced_[outcome.reason]++;
    refused_ += is_rejected || verdict == TOLIMAN_TRACK_VERDICT_OUTLIER || verdict == TOLIMAN_TRACK_VERDICT_MISFIT;
    outside_clock_ += has_value(outcome) && is_outside_clock(settings_, frame.camera_ns);
    if (!is_good && verdict != TOLIMAN_TRACK_VERDICT_DUPLICATE && verdict != TOLIMAN_TRACK_VERDICT_UNREDUCED)
        warn(kind_of(outcome), place, verdict_text(frame, outcome, settings_));
    if (is_good)
        warn_if_far(place, outcome.value, outcome.sigma);
}

// A strong signal takes most values that far from 0, damage takes few.
void Tracking::warn_if_far(const std::string &place, double value, double sigma) {
    const double sigmas = std::fabs(value) / sigma;
    const bool has_orbit_error = settings_.reduction.plate_scale_arcsec > 0; // of the reference, far above the noise
    if (sigmas <= kFar || has_orbit_error)
        return;
    far_++;
    if (10 * far_ <= accepted_ + 10)
        warnings_.warn("accepted, but far from 0",
                       place +
                           formatted(": accepted, but its value of %.4g px is %.3g sigma: a strong signal, or damage "
                                     "that hides the period; a new folder with --value-limit excludes such frames, and "
                                     "`toliman rebuild --chi-limit` those that are damaged",
                                     value, sigmas));
}

// Frames that follow one that was found elsewhere are read there.
void Tracking::note_shift(const std::string &place, int64_t shift, bool is_good) {
    if (shift == 0 || !is_good)
        return;
    realigned_++;
    const std::string now = place.substr(0, place.rfind(':')) + " " + std::to_string(shift);
    if (now != std::exchange(shift_, now))
        warn("realigned", place,
             formatted("realigned: the frame is %lld bytes %s its place: the file has %s bytes before it",
                       static_cast<long long>(std::llabs(shift)), shift > 0 ? "after" : "before",
                       shift > 0 ? "gained" : "lost"));
}

void Tracking::warn(const std::string &kind, const std::string &place, const std::string &text, int64_t most) {
    damaged_++;
    warnings_.warn(kind, place + ": " + text, most);
}

void Tracking::reject(const toliman_frame &frame, bool has_key, const std::string &place, const char *reason,
                      const std::string &text) {
    flush();
    refused_++;
    warn(rejected_as(reason), place, rejected_as(reason) + ": " + text);
    auto outcome = toliman::sized<toliman_track_outcome>();
    outcome.verdict = TOLIMAN_TRACK_VERDICT_REJECTED;
    outcome.chi_square = outcome.chi_square_sigma = outcome.largest_residual = NAN;
    say(frame_line(frame, has_key, has_key && frame.rows > 0, place, reason, outcome, 0));
}

void Tracking::report(Severity severity, const std::string &warning, const std::string &input,
                      const std::string &text) {
    flush();
    unreadable_ += warning == "unreadable input";
    const std::string kind = kind_of(severity, warning, input, text);
    const int64_t most = warning == "unreadable input" ? kMostInputs : 1;
    if (severity == Severity::damage)
        warn(kind, input, text, most);
    else
        severity == Severity::warning ? warnings_.warn(kind, input + ": " + text, most)
                                      : warnings_.tell(kind, input + ": " + text);
    say(Json("schema", "toliman-track-warning/1", "warning", warning, "input", input, "text", text).line());
}

PeriodFacts Tracking::update(Fit fit) {
    since_update_ = 0;
    const PeriodFacts period(tracker_, fit, progress_);
    Json line("schema", "toliman-track-update/2");
    period.add_to(line);
    add_counts(tracker_, line);
    add_timing(settings_, line);
    line.set("bad_lines", reasons_[TOLIMAN_INGEST_REASON_BAD_LINE], "short_frames",
             reasons_[TOLIMAN_INGEST_REASON_SHORT_FILE] + reasons_[TOLIMAN_INGEST_REASON_PLACE_UNKNOWN], "clock_jumps",
             reasons_[TOLIMAN_INGEST_REASON_CLOCK_JUMP], "realigned", realigned_, "long_files",
             reasons_[TOLIMAN_INGEST_REASON_EXTRA_BYTES], "unreadable_inputs", unreadable_, "passed_over", skipped_);
    say(line.line());
    return period;
}

std::string Tracking::summary(const PeriodFacts &period) const {
    const std::string skipped = skipped_ > 0 ? ", " + std::to_string(skipped_) + " skipped" : "";
    return period.text() + ", " + std::to_string(info_of(tracker_).accepted) + " frames" + skipped;
}

// Messages about the run as a whole.
void Tracking::conclude() {
    warnings_.end([](const std::string &kind, int64_t count, int64_t told) {
        return kind + formatted(": %lld times, of which the first%s told; the lines on standard output have all",
                                static_cast<long long>(count),
                                told == 1 ? " was" : formatted(" %lld were", static_cast<long long>(told)).c_str());
    });
    if (outside_clock_ > 0)
        progress_.warn("frames outside the clock table: " + std::to_string(outside_clock_) +
                       "; their times are extrapolated: is there a newer table?");
    for (const auto &[reason, frames] : unreduced_)
        progress_.warn(unreduced_text(reason, frames, settings_.folder, options_.coverage));
    if (refused_ > 0 && accepted_ + known_ == 0 && unreduced_.empty())
        progress_.warn("none of the " + std::to_string(refused_) +
                       " frames of this run is accepted, all were rejected or are outliers or misfits: check the scene "
                       "or weights, the unit and gain of the counts, --dtype, --bit-depth, --shape, and known bad "
                       "pixels (--bad-pixels)");
    if (on_target_)
        on_target_->conclude(progress_);
    if (bank_)
        bank_->conclude(progress_);
    if (const std::string complaint = model_complaint(goodness_of(tracker_)); !complaint.empty())
        progress_.warn(std::string(settings_.folder) + ": " + complaint);
}

void Tracking::say(std::string text) {
    if (lines_.empty())
        oldest_ = std::chrono::steady_clock::now();
    lines_.push_back({records_, std::move(text)});
}

void Tracking::print_acknowledged() {
    const int64_t committed = info_of(tracker_).committed;
    std::string text;
    for (; !lines_.empty() && lines_.front().records <= committed; lines_.pop_front())
        text += lines_.front().text;
    if (text.empty())
        return;
    if (::isatty(STDOUT_FILENO) != 0) // the terminal of the progress line
        progress_.clear();
    print_stdout(text);
}

void Tracking::wait() {
    flush();
    stop_if_asked();
    if (lines_.empty() || std::chrono::steady_clock::now() - oldest_ < kPatience)
        return;
    check(toliman_track_commit(tracker_.get()));
    print_acknowledged();
}

void Tracking::end() {
    flush();
    const std::string result = summary(update(Fit::made));
    try {
        check(toliman_track_save(tracker_.get()));
    } catch (const std::exception &error) {
        print_acknowledged();
        progress_.tell(advice_after(error));
        throw;
    }
    remove_unused();
    print_acknowledged();
    conclude();
    progress_.close("track", result);
}

// A folder without frames would only bind the next command to options that may have been wrong. It is still locked.
bool Tracking::remove_unused() {
    if (options_.new_folder.empty() || info_of(tracker_).records > 0)
        return false;
    remove_state(options_.new_folder);
    progress_.tell(options_.new_folder + ": removed again, as no frame was read");
    return true;
}

void Tracking::rescue() {
    try {
        flush();
        const std::string result = summary(update(Fit::none));
        check(toliman_track_save(tracker_.get()));
        const bool is_kept = !remove_unused();
        ending_of([this] { print_acknowledged(); }); // also if standard output is closed
        conclude();
        progress_.close("track", result);
        if (is_kept)
            progress_.tell("state saved: " + std::to_string(info_of(tracker_).accepted) + " frames");
    } catch (const std::exception &error) {
        progress_.warn(error.what());
        progress_.tell(advice_after(error));
    }
    ending_of([this] { print_acknowledged(); });
}

} // namespace cli
