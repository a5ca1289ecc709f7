// The options of commands that read a downlink: which files, and what of them.
#pragma once
#include "downlink/downlink.hpp"
#include "options/command.hpp"

namespace cli {

void add_inputs(CLI::App &command, InputOptions &input);

} // namespace cli
