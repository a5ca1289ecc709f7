#include "page.hpp"

#include <algorithm>
#include <cctype>
#include <regex>
#include <sstream>

#include "option.hpp"

namespace manual {

namespace {

// Characters that roff would take for its own.
std::string plain(const std::string &text) {
    std::string escaped;
    for (const char c : text)
        escaped += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
    return escaped;
}

std::string bold(const std::string &text) {
    return "\\fB" + plain(text) + "\\fR";
}

// A line that is no request, whatever it starts with.
std::string line(const std::string &escaped) {
    const bool request = !escaped.empty() && (escaped[0] == '.' || escaped[0] == '\'');
    return (request ? "\\&" : "") + escaped + "\n";
}

// Text in which `words` and --options are bold.
std::string marked(const std::string &text) {
    static const std::regex bolds("`([^`]*)`|--[a-z][a-z0-9-]*");
    std::string out;
    auto rest = text.begin();
    for (std::sregex_iterator found(text.begin(), text.end(), bolds), none; found != none; ++found) {
        out += plain(std::string(rest, (*found)[0].first)) + bold((*found)[(*found)[1].matched ? 1 : 0]);
        rest = (*found)[0].second;
    }
    return out + plain(std::string(rest, text.end()));
}

// The description of a command in its parts.
struct Description {
    explicit Description(const std::string &text);
    std::string summary, examples, body;
};

Description::Description(const std::string &text) {
    std::istringstream lines(text);
    std::getline(lines, summary);
    bool in_examples = false, in_table = false;
    for (std::string text_line; std::getline(lines, text_line);) {
        const bool indented = text_line.compare(0, 2, "  ") == 0;
        if (text_line == "Examples:" || text_line == "Example:")
            in_examples = true;
        else if (in_examples && indented)
            examples += line(plain(text_line.substr(2)));
        else {
            in_examples = false;
            if (indented != in_table)
                body += indented ? ".PP\n.nf\n" : ".fi\n";
            in_table = indented;
            body += text_line.empty() ? ".PP\n" : line(indented ? plain(text_line) : marked(text_line));
        }
    }
    body += in_table ? ".fi\n" : "";
}

// "toliman run", as it is typed.
std::string typed_name(const CLI::App &command) {
    return command.get_parent() == nullptr ? command.get_name() : "toliman " + command.get_name();
}

// Name and summary as whatis(1) has them: no capital, no full stop.
std::string title(const CLI::App &command, std::string summary) {
    if (summary.size() > 1 && std::islower(static_cast<unsigned char>(summary[1])) != 0)
        summary[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(summary[0])));
    if (!summary.empty() && summary.back() == '.')
        summary.pop_back();
    return plain(page_name(command)) + " \\- " + plain(summary) + "\n";
}

std::string positional(const CLI::Option &option) {
    const std::string name = "\\fI" + option.get_name(true) + "\\fR" + (option.get_expected_max() > 1 ? "..." : "");
    return option.get_required() ? name : "[" + name + "]";
}

std::string with_value(const CLI::Option &option) {
    std::string text;
    for (const std::string &name : names_of(option))
        text += (text.empty() ? "" : ", ") + bold(name);
    return takes_value(option) ? text + " \\fI" + plain(placeholder(option)) + "\\fR" : text;
}

std::string synopsis(const CLI::App &command) {
    std::string text = bold(typed_name(command)) + " [\\fIoptions\\fR]", arguments;
    for (const CLI::Option *option : options_of(command)) {
        if (option->get_positional())
            arguments += " " + positional(*option);
        else if (option->get_required())
            text += " " + with_value(*option);
    }
    return text + arguments + (commands_of(command).empty() ? "" : " \\fIcommand\\fR ...") + "\n";
}

std::string entry(const std::string &head, const std::string &text) {
    return ".TP\n" + head + "\n" + line(text);
}

std::string section(const char *name, const std::string &text) {
    return text.empty() ? "" : ".SH " + std::string(name) + "\n" + text;
}

std::string entries(const CLI::App &command, bool positionals) {
    std::string text;
    for (const CLI::Option *option : options_of(command)) {
        if (option->get_positional() != positionals)
            continue;
        text += entry(positionals ? positional(*option) : with_value(*option), marked(told(*option)));
    }
    return text;
}

std::string command_list(const CLI::App &app) {
    std::string text;
    for (const CLI::App *command : commands_of(app))
        text += entry("\\fB" + plain(page_name(*command)) + "\\fR(1)",
                      marked(Description(command->get_description()).summary));
    return text;
}

} // namespace

std::string page_name(const CLI::App &command) {
    return command.get_parent() == nullptr ? command.get_name() : "toliman-" + command.get_name();
}

std::string page(const CLI::App &command, const std::string &tail) {
    const Description description(command.get_description());
    std::string upper = page_name(command);
    std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
    return ".TH " + upper + " 1 \"\" \"libtoliman " + toliman_version() + "\" \"User Commands\"\n" +
           section("NAME", title(command, description.summary)) + section("SYNOPSIS", synopsis(command)) +
           section("DESCRIPTION", description.body) + section("COMMANDS", command_list(command)) +
           section("ARGUMENTS", entries(command, true)) + section("OPTIONS", entries(command, false)) +
           section("EXAMPLES", description.examples.empty() ? "" : ".nf\n" + description.examples + ".fi\n") + tail +
           (command.get_parent() == nullptr ? "" : section("SEE ALSO", "\\fBtoliman\\fR(1), \\fBlibtoliman\\fR(3)\n"));
}

} // namespace manual
