#include <map>
#include <memory>

#include <toliman/toliman.hpp>

#include "common/failure.hpp"
#include "common/output.hpp"
#include "options/command.hpp"
#include "options/help.hpp"
#include "scenes/leap_seconds.hpp"

namespace cli {

void add_commands(CLI::App &app, Context &context) {
    app.name("toliman");
    app.description(help_text("toliman"));
    app.set_version_flag("--version", std::string("toliman ") + toliman_version());
    app.add_option(
           "--progress", context.progress,
           "progress on standard error: auto (default), a bar on a terminal, otherwise a message after every 10 s of a "
           "stage; json, JSON lines; or none")
        ->check(CLI::IsMember({"auto", "json", "none"}));
    app.require_subcommand(1);
    app.formatter(std::make_shared<HelpFormatter>());
    app.fallthrough();
    for (const auto add : {add_run,     add_psf,    add_simulate, add_coadd, add_calibrate, add_train,  add_encode,
                           add_convert, add_period, add_planet,   add_merge, add_track,     add_status, add_rebuild,
                           add_plan,    add_budget, add_predict,  add_refit, add_pupil,     add_report, add_doctor})
        add(app, context);
    for (const char *name : {"run", "psf", "simulate", "calibrate", "train", "convert", "period", "planet", "merge",
                             "pupil", "refit", "report", "status"})
        app.get_subcommand(name)->add_flag_callback("--force", replace_anything,
                                                    "replace any existing file, not only those written by toliman");
}

std::string help_text(const std::string &command) {
    static const std::map<std::string, std::string> texts = {
#include "help_texts.inc" // generated from help/*.txt
    };
    const std::string &text = texts.at(command);
    return text.substr(0, text.size() - 1);
}

CLI::App *add_command(CLI::App &app, const std::string &name) {
    return app.add_subcommand(name, help_text(name));
}

void run_work(const CLI::App &command, Progress &progress, const std::function<void()> &work) {
    try {
        work();
    } catch (const Failure &failure) { // results may have been printed before
        if (failure.code() != kExitUsage && failure.code() != kExitInput)
            warn_of_expiry(command, progress);
        throw;
    }
    warn_of_expiry(command, progress);
}

void add_system(CLI::App &command, std::string &name) {
    add_option(&command, "SYSTEM", name, "",
               "alpha-cen (Akeson et al. 2021), or a system file (JSON, schema toliman-system/1)")
        ->required();
}

void add_bad_pixels(CLI::App &command, std::string &path) {
    add_option(
        &command, "--bad-pixels", path, "FILE",
        "pixels that are not used, instead of those of the scene's detector.bad_pixels: .npy of the frames' shape, 0 "
        "for a good pixel");
}

void add_scene(CLI::App &command, std::string &name) {
    command.add_option("SCENE", name, "scene file (JSON, schema toliman-scene/1), or the name of a shipped scene")
        ->type_name("")
        ->required();
}

} // namespace cli
