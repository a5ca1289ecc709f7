#include <memory>

#include "common/output.hpp"
#include "options/command.hpp"
#include "options/help.hpp"

namespace cli {

namespace {

constexpr char kDescription[] = R"(Period of a planet from frames of the TOLIMAN space telescope.

Examples:
  toliman run chapter.json                    simulate, train, encode fresh noise, find the period
  toliman experiment chapter.json --out table  which method finds which amplitude
  toliman period rv.csv                       period of a series t,y[,sigma]
  toliman track --weights w.tlmw --state mission --mission-days 1095 --dtype u16le --follow downlink/
  toliman status mission                      frames and period of a state folder
  toliman merge a.tlmp b.tlmp --out c.tlmp    sums of several periodograms, or state folders, in one
  toliman psf chapter.json --out psf.npy      the expected image
  toliman train chapter.json --out w.tlmw     weights for `encode`
  toliman simulate chapter.json --frames 0:100 --out frames.npy
  toliman encode --weights w.tlmw frames.npy  one separation in pixels a frame, as CSV
  toliman convert mask.fits mask.npy          FITS to .npy and back
  toliman plan scene.json                     what a scene needs and what it costs
  toliman pupil chapter.json --out better.json  search a mask that tells more
  toliman report chapter.run                  a page of what these left, or `make bench`
  toliman doctor                              what this machine offers

A scene is a file or, where there is none of that name, one of those shipped: chapter.json, mission.json (in
share/toliman/scenes beside the folder of the program; which one is told on stderr).
Data goes to stdout, everything else to stderr. An output replaces an empty file and a file that toliman wrote, any
other file with --force alone. Exit codes: 0 ok, 1 internal or no gnuplot, 2 options or scene content, 3 an input file
missing or malformed, 4 finished but samples or frames skipped (--strict) or doctor not ready, 5 state folder damaged,
6 output cannot be written or another process writes to the folder, 129/130/143 stopped by SIGHUP, SIGINT, SIGTERM.)";

// Of commands that write files which may be there already.
void add_force(CLI::App &app) {
    for (const char *name :
         {"run", "experiment", "psf", "simulate", "train", "convert", "period", "merge", "pupil", "report"})
        app.get_subcommand(name)->add_flag_callback("--force", replace_anything,
                                                    "also replace files that are not recognised as written by toliman");
}

} // namespace

void add_commands(CLI::App &app, Context &context) {
    app.name("toliman");
    app.description(kDescription);
    app.set_version_flag("--version", std::string("toliman ") + toliman_version());
    app.add_option("--progress", context.progress, "bar on a terminal (auto), JSON lines (json) or nothing (none)")
        ->check(CLI::IsMember({"auto", "json", "none"}));
    app.require_subcommand(1);
    app.formatter(std::make_shared<HelpFormatter>());
    app.fallthrough();
    add_run(app, context);
    add_experiment(app, context);
    add_psf(app, context);
    add_simulate(app, context);
    add_train(app, context);
    add_encode(app, context);
    add_convert(app, context);
    add_period(app, context);
    add_merge(app, context);
    add_track(app, context);
    add_status(app, context);
    add_rebuild(app, context);
    add_plan(app, context);
    add_pupil(app, context);
    add_report(app, context);
    add_doctor(app, context);
    add_force(app);
}

std::vector<const CLI::Option *> options_of(const CLI::App &command) {
    std::vector<const CLI::Option *> options = command.get_options();
    for (const CLI::App *group : command.get_subcommands([](const CLI::App *app) { return app->get_name().empty(); }))
        for (const CLI::Option *option : options_of(*group))
            if (option != group->get_help_ptr()) // which the command has
                options.push_back(option);
    return options;
}

void add_scene(CLI::App &command, std::string &name) {
    command.add_option("SCENE", name, "scene file (JSON, schema toliman-scene/1), or the name of a shipped one")
        ->required();
}

} // namespace cli
