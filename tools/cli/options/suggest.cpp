#include "options/suggest.hpp"

#include <algorithm>
#include <sstream>
#include <vector>

#include "options/command.hpp"

namespace cli {

namespace {

// The library has the same for keys of scenes, but shows nothing of it.
size_t distance(const std::string &a, const std::string &b) {
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); j++)
        row[j] = j;
    for (size_t i = 1; i <= a.size(); i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); j++) {
            const size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row[b.size()];
}

void add_options(const CLI::App &app, std::vector<std::string> &names) {
    for (const CLI::Option *option : options_of(app))
        for (const std::string &name : option->get_lnames())
            names.push_back("--" + name);
}

bool known(const std::string &word, const std::vector<std::string> &names) {
    return std::find(names.begin(), names.end(), word) != names.end();
}

// What CLI11 says of a value that is none of a list, "--sync: fram not in {frame,group,none}", as the rest of the
// program says it.
std::string unknown_value(const std::string &message) {
    const std::string between = " not in {";
    const size_t option = message.find(": "), end = message.rfind(between);
    if (option == std::string::npos || end == std::string::npos || end < option + 2 || message.back() != '}')
        return message;
    const std::string value = message.substr(option + 2, end - option - 2);
    const size_t first = end + between.size();
    std::vector<std::string> names;
    std::string list;
    std::stringstream words(message.substr(first, message.size() - 1 - first));
    for (std::string name; std::getline(words, name, ',');) {
        list += (names.empty() ? "" : ", ") + name;
        names.push_back(name);
    }
    return message.substr(0, option) + " " + value + ": must be one of " + list + meant(value, names);
}

// What to say of the first word of the command line that is no command or no option of the command:
// "unknown option --frame (did you mean --frames?)"; "" if all are known.
std::string unknown_word(const CLI::App &app, int argc, char **argv) {
    std::vector<std::string> commands, options;
    add_options(app, options);
    for (const CLI::App *command : app.get_subcommands([](const CLI::App *) { return true; }))
        commands.push_back(command->get_name());
    bool chosen = commands.empty(); // a program without any
    for (int i = 1; i < argc; i++) {
        const std::string word = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
        if (word == "--") // files follow
            break;
        const bool is_option = word.rfind("--", 0) == 0;
        if (is_option && !known(word, options))
            return "unknown option " + word + meant(word, options);
        if (word == "--progress" && word == argv[i])
            i++; // its value
        if (is_option || chosen)
            continue;
        if (!known(word, commands))
            return "unknown command " + word + meant(word, commands);
        add_options(*app.get_subcommand(word), options);
        chosen = true;
    }
    return "";
}

} // namespace

std::string meant(const std::string &word, const std::vector<std::string> &names) {
    size_t least = 3;
    std::string best;
    for (const std::string &name : names) {
        const size_t far = distance(word, name);
        if (far < std::min(least, name.size())) {
            least = far;
            best = name;
        }
    }
    return best.empty() ? "" : " (did you mean " + best + "?)";
}

std::string complaint(const CLI::ParseError &error, const CLI::App &app, int argc, char **argv) {
    std::string unknown = unknown_word(app, argc, argv);
    if (!unknown.empty())
        return unknown;
    const bool needs_command = app.get_subcommands().size() < app.get_require_subcommand_min();
    return needs_command ? "needs a command: toliman --help lists them" : unknown_value(error.what());
}

} // namespace cli
