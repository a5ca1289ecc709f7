// toliman planet: the planets of a series, and those that it excludes.
#include <optional>
#include <utility>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/output.hpp"
#include "common/stop.hpp"
#include "downlink/planet_state.hpp"
#include "options/command.hpp"
#include "series/planet_folder.hpp"
#include "series/series_options.hpp"

namespace cli {

namespace {

struct Options : SeriesOptions {
    std::string unit, out;
    PlanetOptions planets;
    MapOptions map;
    bool limits = false, as_json = false;
    std::vector<std::string> of_series; // options that were given and do not suit a state folder
};

// A series with its functions, and what is known of its values and stars.
struct Input {
    Series series;
    ValueUnit unit;
    StarData stars;
    std::optional<ReductionNote> reduced;
};

// Options that a state folder has already fixed.
constexpr const char *kOfSeries[] = {"--columns",  "--time-format", "--time-scale", "--leap-seconds",  "--trend",
                                     "--span",     "--prior",       "--system",     "--nuisance-file", "--scale-sigma",
                                     "--observer", "--altitude",    "--node",       "--exposure"};

// --plate-scale is the size of the px of --unit.
Input input_of_state(const Options &options, Progress &progress) {
    if (!options.of_series.empty())
        throw Failure(kExitUsage, options.of_series[0] + ": must not be given with a state folder, " + options.file);
    StateSeries state = dated_series(options.file, progress);
    Input input = {std::move(state.series), {}, {}, std::nullopt};
    if (state.system.empty()) {
        input.unit = unit_of(options.reduction.plate_scale ? "px" : "", options.reduction.plate_scale);
        return input;
    }
    if (options.reduction.plate_scale)
        throw Failure(kExitUsage,
                      "--plate-scale: must not be given with a state folder that has a plate scale, " + options.file);
    input.unit = unit_of("px", state.plate_scale);
    input.stars = stars_of(state.system);
    return input;
}

Input input_of_series(const Options &options, Progress &progress) {
    Input input = {read_series(options.file, options.samples), {}, {}, std::nullopt};
    if (!input.series.warning.empty())
        progress.warn(input.series.warning);
    input.unit = options.system
                     ? unit_of(options.reduction.plate_scale ? "px" : "arcsec", options.reduction.plate_scale)
                     : unit_of(options.unit, options.reduction.plate_scale);
    options.planets.check(input.unit); // before the reduction, which takes seconds
    input.reduced = add_functions(options, true, "", input.series, progress);
    if (options.system)
        input.stars = stars_of(*options.system);
    return input;
}

// With a folder, a stopped map is resumed from its file.
DetectionMap map_of(const Options &options, const Series &series, const PlanetSearch &search,
                    const PlanetFolder *folder, Progress &progress) {
    DetectionMap map = empty_map(options.map, search, options.planets.seed);
    std::optional<MapFile> file;
    if (folder != nullptr)
        file.emplace(folder->map_path(), map, search, series);
    const char *const stopped = file ? "stopped by a signal; the same command resumes the map" : "stopped by a signal";
    try {
        const StopLimit limit(stopped);
        fill(map, search, file ? &*file : nullptr, progress);
    } catch (...) {
        if (stop_signal() == 0)
            throw;
        progress.clear();
        throw Failure(stop_code(), stopped);
    }
    return map;
}

void planet(Options &options, Progress &progress) {
    options.file = plain(options.file);
    options.samples.leap_seconds = options.reduction.observer.leap_seconds();
    options.nuisance.check();
    std::optional<PlanetFolder> folder;
    if (!options.out.empty()) {
        check_not_input(options.out + "/series.csv", {options.file, options.nuisance.file});
        folder.emplace(options.out, options.limits);
    }
    const Input input =
        is_folder(options.file) ? input_of_state(options, progress) : input_of_series(options, progress);
    options.planets.check(input.unit);
    const PlanetSearch search =
        find_planets(input.series, options.planets, input.unit, options.planets.stars(input.stars), progress);
    PlanetReport report = {search, input.series, input.reduced, {}, std::nullopt};
    if (options.limits)
        report.limits = limits_of(search);
    if (options.map.is_wanted)
        report.map = map_of(options, input.series, search, folder ? &*folder : nullptr, progress);
    progress.clear();
    report.warn(progress);
    if (folder)
        folder->write(report);
    if (options.as_json)
        print_stdout(report.json().text());
    else
        report.print();
}

} // namespace

void add_planet(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "planet");
    auto options = std::make_shared<Options>();
    add_option(command, "SERIES", options->file, "",
               "series t,y,sigma as of `toliman period`, or a state folder of `toliman track`")
        ->required();
    add_option(command, "--columns", options->samples.columns, "NAMES",
               "names of the columns to use: T,Y or T,Y,SIGMA; default t,y and, if present, sigma");
    add_times(*command, options->samples);
    options->nuisance.add_to(*command);
    CLI::Option *system = add_system_options(*command, *options);
    command->get_option("--plate-scale")->remove_needs(system); // also of --unit px
    CLI::Option *unit = add_choice(command, "--unit", options->unit,
                                   std::vector<std::string>{"arcsec", "mas", "uas", "px", "m/s", "km/s"},
                                   "unit of y, for masses: arcsec, mas, uas, px (--plate-scale); m/s and km/s are "
                                   "radial velocities; default: unknown separations");
    unit->excludes(system); // whose values are in arcsec or px
    options->planets.add_to(*command);
    command->add_flag("--limits", options->limits, "list upper limits and detectable planets at 40 periods");
    options->map.add_to(*command);
    command->add_flag("--json", options->as_json, "print JSON, schema toliman-planet/1");
    add_option(command, "--out", options->out, "DIR",
               "write result.json, series, samples, limits and map into this folder, for toliman report");
    set_action(*command, context, options, planet, [command, options] {
        for (const char *name : kOfSeries)
            if (command->count(name) > 0)
                options->of_series.emplace_back(name);
        if (command->count("--unit") > 0 && is_folder(options->file))
            options->of_series.emplace_back("--unit");
    });
}

} // namespace cli
