#include "series/nuisance_options.hpp"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "options/command.hpp"

namespace cli {

void NuisanceOptions::add_to(CLI::App &command) {
    command
        .add_option("--trend", trend,
                    "order of a polynomial in time that is fitted with the mean at each frequency, 0 to 8; default 0")
        ->check(CLI::Range(0, static_cast<int>(kMostFunctions)));
    add_option(&command, "--span", span, "START,END",
               "times between which the trend is defined; default: those of the samples; needed if samples may follow "
               "(--save-state, --follow)");
}

void NuisanceOptions::need_span(int32_t order, const std::string &why) const {
    if (order > 0 && span.empty())
        throw Failure(kExitUsage, formatted("--trend %d: ", order) + why +
                                      " needs --span START,END, the times of the first and the last sample that may "
                                      "follow");
}

Trend trend_of(int32_t order, const NuisanceOptions &options, const SampleOptions &samples, const Series &series) {
    if (order == 0 && options.span.empty())
        return {};
    if (order == 0)
        throw Failure(kExitUsage, "--span " + options.span + ": is the span of a trend: give --trend above 0");
    if (options.span.empty()) {
        const auto [first, last] = std::minmax_element(series.t.begin(), series.t.end());
        if (!(*first < *last))
            malformed(series.name, "all times are equal: a trend needs different times");
        return {order, *first, *last};
    }
    const size_t comma = options.span.find(',');
    if (comma == std::string::npos || options.span.find(',', comma + 1) != std::string::npos)
        throw Failure(kExitUsage, "--span " + options.span + ": must be START,END");
    const bool plain = series.time_scale.empty();
    const Trend trend = {order, time_of("--span", options.span.substr(0, comma), samples, plain),
                         time_of("--span", options.span.substr(comma + 1), samples, plain)};
    if (!(trend.start < trend.end))
        throw Failure(kExitUsage, "--span " + options.span + ": START must be before END");
    return trend;
}

} // namespace cli
