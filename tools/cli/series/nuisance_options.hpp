// --trend, --span, --nuisance-file, --prior and --scale-sigma of period.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "series/nuisance.hpp"
#include "series/series.hpp"

namespace CLI {
class App;
}

namespace cli {

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

} // namespace cli
