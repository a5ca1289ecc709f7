#include "series/series_options.hpp"

#include <CLI/App.hpp>

#include "options/command.hpp"

namespace cli {

namespace {

constexpr double kLeastPrior = 1e-98; // standard deviation

} // namespace

void NuisanceOptions::add_to(CLI::App &command) {
    command.add_option("--trend", trend)->check(CLI::Range(0, kMostTrend));
    add_option(&command, "--span", span, "START,END");
    add_option(&command, "--nuisance-file", file, "FILE");
    CLI::Option *prior = add_option(&command, "--prior", priors, "NAME=S,...");
    prior->delimiter(',')->allow_extra_args(false);
    command.add_option("--scale-sigma", scale_sigma);
}

void NuisanceOptions::check() const {
    if (!priors.empty() && !given())
        throw Failure(kExitUsage, "--prior: needs --trend or --nuisance-file");
    if (!(scale_sigma >= 0 && scale_sigma < 1))
        throw Failure(kExitUsage, formatted("--scale-sigma %g: must be in [0, 1)", scale_sigma));
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
    const SampleOptions times = options_of_times(series, samples);
    const Trend trend = {order, time_of("--span", options.span.substr(0, comma), times, plain),
                         time_of("--span", options.span.substr(comma + 1), times, plain)};
    if (!(trend.start < trend.end))
        throw Failure(kExitUsage, "--span " + options.span + ": START must be before END");
    return trend;
}

namespace {

// Place of a function among T_1 ... and the columns.
size_t place_of(const std::string &name, const Nuisance &nuisance) {
    std::vector<std::string> names = names_of_trend(nuisance.trend.order);
    names.erase(names.begin()); // the mean
    for (const NuisanceColumn &column : nuisance.columns)
        names.push_back(column.name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
        throw Failure(kExitUsage, "--prior " + name + ": must be one of " + joined(names));
    return static_cast<size_t>(found - names.begin());
}

void set_prior(const std::string &text, Nuisance &nuisance) {
    const size_t equals = text.rfind('=');
    double sigma = 0;
    const bool is_number = equals != std::string::npos && number_of(text.substr(equals + 1), sigma);
    if (!is_number || !(sigma >= kLeastPrior && sigma <= 1 / kLeastPrior))
        throw Failure(kExitUsage, "--prior " + text + ": must be NAME=S with S above 0");
    const size_t place = place_of(text.substr(0, equals), nuisance);
    if (nuisance.precision[place] > 0)
        throw Failure(kExitUsage, "--prior " + text + ": " + text.substr(0, equals) + " is given twice");
    nuisance.precision[place] = 1 / (sigma * sigma);
}

} // namespace

void set_priors(const NuisanceOptions &options, Series &series) {
    if (options.priors.empty())
        return;
    if (series.sigma.empty())
        malformed(series.name, "has no column sigma: --prior needs the standard deviation of each sample");
    series.nuisance.precision.assign(series.nuisance.count(), 0);
    for (const std::string &text : options.priors)
        set_prior(text, series.nuisance);
}

CLI::Option *add_system_options(CLI::App &command, SeriesOptions &options) {
    CLI::Option *system = add_option(&command, "--system", options.system, "SYSTEM");
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
