// The option --controls of `run`: how much is computed of frames without signal.
#pragma once
#include <string>

#include <CLI/App.hpp>

namespace cli {

enum class Controls { none, quick, full };

std::string name_of(Controls controls);
void add_controls(CLI::App &command, Controls &controls, const std::string &description);

} // namespace cli
