#include "downlink/tracking.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <unistd.h>

#include "common/failure.hpp"
#include "common/json.hpp"
#include "common/output.hpp"

namespace cli {

namespace {

using toliman::check;

constexpr size_t kBatch = 64;                // frames that are estimated together, at most
constexpr int64_t kCheckpoint = 4096;        // lines of the ledger
constexpr std::chrono::seconds kPatience(1); // of lines that wait for the disk
constexpr const char kBadLine[] = "bad line";
constexpr const char kSafe[] = "lines that were printed are safe on the disk, and the same command goes on";
constexpr const char kLost[] =
    "frames that were printed as accepted may be lost with the ledger: give all frames again";
constexpr int64_t kMostWarnings = 10; // of one file; the lines on stdout have them all
constexpr double kFar = 20;           // sigma, of a value that noise does not reach
constexpr const char *kRemarkNames[kRemarks] = {"unreadable input", "extra bytes", "clock jump"};

Json frame_line(const std::string &where, const FrameFacts *facts, const char *verdict, const char *reason) {
    const bool timed = facts != nullptr && !(reason != nullptr && std::strcmp(reason, kBadLine) == 0);
    Json line;
    line.set("schema", "toliman-frame/2");
    for (const char *key : {"session", "roi"})
        facts == nullptr ? line.set(key, nullptr) : line.set(key, key[0] == 's' ? facts->session : facts->roi);
    facts == nullptr ? line.set("frame_id", nullptr) : line.set("frame_id", facts->id);
    line.set("verdict", std::string(verdict));
    reason == nullptr ? line.set("reason", nullptr) : line.set("reason", std::string(reason));
    timed ? line.set("camera_ns", facts->camera_ns) : line.set("camera_ns", nullptr);
    line.set("input", where);
    return line;
}

std::string remark_line(const char *remark, const std::string &where, const std::string &text) {
    Json line;
    line.set("schema", "toliman-track-warning/1").set("warning", remark);
    return line.set("input", where).set("text", text).line();
}

toliman_frame frame_of(const Arrival &arrival) noexcept {
    auto frame = toliman::sized<toliman_frame>();
    frame.pixel = arrival.pixel;
    frame.session = arrival.facts.session.c_str();
    frame.roi = arrival.facts.roi.c_str();
    frame.frame_id = arrival.facts.id;
    frame.camera_ns = arrival.facts.camera_ns;
    frame.dropped = arrival.facts.dropped;
    frame.pixels = arrival.pixels.data();
    frame.rows = static_cast<int64_t>(arrival.facts.rows);
    frame.cols = static_cast<int64_t>(arrival.facts.cols);
    return frame;
}

std::string number(double value, int digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

std::string shape(int64_t rows, int64_t cols) {
    return std::to_string(rows) + "x" + std::to_string(cols);
}

// What to do after the end of a run that could not save.
const char *advice_after(const std::exception &error) {
    const auto *failed = dynamic_cast<const toliman::error *>(&error);
    return failed != nullptr && failed->status() == TOLIMAN_E_LOST ? kLost : kSafe;
}

} // namespace

Tracking::Tracking(toliman::tracker &&tracker, const TrackingOptions &options, Progress &progress)
    : tracker_(std::move(tracker)), options_(options), progress_(progress),
      batch_(options.jobs > 1 ? std::min(kBatch, options.every) : 1), lines_(info_of(tracker_).records), saved_(lines_),
      sigma_(info_of(tracker_).sigma), clock_(clock_of(tracker_)) {}

void Tracking::take() {
    filled_++;
    // No update is passed over: at most as many frames at once as are left to the next.
    if (filled_ >= std::min(batch_.size(), std::max<size_t>(1, options_.every - since_update_))) {
        flush();
        print_acknowledged();
    }
    stop_if_asked();
}

void Tracking::flush() {
    if (filled_ == 0)
        return;
    std::vector<toliman_frame> frames;
    for (size_t i = 0; i < filled_; i++)
        frames.push_back(frame_of(batch_[i]));
    auto blank = toliman::sized<toliman_track_outcome>();
    std::vector<toliman_track_outcome> outcomes(filled_, blank);
    filled_ = 0;
    size_t done = 0;
    const toliman_status status =
        toliman_track_push(tracker_.get(), frames.data(), frames.size(), outcomes.data(), &done);
    const toliman::error error(status);
    lines_ = info_of(tracker_).records;
    for (size_t i = 0; i < done; i++)
        settled(batch_[i], outcomes[i]);
    if (status != TOLIMAN_OK)
        throw error;
    if (since_update_ >= options_.every)
        progress_.note("track", update(Fit::none));
    if (lines_ - saved_ >= kCheckpoint) {
        check(toliman_track_save(tracker_.get()));
        saved_ = lines_;
    }
}

void Tracking::settled(const Arrival &arrival, const toliman_track_outcome &outcome) {
    const int32_t verdict = outcome.verdict;
    const bool is_good = verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED,
               has_value = is_good || verdict == TOLIMAN_TRACK_VERDICT_OUTLIER;
    Json line =
        frame_line(arrival.where, &arrival.facts, toliman_track_verdict_name(verdict),
                   verdict == TOLIMAN_TRACK_VERDICT_REJECTED ? toliman_track_reason_name(outcome.reason) : nullptr);
    has_value ? line.set("tai_ns", outcome.tai_ns) : line.set("tai_ns", nullptr);
    has_value ? line.set_exact("value", outcome.value) : line.set("value", nullptr);
    line.set("chi_square", outcome.chi_square); // null where there is none
    say(line.line());
    since_update_ += is_good;
    good_ += is_good;
    known_ += verdict == TOLIMAN_TRACK_VERDICT_DUPLICATE || verdict == TOLIMAN_TRACK_VERDICT_QUARANTINED;
    refused_ += verdict == TOLIMAN_TRACK_VERDICT_REJECTED || verdict == TOLIMAN_TRACK_VERDICT_OUTLIER;
    beyond_clock_ += has_value && is_beyond_clock(arrival);
    if (!is_good && verdict != TOLIMAN_TRACK_VERDICT_DUPLICATE)
        warn(arrival.where, why(arrival.facts, outcome));
    if (is_good)
        remark_far(arrival.where, outcome.value);
}

// A strong signal takes most values so far from 0, damage few.
void Tracking::remark_far(const std::string &where, double value) {
    if (std::fabs(value) <= kFar * sigma_)
        return;
    far_++;
    if (10 * far_ <= good_ + 10)
        progress_.warn(where + ": accepted, but its value of " + number(value, 4) + " px is " +
                       number(std::fabs(value) / sigma_, 3) +
                       " sigma: a strong signal, or damage that hides the period; a new folder with --value-limit "
                       "keeps such frames out");
}

std::string Tracking::why(const FrameFacts &facts, const toliman_track_outcome &outcome) const {
    const std::string reason = toliman_track_reason_name(outcome.reason);
    if (outcome.verdict == TOLIMAN_TRACK_VERDICT_QUARANTINED)
        return "quarantined: frame " + std::to_string(facts.id) + " of session " + facts.session +
               " came before with other pixels, time or count of drops; neither counts any longer, nor will another "
               "copy";
    if (outcome.verdict == TOLIMAN_TRACK_VERDICT_OUTLIER)
        return "outlier: a value of " + number(outcome.value, 4) + " px, beyond the " +
               number(info_of(tracker_).value_limit, 4) + " px of --value-limit: it stays out of the periodogram";
    const std::string place = std::to_string(outcome.row) + ", " + std::to_string(outcome.col);
    switch (outcome.reason) {
    case TOLIMAN_TRACK_REASON_SHAPE:
        return "rejected: " + reason + " " + shape(outcome.row, outcome.col) + ", must be " +
               shape(options_.rows, options_.cols) + ": a new folder takes others by --shape and --crop";
    case TOLIMAN_TRACK_REASON_OVER_RANGE:
        return "rejected: " + reason + ", pixel " + place + " is " + number(outcome.pixel, 12) +
               ", more than --bit-depth allows";
    case TOLIMAN_TRACK_REASON_ZERO_RUN:
        return "rejected: " + reason + ", nothing but zeros up to pixel " + place;
    case TOLIMAN_TRACK_REASON_NOT_FINITE:
        return "rejected: " + reason + " at pixel " + place;
    case TOLIMAN_TRACK_REASON_CLOCK:
        return "rejected: " + reason + ": no TAI for its time, or too far off for the periodogram; see --clock";
    default:
        return "rejected: " + reason + ": no finite value, so far is it from frames of the scene or weights";
    }
}

// A single pair is a difference of clocks that has no ends.
bool Tracking::is_beyond_clock(const Arrival &arrival) const noexcept {
    if (clock_.size() < 4)
        return false;
    const int64_t time = arrival.facts.camera_ns, first = clock_.front(), last = clock_[clock_.size() - 2];
    return time < first || time > last;
}

void Tracking::warn(const std::string &where, const std::string &text) {
    troubles_++;
    const int64_t before = warned_[where.substr(0, where.rfind(':'))]++;
    if (before < kMostWarnings)
        progress_.warn(where + ": " + text);
    else if (before == kMostWarnings)
        progress_.tell(where + " and more of this file: see the lines on standard output");
}

bool Tracking::wants(const FrameFacts &facts) {
    const bool wanted = facts.id >= options_.frames.first && facts.id < options_.frames.end;
    passed_over_ += !wanted;
    return wanted;
}

void Tracking::reject(const std::string &where, const FrameFacts *facts, const char *reason, const std::string &text) {
    if (facts != nullptr && !wants(*facts))
        return;
    flush();
    (std::strcmp(reason, kBadLine) == 0 ? bad_lines_ : short_frames_)++;
    refused_++;
    warn(where, std::string("rejected: ") + reason + ": " + text);
    Json line = frame_line(where, facts, "rejected", reason);
    say(line.set("tai_ns", nullptr).set("value", nullptr).set("chi_square", nullptr).line());
}

void Tracking::remark(Remark kind, const std::string &where, const std::string &text) {
    flush();
    const auto at = static_cast<size_t>(kind);
    remarks_[at]++;
    warn(where, text);
    say(remark_line(kRemarkNames[at], where, text));
}

void Tracking::tell(const char *remark, const std::string &where, const std::string &text, bool warning) {
    flush();
    warning ? progress_.warn(where + ": " + text) : progress_.tell(where + ": " + text);
    say(remark_line(remark, where, text));
}

std::string Tracking::update(Fit fit) {
    since_update_ = 0;
    const toliman_track_info info = info_of(tracker_);
    const PeriodFacts period(tracker_, fit);
    Json line;
    line.set("schema", "toliman-track-update/2");
    period.add_to(line);
    add_counts(tracker_, line);
    line.set("bad_lines", bad_lines_).set("short_frames", short_frames_);
    line.set("clock_jumps", remarks_[static_cast<size_t>(Remark::clock_jump)]);
    line.set("long_files", remarks_[static_cast<size_t>(Remark::extra_bytes)]);
    line.set("unreadable_inputs", remarks_[static_cast<size_t>(Remark::unreadable)]);
    line.set("passed_over", passed_over_);
    say(line.line());
    const std::string passed = passed_over_ > 0 ? ", " + std::to_string(passed_over_) + " passed over" : "";
    return period.text() + ", " + std::to_string(info.accepted) + " frames" + passed;
}

// What only a whole run tells.
void Tracking::conclude() {
    for (const auto &[file, count] : warned_)
        if (count > kMostWarnings)
            progress_.warn(file + ": " + std::to_string(count) + " frames were not as they should be");
    if (beyond_clock_ > 0)
        progress_.warn(std::to_string(beyond_clock_) +
                       " frames lie outside the clock's table, where its nearest line goes on: is there a newer one?");
    if (refused_ > 0 && good_ + known_ == 0)
        progress_.warn(
            "none of the " + std::to_string(refused_) +
            " frames of this run is good, all were rejected or are outliers: check the scene or weights, --dtype, "
            "--bit-depth and --shape");
}

void Tracking::say(const std::string &text) {
    if (waiting_.empty())
        oldest_ = std::chrono::steady_clock::now();
    waiting_.push_back({lines_, text});
}

void Tracking::print_acknowledged() {
    const int64_t committed = info_of(tracker_).committed;
    std::string text;
    for (; !waiting_.empty() && waiting_.front().lines <= committed; waiting_.pop_front())
        text += waiting_.front().text;
    if (text.empty())
        return;
    if (::isatty(STDOUT_FILENO) != 0) // the same as that of progress
        progress_.clear();
    print_stdout(text);
}

void Tracking::wait() {
    flush();
    stop_if_asked();
    if (waiting_.empty() || std::chrono::steady_clock::now() - oldest_ < kPatience)
        return;
    check(toliman_track_commit(tracker_.get()));
    print_acknowledged();
}

void Tracking::end() {
    flush();
    const std::string result = update(Fit::made);
    save();
    remove_unused();
    print_acknowledged();
    conclude();
    progress_.close("track", result);
}

// A folder without a frame would only bind the next command to options that may have been wrong. It is still locked,
// and the library has just looked that the ledger is its own.
bool Tracking::remove_unused() {
    if (options_.made.empty() || info_of(tracker_).records > 0)
        return false;
    remove_state(options_.made);
    progress_.tell(options_.made + ": removed again, as no frame was read");
    return true;
}

void Tracking::save() {
    try {
        check(toliman_track_save(tracker_.get()));
    } catch (const std::exception &error) {
        print_acknowledged();
        progress_.tell(advice_after(error));
        throw;
    }
}

void Tracking::rescue() {
    try {
        flush();
        const std::string result = update(Fit::none);
        check(toliman_track_save(tracker_.get()));
        const bool is_kept = !remove_unused();
        ending_of([this] { print_acknowledged(); }); // whether or not anybody reads them
        conclude();
        progress_.close("track", result);
        if (is_kept)
            progress_.tell("state saved: " + std::to_string(info_of(tracker_).accepted) + " frames");
    } catch (const std::exception &error) {
        progress_.warn(error.what());
        progress_.tell(advice_after(error));
    }
    ending_of([this] { print_acknowledged(); }); // whether or not anybody reads them
}

} // namespace cli
