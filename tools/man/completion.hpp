// Completion of the command line by bash.
#pragma once
#include "options/command.hpp"

namespace manual {

// A script that completes subcommands, options and their fixed values; where none are left, files.
std::string completion(const CLI::App &app);

} // namespace manual
