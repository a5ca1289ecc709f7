// The subcommands: each adds itself with its options to the CLI11 app and stores its work in Context::action.
#pragma once
#include <CLI/App.hpp> // alone: what CLI/CLI.hpp adds is compiled once, in commands.cpp
#include <charconv>

#include "common/common.hpp"

namespace cli {

struct Context {
    std::string progress = "auto"; // --progress
    std::function<void()> action;  // the chosen command, run after parsing

    Progress::Style style() const {
        return progress == "json"   ? Progress::Style::json
               : progress == "none" ? Progress::Style::none
                                    : Progress::Style::automatic;
    }
};

// The whole program: its description, options and subcommands.
void add_commands(CLI::App &app, Context &context);
// help/COMMAND.txt without its last newline; help/toliman.txt is that of the whole program.
std::string help_text(const std::string &command);
// A subcommand with its help text.
CLI::App *add_command(CLI::App &app, const std::string &name);
// Gives the options their texts of help/options.txt; `name` is that of the command.
void describe(CLI::App &command, const std::string &name);

// An option whose value is one of the names, which are a list or the keys of a map.
template <class Names = std::vector<std::string>>
CLI::Option *add_choice(CLI::App *command, const char *name, std::string &value, const Names &names) {
    return command->add_option(name, value)->check(CLI::IsMember(names));
}

// Throws Failure for a number among the options given that is not finite: CLI::Range lets NaN pass.
void check_finite(const CLI::App &command);

// Runs the work of a command, then warns of expired leap seconds, also if it was stopped or rejected its results.
void run_work(const CLI::App &command, Progress &progress, const std::function<void()> &work);

// Stores work(*options, progress) as the action of a command; `check` is called after parsing and may throw.
template <class Options, class Work>
void set_action(
    CLI::App &command, Context &context, const std::shared_ptr<Options> &options, Work work,
    const std::function<void()> &check = [] {}) {
    command.callback([&command, &context, options, work, check] {
        check_finite(command);
        check();
        context.action = [&command, &context, options, work] {
            Progress progress(context.style());
            run_work(command, progress, [&] { work(*options, progress); });
        };
    });
}

// An option or positional (whose `type` is empty) that shows `type` as its value in --help.
template <class Value> CLI::Option *add_option(CLI::App *command, const char *name, Value &value, const char *type) {
    return command->add_option(name, value)->type_name(type);
}

// The positional SCENE of many commands.
void add_scene(CLI::App &command, std::string &name);

// --bad-pixels, the path of a file.
void add_bad_pixels(CLI::App &command, std::string &path);

// The positional SYSTEM.
void add_system(CLI::App &command, std::string &name);

// --seed: a whole number of 64 bits without sign. Parsed here because CLI11 wraps -1 around and clips numbers that are
// too large.
template <class Seed> CLI::Option *add_seed(CLI::App &command, Seed &seed) {
    const auto take = [&seed](const std::string &text) {
        uint64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || end != text.data() + text.size())
            throw CLI::ValidationError("--seed", text + ": must be a whole number from 0 to 18446744073709551615");
        seed = value;
    };
    return command.add_option_function<std::string>("--seed", take)->type_name("UINT");
}

// The subcommands.
using AddCommand = void(CLI::App &app, Context &context);
AddCommand add_run, add_psf, add_simulate, add_coadd, add_calibrate, add_train, add_encode, add_convert, add_period,
    add_planet, add_merge, add_track, add_status, add_night, add_rebuild, add_plan, add_budget, add_predict, add_refit,
    add_pupil, add_report, add_doctor;

} // namespace cli
