// Layout of --help: examples first, and one line a command in the overview.
#pragma once
#include <CLI/CLI.hpp>

namespace cli {

class HelpFormatter : public CLI::Formatter {
  public:
    std::string make_subcommand(const CLI::App *command) const override {
        const std::string text = command->get_description();
        std::stringstream line;
        CLI::detail::format_help(line, command->get_name(), text.substr(0, text.find('\n')), get_column_width());
        return line.str();
    }
};

} // namespace cli
