// "Did you mean" for mistyped commands, options and values.
#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
} // namespace CLI

namespace cli {

// What to say of a command line that was refused.
std::string complaint(const CLI::ParseError &error, const CLI::App &app, int argc, char **argv);

// " (did you mean pca?)" for the nearest name, "" if none is near.
std::string meant(const std::string &word, const std::vector<std::string> &names);

} // namespace cli
