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

// Start and end of --span, for a series with such times, which were read by `samples`; both 0 without it, for those of
// the series. Throws Failure for a span without a trend.
std::pair<double, double> span_of(int32_t order, const NuisanceOptions &options, const SampleOptions &samples,
                                  int32_t time_format, int32_t time_scale);

struct SeriesOptions {
    std::string file;
    SampleOptions samples;
    std::optional<std::string> system; // of measured separations
    ReductionOptions reduction;        // with system
    NuisanceOptions nuisance;
};

// Adds --system and the options of a reduction; returns --system. Needs the options of NuisanceOptions::add_to.
CLI::Option *add_system_options(CLI::App &command, SeriesOptions &options);

// The series with the columns of --nuisance-file.
toliman::measurements read_series(const SeriesOptions &options, Progress &progress);

// Reduces a series, if there is a system, and gives it its functions. with_orbit: by default the functions of a reduced
// series are those of the orbit. growing: the option by which samples may follow; "" for none. Throws Failure for bad
// options.
std::optional<ReductionNote> add_functions(const SeriesOptions &options, bool with_orbit, const std::string &growing,
                                           toliman::measurements &series, Progress &progress);

} // namespace cli
