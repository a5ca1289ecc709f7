#include "run/outcome.hpp"

#include <CLI/Validators.hpp>

namespace cli {

namespace {

const std::vector<std::string> kNames = {"none", "quick", "full"}; // in the order of Controls

} // namespace

std::string name_of(Controls controls) {
    return kNames[static_cast<size_t>(controls)];
}

void add_controls(CLI::App &command, Controls &controls, const std::string &description) {
    const auto set = [&controls](const std::string &word) {
        controls = static_cast<Controls>(std::find(kNames.begin(), kNames.end(), word) - kNames.begin());
    };
    command.add_option_function<std::string>("--controls", set, description)->check(CLI::IsMember(kNames));
}

} // namespace cli
