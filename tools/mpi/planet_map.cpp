// Method: a cell depends on the series, the cell and its seed alone, so that the map has the same numbers for any
// number of ranks. Cells are computed in groups; after each one the first rank appends its cells to map.csv, from where
// a stopped job resumes.
#include "planet_map.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <sstream>

#include "common/output.hpp"
#include "downlink/planet_job.hpp"
#include "options/command.hpp"
#include "options/help.hpp"
#include "options/suggest.hpp"

namespace mpi {

namespace {

using namespace cli;

constexpr int64_t kGroup = 8; // cells of each rank

std::string parse(int argc, char **argv, PlanetJobOptions &options) {
    CLI::App app(help_text("planet"), "toliman-mpi planet");
    app.formatter(std::make_shared<HelpFormatter>());
    options.add_to(app);
    describe(app, "planet");
    try {
        app.parse(argc - 1, argv + 1);
    } catch (const CLI::Success &success) {
        std::ostringstream text;
        app.exit(success, text);
        return text.str();
    } catch (const CLI::ParseError &error) {
        throw Failure(kExitUsage, command_line_error(error, app, argc - 1, argv + 1));
    }
    options.see(app);
    options.planets.threads = 1;
    return "";
}

void fill_map(const Ranks &ranks, PlanetJob &job) {
    DetectionMap &map = *job.map();
    MapFile *const file = job.map_file(); // of the first rank
    const auto all = static_cast<int64_t>(map.detected.size());
    int64_t known = 0;
    if (file != nullptr)
        for (const uint32_t detected : file->detected())
            map.detected[static_cast<size_t>(known++)] = detected;
    known = ranks.of_first(known);
    while (known < all) {
        const int64_t count = std::min(kGroup * ranks.size(), all - known);
        std::vector<uint32_t> detected(static_cast<size_t>(count));
        ranks.together([&] {
            for (int64_t k = ranks.share_begin(count); k < ranks.share_end(count); k++) {
                const toliman_planet_cell cell = map.cell(static_cast<size_t>(known + k));
                toliman::check(
                    toliman_planet_inject(job.search().handle.get(), &cell, &detected[static_cast<size_t>(k)]));
            }
        });
        ranks.add(detected);
        ranks.together([&] {
            for (const uint32_t value : detected) {
                map.detected[static_cast<size_t>(known++)] = value;
                if (file != nullptr)
                    file->add(value);
            }
        });
    }
}

} // namespace

bool is_planet(int argc, char **argv) {
    return argc > 1 && std::strcmp(argv[1], "planet") == 0;
}

std::string planet_help(int argc, char **argv) {
    PlanetJobOptions options;
    return parse(argc, argv, options);
}

void run_planet(const Ranks &ranks, int argc, char **argv) {
    PlanetJobOptions options;
    Progress progress(Progress::Style::none);
    std::optional<PlanetJob> job;
    ranks.together([&] {
        const std::string text = parse(argc, argv, options);
        if (text.empty())
            job.emplace(options, ranks.first(), progress);
        else if (ranks.first())
            print_stdout(text);
    });
    if (!job)
        return;
    if (job->map() != nullptr)
        fill_map(ranks, *job);
    ranks.together([&] {
        if (ranks.first())
            job->finish(progress);
    });
}

} // namespace mpi
