#include "downlink/planet_job.hpp"

#include "downlink/state_folder.hpp"
#include "options/command.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

// Options that a state folder has already fixed.
constexpr const char *kOfSeries[] = {"--columns",       "--time-format", "--time-scale", "--leap-seconds",
                                     "--trend",         "--span",        "--prior",      "--system",
                                     "--nuisance-file", "--scale-sigma", "--observer",   "--altitude",
                                     "--node",          "--exposure",    "--on-target",  "--instrument"};

} // namespace

void PlanetJobOptions::add_to(CLI::App &command) {
    add_option(&command, "SERIES", file, "")->required();
    samples.add_to(command, true);
    nuisance.add_to(command);
    CLI::Option *system_option = add_system_options(command, *this);
    command.get_option("--plate-scale")->remove_needs(system_option); // also of --unit px
    CLI::Option *unit_option =
        add_choice(&command, "--unit", unit, std::vector<std::string>{"arcsec", "mas", "uas", "px", "m/s", "km/s"});
    unit_option->excludes(system_option); // whose values are in arcsec or px
    planets.add_to(command);
    command.add_flag("--limits", limits);
    map.add_to(command);
    command.add_flag("--json", as_json);
    add_option(&command, "--out", out, "DIR");
}

void PlanetJobOptions::see(const CLI::App &command) {
    for (const char *name : kOfSeries)
        if (command.count(name) > 0)
            of_series.emplace_back(name);
    if (command.count("--unit") > 0 && is_folder(file))
        of_series.emplace_back("--unit");
}

// --plate-scale is the size of the px of --unit.
PlanetJob::Input PlanetJob::input_of_state(Progress &progress) const {
    const PlanetJobOptions &options = options_;
    if (!options.of_series.empty())
        throw Failure(kExitUsage, options.of_series[0] + ": must not be given with a state folder, " + options.file);
    const toliman::tracker tracker = open_tracker(state_to_read(options.file), progress);
    Input input = {accepted_frames(tracker), {}, std::nullopt};
    const toliman_measure_info info = info_of(input.series.get());
    refuse_refitted(input.series.get(), options.file, orbit_before_refit(options.file));
    if (info.kind != TOLIMAN_MEASURE_REDUCED) {
        input.unit = unit_of(options.reduction.plate_scale ? "px" : "", options.reduction.plate_scale);
        return input;
    }
    if (options.reduction.plate_scale)
        throw Failure(kExitUsage,
                      "--plate-scale: must not be given with a state folder that has a plate scale, " + options.file);
    input.unit = unit_of("px", info.unit);
    return input;
}

PlanetJob::Input PlanetJob::input_of_series(Progress &progress) const {
    const PlanetJobOptions &options = options_;
    Input input = {read_series(options, progress), {}, std::nullopt};
    input.unit = options.system ? unit_of_separations(input.series.get(), options.reduction)
                                : unit_of(options.unit, input.series.get(), options.reduction.plate_scale);
    options.planets.check(input.unit); // before the reduction, which takes seconds
    input.reduced = add_functions(options, true, "", input.series, progress);
    return input;
}

PlanetJob::PlanetJob(PlanetJobOptions &options, bool writes, Progress &progress) : options_(options) {
    options.file = plain(options.file);
    options.samples.leap_seconds = options.reduction.observer.leap_seconds();
    options.nuisance.check();
    options.planets.velocity_samples.leap_seconds = options.samples.leap_seconds;
    if (writes && !options.out.empty()) {
        check_not_input(options.out + "/series.csv", {options.file, options.nuisance.file});
        folder_.emplace(options.out, files_of(options.limits));
    }
    input_.emplace(is_folder(options.file) ? input_of_state(progress) : input_of_series(progress));
    options.planets.check(input_->unit);
    search_.emplace(find_planets(input_->series.get(), options.planets, input_->unit, progress));
    if (options.map.is_wanted)
        map_.emplace(empty_map(options.map, *search_, options.planets.seed));
    if (map_ && folder_)
        file_.emplace(folder_->file("map.csv"), *map_, *search_);
}

PlanetReport PlanetJob::report() const {
    PlanetReport report = {*search_, input_->series.get(), input_->reduced, {}, map_};
    if (options_.limits)
        report.limits = limits_of(*search_);
    return report;
}

void PlanetJob::write() {
    cli::write(*folder_, report());
}

void PlanetJob::finish(Progress &progress) {
    const PlanetReport report = this->report();
    progress.clear();
    report.warn(progress);
    if (folder_)
        cli::write(*folder_, report);
    if (options_.as_json)
        print_stdout(report.json().text());
    else
        report.print();
    report.refuse();
}

} // namespace cli
