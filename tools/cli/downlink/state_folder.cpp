#include "downlink/state_folder.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/library.hpp"
#include "common/text.hpp"
#include "series/fap.hpp"

namespace cli {

namespace {

// Files of a state folder, the ledger last.
constexpr const char kLedger[] = "ledger.tlml", kSetup[] = "setup.tlms";
constexpr const char *kFiles[] = {"checkpoint.tlmc", kSetup, "streams.txt", kLedger};

std::string file_of_state(const std::string &folder, const char *name) {
    return folder + "/" + name;
}

// Damaged files of a state folder, and those that another process is writing to, have exit codes of their own.
[[noreturn]] void fail_state(toliman_status status, const std::string &folder) {
    if (status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_LOST)
        throw Failure(kExitState, damage_text(status, folder));
    if (status == TOLIMAN_E_STATE)
        throw Failure(kExitOutput, toliman_last_error());
    throw toliman::error(status);
}

// Bytes of a ledger's header by its number of columns (formats.md, TLML).
off_t header_size(const std::string &ledger) {
    unsigned char columns[4] = {};
    std::ifstream(ledger, std::ios::binary).seekg(112).read(reinterpret_cast<char *>(columns), sizeof columns);
    return 124 + 64 * (columns[0] | columns[1] << 8 | off_t{columns[2]} << 16 | off_t{columns[3]} << 24);
}

// False if there is none, or only the header of a run that was stopped before its first frame.
bool has_ledger(const std::string &folder) {
    struct stat status = {};
    if (::lstat(file_of_state(folder, kLedger).c_str(), &status) == 0)
        return !S_ISREG(status.st_mode) || status.st_size != header_size(file_of_state(folder, kLedger)) ||
               exists(file_of_state(folder, kSetup));
    if (errno != ENOENT && errno != ENOTDIR)
        malformed(folder, std::string("cannot be opened: ") + std::strerror(errno));
    for (const char *name : kFiles)
        if (exists(file_of_state(folder, name)))
            throw Failure(kExitState, folder + ": ledger.tlml is missing although " + name +
                                          " exists: the records of its frames are lost: give all frames again, into a "
                                          "new folder");
    return false;
}

} // namespace

void remove_state(const std::string &folder) {
    for (const char *name : kFiles)
        for (const char *suffix : {".tmp", ""})
            ::unlink((file_of_state(folder, name) + suffix).c_str());
    ::rmdir(folder.c_str());
}

std::string damage_text(toliman_status status, const std::string &folder) {
    return toliman_last_error() +
           (status == TOLIMAN_E_LOST ? ": `toliman merge " + folder + " --salvage --out NEW`" : std::string());
}

std::optional<toliman_track_options> made_with(const std::string &folder) {
    if (!has_ledger(folder))
        return std::nullopt;
    auto options = toliman::sized<toliman_track_options>();
    const toliman_status status = toliman_track_load_options(folder.c_str(), &options);
    if (status != TOLIMAN_OK)
        fail_state(status, folder);
    return options;
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

// NaN in all numbers.
toliman_period_peak unknown_peak() noexcept {
    auto peak = toliman::sized<toliman_period_peak>();
    for (double *number :
         {&peak.frequency, &peak.period, &peak.power, &peak.fwhm_period, &peak.frequency_error, &peak.amplitude,
          &peak.amplitude_error, &peak.phase, &peak.offset, &peak.log10_fap, &peak.period_error})
        *number = NAN;
    return peak;
}

// False for too few frames, or values that are all equal.
bool is_known(toliman_status status) {
    if (status == TOLIMAN_E_STATE || status == TOLIMAN_E_RANGE)
        return false;
    toliman::check(status);
    return true;
}

std::string unit_text(double unit_ns) {
    constexpr double kDay = 86400e9;
    return unit_ns == kDay ? "d" : formatted("units of %g s", unit_ns * 1e-9);
}

} // namespace

PeriodFacts::PeriodFacts(const toliman::tracker &tracker, Fit fit)
    : sequential_(NAN), peak_(unknown_peak()), fit_(unknown_peak()) {
    const toliman_period *period = nullptr;
    toliman::check(toliman_track_get_period(tracker.get(), &period));
    count_ = toliman_period_count(period);
    unit_ = unit_text(info_from<toliman_period_info>(toliman_period_get_info, period).unit_ns);
    if (!is_known(toliman_period_query_peak(period, &peak_)))
        return;
    toliman::check(toliman_period_query_fap(period, TOLIMAN_PERIOD_FAP_SEQUENTIAL, peak_.log10_residual, &sequential_));
    if (fit == Fit::made)
        is_known(toliman_track_query_fit(tracker.get(), &fit_));
}

void PeriodFacts::add_to(Json &json) const {
    json.set("n", count_)
        .set("period", peak_.period)
        .set("fwhm_period", peak_.fwhm_period)
        .set("frequency", peak_.frequency)
        .set("power", peak_.power)
        .set("log10_fap", peak_.log10_fap);
    json.set("log10_fap_sequential", sequential_).set("at_edge", (peak_.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
    if (!std::isfinite(fit_.period)) {
        json.set("fit", nullptr);
        return;
    }
    Json fit;
    fit.set("period", fit_.period).set("period_error", fit_.period_error).set("amplitude", fit_.amplitude);
    fit.set("amplitude_error", fit_.amplitude_error).set("phase", fit_.phase).set("offset", fit_.offset);
    json.set("fit", std::move(fit.set("log10_fap", fit_.log10_fap)));
}

std::string PeriodFacts::text() const {
    if (!std::isfinite(peak_.log10_fap))
        return "no period yet";
    const toliman_period_peak &best = std::isfinite(fit_.period) ? fit_ : peak_;
    return "period " + text_with_error(best.period, best.period_error) + " " + unit_ +
           formatted(", log10 FAP %.2f, sequential %.2f", best.log10_fap, sequential_) +
           (sequential_ > kSignificant ? ": no significant period" : "") +
           ((peak_.flags & TOLIMAN_PERIOD_INACCURATE) != 0 ? "; the power may be wrong by more than 0.001" : "");
}

const char *stamp_name(int32_t stamp) noexcept {
    static const char *const names[] = {"start", "middle", "end"};
    return names[stamp - TOLIMAN_FRAME_STAMP_START];
}

void add_timing(const toliman_track_options &settings, Json &json) {
    json.set("stamp", stamp_name(settings.stamp))
        .set("exposure_s", settings.exposure_s > 0 ? settings.exposure_s : NAN); // null: unknown
}

void add_counts(const toliman::tracker &tracker, Json &json) {
    const toliman_track_info info = info_of(tracker);
    json.set("received", info.received).set("accepted", info.accepted);
    json.set("outlier", info.outlier).set("quarantined", info.quarantined);
    json.set("repeated", info.repeated).set("rejected", info.rejected);
    Json reasons;
    for (int32_t reason = TOLIMAN_TRACK_REASON_SHAPE; reason <= TOLIMAN_TRACK_REASON_ESTIMATE; reason++) {
        int64_t frames = 0;
        toliman::check(toliman_track_get_rejected(tracker.get(), reason, &frames));
        reasons.set(toliman_track_reason_name(reason), frames);
    }
    json.set("rejected_by", std::move(reasons));
    json.set("expected", info.expected).set("missing", info.missing).set("dropped", info.dropped);
    json.set("sessions", info.sessions);
}

} // namespace cli
