// toliman status, toliman rebuild: the contents of a state folder, and its sums for another grid, clock or epoch.
#include "downlink/folder_facts.hpp"
#include "downlink/instrument_trends.hpp"
#include "downlink/ledger_report.hpp"
#include "downlink/setup_options.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

struct StatusOptions {
    std::string folder, out;
    bool as_json = false, records = false, series = false, missing = false;
};

struct RebuildOptions : StatusOptions {
    SetupOptions setup;
    ReferenceOptions reference;
    std::string leap_seconds;
};

constexpr size_t kShownSessions = 20;

std::string name_of_system(const char *system) {
    const auto sky = toliman::make<toliman::sky_predictor>(toliman_sky_create, system, nullptr);
    const std::string name = toliman::result<toliman_sky_info>(toliman_sky_get_info, sky.get()).name;
    return name.empty() ? "a system without name" : name;
}

// The settings that the folder was created with.
std::string settings_text(const toliman_track_options &how, const toliman_track_info &info,
                          const std::optional<double> &sigma) {
    const auto number = [](int64_t value) { return static_cast<long long>(value); };
    std::string text = formatted("  grid        %.6g + k %.6g per day, %lld frequencies; time 0 at TAI %lld ns\n",
                                 how.grid.f0, how.grid.df, number(how.grid.nf), number(how.grid.time_offset_ns));
    text += formatted("  clock       %s\n", how.clock.count == 0 ? "the camera's time is TAI" : "a table of pairs");
    text +=
        formatted("  exposures   %s, time stamps at their %s\n",
                  how.frames.exposure_s > 0 ? formatted("%.6g s", how.frames.exposure_s).c_str() : "of unknown length",
                  stamp_name(how.frames.stamp));
    text += formatted("  frames      %lldx%lld of %u bits", number(how.frames.rows), number(how.frames.cols),
                      how.frames.bit_depth);
    if (how.frames.image_rows != how.frames.rows || how.frames.image_cols != how.frames.cols)
        text += formatted(
            ", cropped to %lldx%lld from row %lld, column %lld%s", number(how.frames.image_rows * how.frames.bin),
            number(how.frames.image_cols * how.frames.bin), number(how.frames.crop_row), number(how.frames.crop_col),
            how.frames.bin > 1 ? formatted(", binned %lldx%lld", number(how.frames.bin), number(how.frames.bin)).c_str()
                               : "");
    if (info.system != nullptr)
        text += formatted("\n  reduction   to the orbit of %s, plate scale %.9g arcsec per px",
                          name_of_system(info.system).c_str(), info.plate_scale_arcsec);
    return text + formatted("\n  estimator   %016llx", static_cast<unsigned long long>(how.estimator.id)) +
           (sigma ? formatted(", median sigma of the frames %.3g px", *sigma) : "") +
           formatted(", values beyond %.3g px are outliers\n", how.limits.value);
}

std::string indented(const std::string &lines) {
    std::string text;
    for (const char c : lines)
        text += (text.empty() || text.back() == '\n' ? "  " : "") + std::string(1, c);
    return text;
}

std::string sessions_text(const std::vector<toliman_track_stream> &streams) {
    std::string text;
    for (size_t i = 0; i < std::min(streams.size(), kShownSessions); i++) {
        const toliman_track_stream &stream = streams[i];
        const std::string restart = stream.restarts > 0 ? " restart " + std::to_string(stream.restarts) : "";
        const std::string name = std::string(stream.session) + " " + stream.roi + restart;
        text += formatted("  %-30s ids %lld to %lld, %lld frames, %lld missing\n", name.c_str(),
                          static_cast<long long>(stream.first_id), static_cast<long long>(stream.last_id),
                          static_cast<long long>(stream.frames), static_cast<long long>(stream.missing));
    }
    if (streams.size() > kShownSessions)
        text += formatted("  and %zu more, listed by --json\n", streams.size() - kShownSessions);
    return text;
}

void print(const toliman::tracker &tracker, const toliman_track_options &how, const PeriodFacts &period, bool as_json) {
    if (as_json)
        return print_stdout(status_json(tracker, how, period).text());
    print_stdout(how.folder + ("\n  " + period.text() + "\n") + indented(period.aliases_text()) + counts_text(tracker) +
                 goodness_text(goodness_of(tracker)) + text_of(trends_of(tracker)) +
                 settings_text(how, info_of(tracker), median_sigma(tracker)) + indented(period.functions_text()) +
                 sessions_text(streams_of(tracker)));
}

