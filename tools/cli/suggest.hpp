// "Did you mean" for mistyped commands and options.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace cli {

// " (did you mean --frames?)" for the first word of the command line that nearly is a known name; "" if none.
std::string suggestion(const CLI::App &app, int argc, char **argv);

} // namespace cli
