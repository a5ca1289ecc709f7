// Durations and names of sessions on the command line.
#pragma once
#include <string>

namespace cli {

// "90", "90s", "10min", "1h" or "1d" in s; 0 for "". Throws Failure, which names the option, for others.
double seconds_of(const char *option, const std::string &text);

// For CLI::Validator: why the name of a session or region is not possible; "" if it is.
std::string session_complaint(const std::string &name);

} // namespace cli
