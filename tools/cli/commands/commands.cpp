#include <memory>

#include "common/output.hpp"
#include "options/command.hpp"
#include "options/help.hpp"

namespace cli {

namespace {

constexpr char kDescription[] = R"(Find the period of a planet in images from the TOLIMAN space telescope.

Examples:
  # simulate, train, encode and search: the whole chain, into the folder chapter.run
  toliman run chapter.json
  # an HTML page with figures of that folder
  toliman report chapter.run
  # compare detection methods over a range of signal amplitudes
  toliman experiment chapter.json --quick --out quick
  # the period of any time series with columns t,y[,sigma]
  toliman period rv.csv
  # the steps one by one: images, frames, a trained network, one separation in pixels per frame
  toliman psf chapter.json --out psf.npy
  toliman simulate chapter.json --frames 0:100 --out frames.npy
  toliman train chapter.json --out w.tlmw
  toliman encode --weights w.tlmw frames.npy
  # process frames as they arrive from the spacecraft; show frames and period so far
  toliman track --weights w.tlmw --state mission --mission-days 1095 --dtype u16le --follow downlink/
  toliman status mission
  # one periodogram from the sums of several
  toliman merge a.tlmp b.tlmp --out c.tlmp
  # what a scene requires and what it costs; a mask with a smaller Cramer-Rao bound
  toliman plan scene.json
  toliman pupil chapter.json --out better.json
  # FITS to .npy and back
  toliman convert mask.fits mask.npy
  # is this machine fit to run toliman?
  toliman doctor

A scene is a JSON file that describes the telescope, the stars, the detector, the noise and the signal of the planet.
A frame is one image of both stars. An autoencoder reduces each frame to one number, the latent: the measured
change of the separation of the stars, in pixels. A Lomb-Scargle periodogram of the latents gives the period and its false alarm
probability (FAP).

SCENE is the path of a scene file. If there is no such file, it is the name of a shipped scene (chapter.json or
mission.json, in ../share/toliman/scenes relative to the program), and standard error states which file is used.

Data goes to standard output, everything else to standard error. A command replaces an existing output file only if
the file is empty or was written by toliman; with --force it replaces any file.

Exit codes:
  0              success
  1              internal error; a Python package is missing (report)
  2              invalid options or scene content
  3              an input file is missing or malformed
  4              finished, but samples or frames were skipped (--strict), or doctor is not ready
  5              a state folder is damaged
  6              an output cannot be written, or another process is writing to the state folder
  129, 130, 143  stopped by SIGHUP, SIGINT (Ctrl-C), SIGTERM)";

} // namespace

void add_commands(CLI::App &app, Context &context) {
    app.name("toliman");
    app.description(kDescription);
    app.set_version_flag("--version", std::string("toliman ") + toliman_version());
    app.add_option("--progress", context.progress,
                   "progress on standard error: a bar if it is a terminal (auto, default), JSON lines (json) or none")
        ->check(CLI::IsMember({"auto", "json", "none"}));
    app.require_subcommand(1);
    app.formatter(std::make_shared<HelpFormatter>());
    app.fallthrough();
    for (const auto add :
         {add_run, add_experiment, add_psf, add_simulate, add_train, add_encode, add_convert, add_period, add_merge,
          add_track, add_status, add_rebuild, add_plan, add_pupil, add_report, add_doctor})
        add(app, context);
    for (const char *name :
         {"run", "experiment", "psf", "simulate", "train", "convert", "period", "merge", "pupil", "report", "status"})
        app.get_subcommand(name)->add_flag_callback("--force", replace_anything,
                                                    "replace any existing file, not only those written by toliman");
}

std::vector<const CLI::Option *> options_of(const CLI::App &command) {
    std::vector<const CLI::Option *> options = command.get_options();
    for (const CLI::App *group : command.get_subcommands([](const CLI::App *app) { return app->get_name().empty(); }))
        for (const CLI::Option *option : options_of(*group))
            if (option != group->get_help_ptr()) // the command has its own
                options.push_back(option);
    return options;
}

void add_scene(CLI::App &command, std::string &name) {
    command.add_option("SCENE", name, "scene file (JSON, schema toliman-scene/1), or the name of a shipped scene")
        ->type_name("")
        ->required();
}

} // namespace cli
