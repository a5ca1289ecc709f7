// An option of the program as manual and completion tell it.
#pragma once
#include <string>
#include <vector>

#include "options/command.hpp"

namespace manual {

using cli::options_of;

// "--out", "-h"; none of a positional.
std::vector<std::string> names_of(const CLI::Option &option);
bool takes_value(const CLI::Option &option);
// Several values with commas between them.
bool takes_list(const CLI::Option &option);
// The values it takes if they are few and named: {"tied", "unsupervised"}.
std::vector<std::string> fixed_values(const CLI::Option &option);
// "TEXT", or the fixed values with bars between them.
std::string placeholder(const CLI::Option &option);
// The description, and limits that it does not say: "list so many peaks. From 1 to 64. Not with --follow."
std::string told(const CLI::Option &option);

std::vector<const CLI::App *> commands_of(const CLI::App &app);
std::string joined(const std::vector<std::string> &words, const char *between);

} // namespace manual
