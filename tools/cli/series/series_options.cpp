#include "series/series_options.hpp"

#include <CLI/App.hpp>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "options/command.hpp"
#include "series/nuisance_file.hpp"

namespace cli {

CLI::Option *add_system_options(CLI::App &command, SeriesOptions &options) {
    CLI::Option *system = add_option(&command, "--system", options.system, "SYSTEM",
                                     "reduce measured separations to the orbit of this binary: alpha-cen, or a system "
                                     "file");
    options.reduction.add_to(command, system);
    command.get_option("--scale-sigma")
        ->needs(system)
        ->excludes(command.get_option("--trend"))
        ->excludes(command.get_option("--nuisance-file"));
    return system;
}

std::optional<ReductionNote> add_functions(const SeriesOptions &options, bool with_orbit, const std::string &growing,
                                           Series &series, Progress &progress) {
    const NuisanceOptions &how = options.nuisance;
    series.nuisance.trend.order = how.trend.value_or(0);
    if (!how.file.empty())
        for (NuisanceColumn &column : read_columns(how.file, series, options.samples))
            series.nuisance.columns.push_back(std::move(column));
    if (series.nuisance.count() > kMostFunctions)
        malformed(series.name, formatted("%zu columns of functions and offsets: at most %zu with --trend %d",
                                         series.nuisance.columns.size(),
                                         kMostFunctions - static_cast<size_t>(series.nuisance.trend.order),
                                         series.nuisance.trend.order));
    std::optional<ReductionNote> reduced;
    if (options.system)
        reduced = reduce_to_orbit(*options.system, options.reduction, how.scale_sigma, with_orbit && !how.given(),
                                  series, progress);
    if (!growing.empty())
        how.need_span(series.nuisance.trend.order, growing);
    series.nuisance.trend = trend_of(series.nuisance.trend.order, how, options.samples, series);
    set_priors(how, series);
    return reduced;
}

} // namespace cli
