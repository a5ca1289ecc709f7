#include "downlink/state_folder.hpp"

#include <unistd.h>

#include "scenes/observer_options.hpp"
#include "series/series.hpp"

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
    if (how.grid.nf == 0)
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
    return toliman::result<toliman_track_info>(toliman_track_get_info, tracker.get());
}

toliman_track_options settings_of(const toliman::tracker &tracker) {
    return toliman::result<toliman_track_options>(toliman_track_get_options, tracker.get());
}

namespace {

constexpr std::pair<const char *, int64_t toliman_track_info::*> kCounts[] = {
    {"received", &toliman_track_info::received},   {"accepted", &toliman_track_info::accepted},
    {"unreduced", &toliman_track_info::unreduced}, {"outlier", &toliman_track_info::outlier},
    {"misfit", &toliman_track_info::misfit},       {"quarantined", &toliman_track_info::quarantined},
    {"repeated", &toliman_track_info::repeated},   {"rejected", &toliman_track_info::rejected},
    {"expected", &toliman_track_info::expected},   {"missing", &toliman_track_info::missing},
    {"dropped", &toliman_track_info::dropped},     {"sessions", &toliman_track_info::sessions}};

} // namespace

void add_timing(const toliman_track_options &settings, Json &json) {
    json.set("stamp", stamp_name(settings.frames.stamp), "exposure_s",
             if_known(settings.frames.exposure_s > 0, settings.frames.exposure_s));
}

void add_counts(const toliman::tracker &tracker, Json &json) {
    const toliman_track_info info = info_of(tracker);
    for (const auto &[name, count] : kCounts) {
        json.set(name, info.*count);
        if (count != &toliman_track_info::rejected)
            continue;
        Json reasons;
        for (int32_t reason = TOLIMAN_TRACK_REASON_SHAPE; reason <= TOLIMAN_TRACK_REASON_ESTIMATE; reason++)
            reasons.set(toliman_constant_name(reason), info.rejected_for[reason - TOLIMAN_TRACK_REASON_NONE]);
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

namespace {

toliman::measurements frames_of(const toliman::tracker &tracker, const toliman_measure_options &options) {
    toliman_measure *made = nullptr;
    const toliman_status status = toliman_track_get_measure(tracker.get(), &options, &made);
    if (status == TOLIMAN_E_NOT_FOUND)
        malformed(settings_of(tracker).folder, toliman_last_error());
    toliman::check(status);
    return toliman::measurements(made);
}

} // namespace

toliman::measurements measured_frames(const std::string &folder, const std::optional<double> &plate_scale,
                                      Progress &progress) {
    const toliman::tracker tracker = open_tracker(state_to_read(folder), progress);
    const double known = info_of(tracker).plate_scale_arcsec;
    if (!plate_scale && !(known > 0))
        throw Failure(kExitUsage, folder + ": has no plate scale, as its frames are not reduced: give --plate-scale");
    auto options = toliman::sized<toliman_measure_options>();
    options.kind = TOLIMAN_MEASURE_SEPARATION;
    options.unit = plate_scale_of(plate_scale, known);
    toliman::measurements measured = frames_of(tracker, options);
    if (const int64_t left_out = info_of(measured.get()).left_out; left_out > 0)
        progress.warn(folder + formatted(": %lld frames are left out, as their time on target is not known",
                                         static_cast<long long>(left_out)));
    return measured;
}

toliman::measurements accepted_frames(const toliman::tracker &tracker, uint32_t flags) {
    auto options = toliman::sized<toliman_measure_options>();
    options.flags = flags;
    return frames_of(tracker, options);
}

std::string orbit_before_refit(const std::string &folder) {
    return "`toliman rebuild " + folder + " --observer FILE --system SYSTEM` with the system before the refit";
}

double time_of(int64_t tai_ns, const toliman_track_options &how) {
    const long double elapsed = static_cast<long double>(tai_ns) - static_cast<long double>(how.grid.time_offset_ns);
    return static_cast<double>(elapsed / static_cast<long double>(how.grid.unit_ns));
}

std::vector<Function> element_columns(const toliman::tracker &tracker) {
    const toliman_track_info info = info_of(tracker);
    std::vector<Function> columns;
    for (int32_t i = 0; i < static_cast<int32_t>(TOLIMAN_SKY_ELEMENTS); i++) {
        if ((info.elements >> i & 1) == 0)
            continue;
        Function &column = columns.emplace_back(toliman::sized<Function>());
        std::snprintf(column.name, sizeof column.name, "%s", toliman_constant_name(TOLIMAN_SKY_ELEMENT_PERIOD + i));
        column.unit = info.plate_scale_arcsec;
    }
    return columns;
}

} // namespace cli
