// A page of the manual, in the language of man(7).
#pragma once
#include "options/command.hpp"

namespace manual {

// The page of a command, or of the whole program; `tail` is what stands behind it, in the same language.
std::string page(const CLI::App &command, const std::string &tail);
// "toliman-run", "toliman".
std::string page_name(const CLI::App &command);

} // namespace manual
