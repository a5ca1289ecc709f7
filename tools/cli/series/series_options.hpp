// A series of the command line with the functions that are fitted with its mean.
#pragma once
#include <optional>
#include <string>

#include "common/terminal.hpp"
#include "series/nuisance_options.hpp"
#include "series/reduction.hpp"

namespace cli {

struct SeriesOptions {
    std::string file;
    SampleOptions samples;
    std::optional<std::string> system; // of measured separations
    ReductionOptions reduction;        // with system
    NuisanceOptions nuisance;
};

// Adds --system and the options of a reduction; returns --system. Needs the options of NuisanceOptions::add_to.
CLI::Option *add_system_options(CLI::App &command, SeriesOptions &options);

// Reduces a series, if there is a system, and gives it its functions. with_orbit: by default the functions of a reduced
// series are those of the orbit. growing: the option by which samples may follow; "" for none. Throws Failure for bad
// options.
std::optional<ReductionNote> add_functions(const SeriesOptions &options, bool with_orbit, const std::string &growing,
                                           Series &series, Progress &progress);

} // namespace cli
