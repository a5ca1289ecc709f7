#include "downlink/state_folder.hpp"

#include <cerrno>
#include <cstring>
#include <unistd.h>
#include <utility>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/library.hpp"
#include "common/text.hpp"
#include "series/fap.hpp"

namespace cli {

namespace {

// Damaged files of a state folder, and those that another process is writing to, have exit codes of their own.
[[noreturn]] void fail_state(toliman_status status, const std::string &folder) {
    if (status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_LOST)
        throw Failure(kExitState, damage_text(status, folder));
    if (status == TOLIMAN_E_STATE)
        throw Failure(kExitOutput, toliman_last_error());
    throw toliman::error(status);
}

} // namespace

void remove_state(const std::string &folder) {
    for (const char *name : {"checkpoint.tlmc", "setup.tlms", "streams.txt", "ledger.tlml"})
        for (const char *suffix : {".tmp", ""})
            ::unlink((folder + "/" + name + suffix).c_str());
    ::rmdir(folder.c_str());
}

std::string damage_text(toliman_status status, const std::string &folder) {
    return toliman_last_error() +
           (status == TOLIMAN_E_LOST ? ": `toliman merge " + folder + " --salvage --out NEW`" : std::string());
}

std::optional<toliman_track_options> made_with(const std::string &folder) {
    auto options = toliman::sized<toliman_track_options>();
    const toliman_status status = toliman_track_load_options(folder.c_str(), &options);
    if (status == TOLIMAN_OK)
        return options;
    if (status != TOLIMAN_E_NOT_FOUND || toliman_last_error_field() != folder)
        fail_state(status, folder);
    if (::access((folder + "/.").c_str(), R_OK) != 0 && errno != ENOENT && errno != ENOTDIR)
        malformed(folder, std::string("cannot be opened: ") + std::strerror(errno));
    return std::nullopt;
}

toliman_track_options known_state(const std::string &folder) {
    const std::optional<toliman_track_options> made = made_with(folder);
    if (!made)
        malformed(folder, exists(folder) ? "is not a state folder of `toliman track`" : std::strerror(ENOENT));
    return *made;
}

toliman_track_options state_to_read(const std::string &folder) {
    toliman_track_options how = known_state(folder);
    if (how.nf == 0)
        throw Failure(kExitState, folder + ": setup.tlms with grid and clock is lost: `toliman rebuild " + folder +
                                      " --grid F0:DF:NF --clock CSV --stamp POINT` rebuilds it");
    how.flags |= TOLIMAN_TRACK_READ_ONLY;
    return how;
}

toliman::tracker open_tracker(toliman_track_options options, Progress &progress) {
    toliman_track *tracker = nullptr;
    options.log = Progress::log;
    options.log_data = &progress;
    const toliman_status status = toliman_track_create(&options, &tracker);
    if (status != TOLIMAN_OK)
        fail_state(status, options.folder);
    return toliman::tracker(tracker);
}

toliman_track_info info_of(const toliman::tracker &tracker) {
    return info_from<toliman_track_info>(toliman_track_get_info, tracker.get());
}

toliman_track_options settings_of(const toliman::tracker &tracker) {
    return info_from<toliman_track_options>(toliman_track_get_options, tracker.get());
}

namespace {

constexpr std::pair<const char *, int64_t toliman_track_info::*> kCounts[] = {
    {"received", &toliman_track_info::received},       {"accepted", &toliman_track_info::accepted},
    {"unreduced", &toliman_track_info::unreduced},     {"outlier", &toliman_track_info::outlier},
    {"quarantined", &toliman_track_info::quarantined}, {"repeated", &toliman_track_info::repeated},
    {"rejected", &toliman_track_info::rejected},       {"expected", &toliman_track_info::expected},
    {"missing", &toliman_track_info::missing},         {"dropped", &toliman_track_info::dropped},
    {"sessions", &toliman_track_info::sessions}};

using PeakMember = std::pair<const char *, double toliman_period_peak::*>;
constexpr PeakMember kPeak[] = {{"period", &toliman_period_peak::period},
                                {"fwhm_period", &toliman_period_peak::fwhm_period},
                                {"frequency", &toliman_period_peak::frequency},
                                {"power", &toliman_period_peak::power},
                                {"log10_fap", &toliman_period_peak::log10_fap}};
constexpr PeakMember kFit[] = {
    {"period", &toliman_period_peak::period},       {"period_error", &toliman_period_peak::period_error},
    {"amplitude", &toliman_period_peak::amplitude}, {"amplitude_error", &toliman_period_peak::amplitude_error},
    {"phase", &toliman_period_peak::phase},         {"offset", &toliman_period_peak::offset},
    {"log10_fap", &toliman_period_peak::log10_fap}};

template <size_t N>
void add_members(Json &json, const PeakMember (&members)[N], const std::optional<toliman_period_peak> &peak) {
    for (const auto &[name, member] : members)
        json.set(name, peak ? (*peak).*member : NAN);
}

// The peak that query(&peak) finds; nothing for too few frames, or values that are all equal.
template <class Query> std::optional<toliman_period_peak> peak_of(Query query) {
    auto peak = toliman::sized<toliman_period_peak>();
    const toliman_status status = query(&peak);
    if (status == TOLIMAN_E_STATE || status == TOLIMAN_E_RANGE)
        return std::nullopt;
    toliman::check(status);
    return peak;
}

std::string unit_text(double unit_ns) {
    constexpr double kDay = 86400e9;
    return unit_ns == kDay ? "d" : formatted("units of %g s", unit_ns * 1e-9);
}

} // namespace

PeriodFacts::PeriodFacts(const toliman::tracker &tracker, Fit fit) {
    const toliman_period *period = nullptr;
    toliman::check(toliman_track_get_period(tracker.get(), &period));
    count_ = toliman_period_count(period);
    unit_ = unit_text(info_from<toliman_period_info>(toliman_period_get_info, period).unit_ns);
    peak_ = peak_of([&](toliman_period_peak *peak) { return toliman_period_query_peak(period, peak); });
    if (!peak_)
        return;
    toliman::check(
        toliman_period_query_fap(period, TOLIMAN_PERIOD_FAP_SEQUENTIAL, peak_->log10_residual, &sequential_));
    if (fit == Fit::made)
        fit_ = peak_of([&](toliman_period_peak *peak) { return toliman_track_query_fit(tracker.get(), peak); });
    if (fit_ && !std::isfinite(fit_->period))
        fit_.reset();
}

void PeriodFacts::add_to(Json &json) const {
    std::optional<Json> fit;
    if (fit_)
        add_members(fit.emplace(), kFit, fit_);
    json.set("n", count_);
    add_members(json, kPeak, peak_);
    json.set("log10_fap_sequential", sequential_, "at_edge", peak_ && (peak_->flags & TOLIMAN_PERIOD_AT_EDGE) != 0,
             "fit", std::move(fit));
}

std::string PeriodFacts::text() const {
    if (!peak_ || !std::isfinite(peak_->log10_fap))
        return "no period yet";
    const toliman_period_peak &best = fit_ ? *fit_ : *peak_;
    return "period " + text_with_error(best.period, best.period_error) + " " + unit_ +
           formatted(", log10 FAP %.2f, sequential %.2f", best.log10_fap, sequential_) +
           (sequential_ > kSignificant ? ": no significant period" : "") +
           ((peak_->flags & TOLIMAN_PERIOD_INACCURATE) != 0 ? "; the power may be wrong by more than 0.001" : "");
}

const char *stamp_name(int32_t stamp) noexcept {
    static const char *const names[] = {"start", "middle", "end"};
    return names[stamp - TOLIMAN_FRAME_STAMP_START];
}

void add_timing(const toliman_track_options &settings, Json &json) {
    json.set("stamp", stamp_name(settings.stamp), "exposure_s", if_known(settings.exposure_s > 0, settings.exposure_s));
}

void add_counts(const toliman::tracker &tracker, Json &json) {
    const toliman_track_info info = info_of(tracker);
    for (const auto &[name, count] : kCounts) {
        json.set(name, info.*count);
        if (count != &toliman_track_info::rejected)
            continue;
        Json reasons;
        for (int32_t reason = TOLIMAN_TRACK_REASON_SHAPE; reason <= TOLIMAN_TRACK_REASON_ESTIMATE; reason++) {
            int64_t frames = 0;
            toliman::check(toliman_track_get_rejected(tracker.get(), reason, &frames));
            reasons.set(toliman_track_reason_name(reason), frames);
        }
        json.set("rejected_by", std::move(reasons));
    }
}

std::string counts_text(const toliman::tracker &tracker) {
    const toliman_track_info info = info_of(tracker);
    std::string text;
    for (const auto &[name, count] : kCounts) {
        const auto number = static_cast<long long>(info.*count);
        if (count == &toliman_track_info::sessions)
            text += formatted("  sessions and regions: %2lld\n", number);
        else
            text += formatted("  %-11s %12lld%s\n", name, number,
                              count == &toliman_track_info::dropped ? "   by the camera" : "");
    }
    return text;
}

} // namespace cli
