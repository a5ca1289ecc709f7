// Messages for invalid command lines, with "did you mean" for mistyped commands, options and values.
#pragma once
#include "common/common.hpp"

namespace CLI {
class App;
class ParseError;
} // namespace CLI

namespace cli {

// The message for a command line that CLI11 has refused.
std::string command_line_error(const CLI::ParseError &error, const CLI::App &app, int argc, char **argv);

// " (did you mean pca?)" with the nearest name, "" if no name is near.
std::string did_you_mean(const std::string &word, const std::vector<std::string> &names);

} // namespace cli
