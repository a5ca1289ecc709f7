// "Did you mean" for mistyped commands and options.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace cli {

// What to say of the first word of the command line that is no command or no option of the command:
// "unknown option --frame (did you mean --frames?)"; "" if all are known.
std::string unknown_word(const CLI::App &app, int argc, char **argv);

} // namespace cli
