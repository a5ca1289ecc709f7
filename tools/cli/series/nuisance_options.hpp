// --trend and --span of period.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "series/nuisance.hpp"
#include "series/series.hpp"

namespace CLI {
class App;
}

namespace cli {

struct NuisanceOptions {
    std::optional<int32_t> trend;
    std::string span; // "START,END"

    void add_to(CLI::App &command);
    // Later samples may follow those at hand, by `why`: throws Failure if a trend has no span.
    void need_span(int32_t order, const std::string &why) const;
};

// A trend over --span, or over the times of the series. samples: how the times of the series were read.
Trend trend_of(int32_t order, const NuisanceOptions &options, const SampleOptions &samples, const Series &series);

} // namespace cli
