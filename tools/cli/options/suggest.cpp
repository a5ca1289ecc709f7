// Method: messages of CLI11 are parsed and rewritten in the form of all others, "--option value: must be RANGE", since
// CLI11 offers no other hook.
#include "options/suggest.hpp"

#include <cstdlib>

#include "base/nearest_word.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

void add_options(const CLI::App &app, std::vector<std::string> &names) {
    for (const CLI::Option *option : app.get_options())
        for (const std::string &name : option->get_lnames())
            names.push_back("--" + name);
}

bool known(const std::string &word, const std::vector<std::string> &names) {
    return std::find(names.begin(), names.end(), word) != names.end();
}

// The texts before, between and after the marks, which the message has in this order, each at its first place; empty if
// it lacks one.
std::vector<std::string> parts_of(const std::string &message, const std::vector<std::string> &marks) {
    std::vector<std::string> parts;
    size_t start = 0;
    for (const std::string &mark : marks) {
        const size_t end = message.find(mark, start);
        if (end == std::string::npos)
            return {};
        parts.push_back(message.substr(start, end - start));
        start = end + mark.size();
    }
    parts.push_back(message.substr(start));
    return parts;
}

// What an option accepts, by CLI11's type name FLOAT, UINT or INT.
const char *allowed(const CLI::App &command, const std::string &name) {
    const CLI::Option *option = command.get_option_no_throw(name);
    const std::string type = option != nullptr ? option->get_type_name() : "";
    return type.rfind("FLOAT", 0) == 0  ? "must be a number"
           : type.rfind("UINT", 0) == 0 ? "must be a whole number, 0 or more"
           : type.rfind("INT", 0) == 0  ? "must be a whole number"
                                        : "has an invalid form";
}

// "Could not convert: --f0 = abc"
std::string unreadable_value(const std::string &message, const CLI::App &command) {
    const std::vector<std::string> parts = parts_of(message, {": ", " = "});
    return parts.empty() ? message : parts[1] + " " + parts[2] + ": " + allowed(command, parts[1]);
}

// "--sync: fram not in {frame,group,none}", "--peaks: Value 0 not in range 1 to 64", or "[1 - 64]" since CLI11 2.4
std::string refused_value(const std::string &message) {
    std::vector<std::string> parts = parts_of(message, {": ", " not in {", "}"});
    if (!parts.empty()) {
        const std::vector<std::string> names = CLI::detail::split(parts[2], ',');
        return parts[0] + " " + parts[1] + ": must be one of " + joined(names) + did_you_mean(parts[1], names);
    }
    parts = parts_of(message, {": Value ", " not in range [", " - ", "]"});
    if (parts.empty())
        parts = parts_of(message, {": Value ", " not in range ", " to "});
    if (parts.empty())
        return message;
    const auto number = [](const std::string &text) { // without trailing zeros, as in 4.000000
        return formatted("%.10g", std::strtod(text.c_str(), nullptr));
    };
    return parts[0] + " " + parts[1] + ": must be in [" + number(parts[2]) + ", " + number(parts[3]) + "]";
}

// "The following arguments were not expected: b a", the last one first.
std::string unexpected_word(const std::string &message, const CLI::App &command) {
    const bool several = message.find(" arguments were ") != std::string::npos;
    const std::string word = message.substr(several ? message.find_last_of(' ') + 1 : message.find(": ") + 2);
    if (word.rfind('-', 0) == 0)
        return "unknown option " + word;
    std::string accepted;
    for (const CLI::Option *option : command.get_options())
        if (option->get_positional())
            accepted += (accepted.empty() ? "one " : " and one ") + option->get_single_name();
    const std::string program = command.get_parent() != nullptr ? "toliman " : "";
    return "unexpected argument " + word + ": " + program + command.get_name() + " takes " +
           (accepted.empty() ? "options only" : accepted);
}

// CLI11's message in the form of this program's messages.
std::string message_of(const CLI::ParseError &error, const CLI::App &command) {
    std::string message = error.what();
    switch (static_cast<CLI::ExitCodes>(error.get_exit_code())) {
    case CLI::ExitCodes::ConversionError:
        return unreadable_value(message, command);
    case CLI::ExitCodes::ValidationError:
        return refused_value(message);
    case CLI::ExitCodes::ExtrasError:
        return unexpected_word(message, command);
    case CLI::ExitCodes::ArgumentMismatch:
        return message.substr(0, message.find(": ")) +
               (message.find("missing") != std::string::npos ? ": needs a value" : ": must be given once");
    default:
        return message;
    }
}

// The message for the first word of the command line that is not a command, or not an option of the command:
// "unknown option --frame (did you mean --frames?)". "" if all are known.
std::string unknown_word(const CLI::App &app, int argc, char **argv) {
    std::vector<std::string> commands, options;
    add_options(app, options);
    for (const CLI::App *command : app.get_subcommands([](const CLI::App *) { return true; }))
        commands.push_back(command->get_name());
    bool chosen = commands.empty(); // toliman-mpi has no commands
    for (int i = 1; i < argc; i++) {
        const std::string word = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
        if (word == "--") // files follow
            break;
        const bool is_option = word.rfind("--", 0) == 0;
        if (is_option && !known(word, options))
            return "unknown option " + word + did_you_mean(word, options);
        if (word == "--progress" && word == argv[i])
            i++; // its value
        if (is_option || chosen)
            continue;
        if (!known(word, commands))
            return "unknown command " + word + did_you_mean(word, commands);
        add_options(*app.get_subcommand(word), options);
        chosen = true;
    }
    return "";
}

} // namespace

std::string did_you_mean(const std::string &word, const std::vector<std::string> &names) {
    const std::string nearest = toliman::nearest_word(word, names);
    return nearest.empty() ? "" : " (did you mean " + nearest + "?)";
}

std::string command_line_error(const CLI::ParseError &error, const CLI::App &app, int argc, char **argv) {
    std::string unknown = unknown_word(app, argc, argv);
    if (!unknown.empty())
        return unknown;
    const bool needs_command = app.get_subcommands().size() < app.get_require_subcommand_min();
    if (needs_command)
        return "a command is required: toliman --help lists them";
    const std::vector<CLI::App *> chosen = app.get_subcommands();
    return message_of(error, chosen.empty() ? app : *chosen.back());
}

} // namespace cli
