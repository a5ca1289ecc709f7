// A series of the command line with the functions that are fitted with its mean: --trend, --span, --nuisance-file,
// --prior, --scale-sigma and --system.
#pragma once
#include "series/nuisance.hpp"
#include "series/reduction.hpp"
#include "series/series.hpp"

namespace cli {

// --trend, --span, --nuisance-file, --prior and --scale-sigma.
struct NuisanceOptions {
    std::optional<int32_t> trend;
    std::string span; // "START,END"
    std::string file;
    std::vector<std::string> priors; // "NAME=S"
    double scale_sigma = 0;

    void add_to(CLI::App &command);
    bool given() const { return trend || !file.empty(); } // which replaces the default
    // Throws Failure for options that need others.
    void check() const;
    // Later samples may follow those at hand, by `why`: throws Failure if a trend has no span.
    void need_span(int32_t order, const std::string &why) const;
};

// The names of these options.
inline constexpr const char *kNuisanceOptions[] = {"--trend", "--span", "--nuisance-file", "--prior", "--scale-sigma"};

// A trend over --span, or over the times of the series. samples: how the times of the series were read.
Trend trend_of(int32_t order, const NuisanceOptions &options, const SampleOptions &samples, const Series &series);

// Gives the functions of the series the priors of --prior.
void set_priors(const NuisanceOptions &options, Series &series);

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

// CSV: the first line has the names t,NAME,...; a row for each sample of the series, with its time, in the same order.
// samples: how the times of the series were read. Throws Failure, with file and line, for anything else.
std::vector<NuisanceColumn> read_columns(const std::string &path, const Series &series, const SampleOptions &samples);

} // namespace cli
