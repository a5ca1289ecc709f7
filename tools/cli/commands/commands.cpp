#include <sstream>

#include "options/command.hpp"
#include "options/help.hpp"
#include "scenes/leap_seconds.hpp"

namespace cli {

void add_commands(CLI::App &app, Context &context) {
    app.name("toliman");
    app.description(help_text("toliman"));
    app.set_version_flag("--version", std::string("toliman ") + toliman_version());
    app.add_option("--progress", context.progress)->check(CLI::IsMember({"auto", "json", "none"}));
    app.require_subcommand(1);
    app.formatter(std::make_shared<HelpFormatter>());
    app.fallthrough();
    for (const auto add :
         {add_run,    add_psf,     add_simulate, add_coadd, add_calibrate, add_train, add_encode,  add_convert,
          add_period, add_planet,  add_merge,    add_track, add_status,    add_night, add_rebuild, add_plan,
          add_budget, add_predict, add_refit,    add_pupil, add_report,    add_doctor})
        add(app, context);
    for (const char *name : {"run", "psf", "simulate", "calibrate", "train", "convert", "period", "planet", "merge",
                             "pupil", "refit", "report", "status"})
        app.get_subcommand(name)->add_flag_callback("--force", replace_anything);
    for (CLI::App *command : app.get_subcommands([](const CLI::App *) { return true; }))
        describe(*command, command->get_name());
}

std::string help_text(const std::string &command) {
    static const std::map<std::string, std::string> texts = {
#include "help_texts.inc" // generated from help/*.txt
    };
    const std::string &text = texts.at(command);
    return text.substr(0, text.size() - 1);
}

// The texts of help/options.txt: "--name", or "command --name" where a command has another one.
std::map<std::string, std::string> option_texts() {
    std::istringstream lines(help_text("options"));
    std::map<std::string, std::string> texts;
    std::vector<std::string> keys;
    for (std::string line; std::getline(lines, line);) {
        const size_t start = line.find_first_not_of(' ');
        if (start == 0) {
            keys = CLI::detail::split(line, ' ');
            const std::string option = keys.back();
            if (keys.size() > 1)
                keys.pop_back();
            for (std::string &key : keys)
                key = key == option ? option : key + " " + option;
            continue;
        }
        for (const std::string &key : keys)
            texts[key] += (texts[key].empty() ? "" : " ") + line.substr(start);
    }
    return texts;
}

void describe(CLI::App &command, const std::string &name) {
    static const std::map<std::string, std::string> texts = option_texts();
    for (CLI::Option *option : command.get_options()) {
        if (!option->get_description().empty())
            continue;
        const auto own = texts.find(name + " " + option->get_name());
        option->description(own != texts.end() ? own->second : texts.at(option->get_name()));
    }
}

CLI::App *add_command(CLI::App &app, const std::string &name) {
    return app.add_subcommand(name, help_text(name));
}

void check_finite(const CLI::App &command) {
    for (const CLI::Option *option : command.get_options())
        for (const std::string &text : option->results()) {
            double number = 0;
            if (option->get_type_name().rfind("FLOAT", 0) == 0 && number_of(text, number) && !std::isfinite(number))
                throw Failure(kExitUsage, option->get_name() + " " + text + ": must be a finite number");
        }
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
    add_option(&command, "SYSTEM", name, "")->required();
}

void add_bad_pixels(CLI::App &command, std::string &path) {
    add_option(&command, "--bad-pixels", path, "FILE");
}

void add_scene(CLI::App &command, std::string &name) {
    command.add_option("SCENE", name)->type_name("")->required();
}

} // namespace cli
