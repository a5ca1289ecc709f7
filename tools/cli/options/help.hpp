// Layout of --help: examples first, one line per command in the overview, and text of at most kHelpWidth columns.
#pragma once
#include <CLI/CLI.hpp>
#include <sstream>

#include "common/common.hpp"

namespace cli {

constexpr size_t kHelpWidth = 100;

// Wraps the paragraphs of a text at the width. Indented lines, which are examples and tables, are not changed.
inline std::string wrapped(const std::string &text, size_t width) {
    std::istringstream lines(text);
    std::string out;
    size_t column = 0; // 0 between paragraphs
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == ' ') {
            out += (column > 0 ? "\n" : "") + line + "\n";
            column = 0;
            continue;
        }
        std::istringstream words(line);
        for (std::string word; words >> word; column += word.size()) {
            const bool fits = column + 1 + word.size() <= width;
            if (column > 0)
                out += fits ? ' ' : '\n';
            column = fits && column > 0 ? column + 1 : 0;
            out += word;
        }
    }
    return out;
}

class HelpFormatter : public CLI::Formatter {
  public:
    std::string make_description(const CLI::App *app) const override {
        const std::string text = wrapped(CLI::Formatter::make_description(app), kHelpWidth);
        return text.empty() ? text : text + "\n\n";
    }
    std::string make_option_desc(const CLI::Option *option) const override {
        return wrapped(CLI::Formatter::make_option_desc(option), kHelpWidth - get_column_width());
    }
    std::string make_subcommand(const CLI::App *command) const override {
        const std::string text = command->get_description();
        std::stringstream line;
        CLI::detail::format_help(line, command->get_name(),
                                 wrapped(text.substr(0, text.find('\n')), kHelpWidth - get_column_width()),
                                 get_column_width());
        return line.str();
    }
};

} // namespace cli
