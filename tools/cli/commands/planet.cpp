// toliman planet: the planets of a series, and those that it excludes.
#include "downlink/planet_job.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

// With a folder, a stopped map is resumed from its file.
void fill_map(PlanetJob &job, Progress &progress) {
    const char *const stopped =
        job.map_file() != nullptr ? "stopped by a signal; the same command resumes the map" : "stopped by a signal";
    try {
        const StopLimit limit(stopped);
        fill(*job.map(), job.search(), job.map_file(), progress);
    } catch (...) {
        if (stop_signal() == 0)
            throw;
        progress.clear();
        throw Failure(stop_code(), stopped);
    }
}

void planet(PlanetJobOptions &options, Progress &progress) {
    PlanetJob job(options, true, progress);
    if (job.map() != nullptr)
        fill_map(job, progress);
    job.finish(progress);
}

} // namespace

void add_planet(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "planet");
    auto options = std::make_shared<PlanetJobOptions>();
    options->add_to(*command);
    set_action(*command, context, options, planet, [command, options] { options->see(*command); });
}

} // namespace cli