void warn_of_model(const std::string &folder, const toliman::tracker &tracker, Progress &progress) {
    if (const std::string complaint = model_complaint(goodness_of(tracker)); !complaint.empty())
        progress.warn(folder + ": " + complaint);
}

// Such a folder is good for residuals only.
void warn_of_refit(const std::string &folder, const toliman::tracker &tracker, Progress &progress) {
    if (info_of(tracker).accepted > 0 && info_of(accepted_frames(tracker).get()).is_refitted != 0)
        progress.warn(folder + ": its orbit was refitted to these frames: do not search them; before a search " +
                      orbit_before_refit(folder));
}

void status(StatusOptions &options, Progress &progress) {
    options.folder = plain(options.folder);
    const toliman_track_options how = state_to_read(options.folder);
    const toliman::tracker tracker = open_tracker(how, progress);
    if (options.records)
        return print_records(tracker);
    if (options.series)
        return print_series(tracker, how);
    if (options.missing)
        return print_missing(tracker);
    const toliman_track_options settings = settings_of(tracker);
    const PeriodFacts period(tracker, Fit::tested, progress);
    progress.clear();
    if (!options.out.empty())
        write_results(tracker, settings, period, options.out);
    print(tracker, settings, period, options.as_json);
    warn_of_model(options.folder, tracker, progress);
    warn_of_refit(options.folder, tracker, progress);
}

// A new grid changes the span of a trend. --system brings the errors of its orbit, unless a folder with a system has a
// trend.
void set_functions(const RebuildOptions &options, toliman_track_options &how) {
    const bool brings_errors =
        options.reference.has_system() && (how.reduction.plate_scale_arcsec == 0 || how.grid.trend < 0);
    if (brings_errors)
        how.grid.trend = 0;
    if (brings_errors || options.setup.has_grid())
        how.grid.trend_start = how.grid.trend_end = 0;
}

void rebuild(RebuildOptions &options, Progress &progress) {
    options.folder = plain(options.folder);
    toliman_track_options how = known_state(options.folder);
    if (how.grid.nf == 0)
        options.setup.check_complete(options.folder);
    set_functions(options, how);
    options.setup.set_leap_seconds(options.leap_seconds);
    options.setup.set(how, progress);
    options.reference.set_leap_seconds(options.leap_seconds);
    if (options.reference.given())
        options.reference.set(how, how, progress);
    if (how.reduction.sky != nullptr && how.reduction.plate_scale_arcsec == 0)
        throw Failure(kExitUsage, "rebuild: --system needs --plate-scale: the separations of " + options.folder +
                                      " were not reduced before");
    how.flags |= TOLIMAN_TRACK_REBUILD;
    const toliman::tracker tracker = open_tracker(how, progress);
    toliman::check(toliman_track_save(tracker.get()));
    print(tracker, settings_of(tracker), PeriodFacts(tracker, Fit::tested, progress), options.as_json);
    warn_of_refit(options.folder, tracker, progress);
}

} // namespace

void add_status(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "status");
    auto options = std::make_shared<StatusOptions>();
    add_option(command, "DIR", options->folder, "")->required();
    CLI::Option *json = command->add_flag("--json", options->as_json);
    CLI::Option *records = command->add_flag("--records", options->records);
    CLI::Option *series = command->add_flag("--series", options->series);
    CLI::Option *missing = command->add_flag("--missing", options->missing);
    CLI::Option *out = add_option(command, "--out", options->out, "DIR")->check([](const std::string &name) {
        return name.empty() ? "\"\": must be the name of a folder" : "";
    });
    records->excludes(json)->excludes(out);
    series->excludes(json)->excludes(records)->excludes(out);
    missing->excludes(json)->excludes(records)->excludes(series)->excludes(out);
    set_action(*command, context, options, status);
}

void add_rebuild(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "rebuild");
    auto options = std::make_shared<RebuildOptions>();
    add_option(command, "DIR", options->folder, "")->required();
    options->setup.add_to(*command);
    options->reference.add_to(*command);
    add_option(command, "--leap-seconds", options->leap_seconds, "FILE");
    command->add_flag("--json", options->as_json);
    set_action(*command, context, options, rebuild);
}

} // namespace cli
