#include "experiment/controls.hpp"

#include <CLI/Validators.hpp>
#include <map>

namespace cli {

namespace {

const std::map<std::string, Controls> kControls = {
    {"none", Controls::none}, {"quick", Controls::quick}, {"full", Controls::full}};

} // namespace

const char *name_of(Controls controls) noexcept {
    return controls == Controls::none ? "none" : controls == Controls::quick ? "quick" : "full";
}

void add_controls(CLI::App &command, Controls &controls, const std::string &description) {
    const auto set = [&controls](const std::string &word) { controls = kControls.at(word); };
    command.add_option_function<std::string>("--controls", set, description)->check(CLI::IsMember(kControls));
}

} // namespace cli
