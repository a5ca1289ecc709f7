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

std::pair<double, double> span_of(int32_t order, const NuisanceOptions &options, const SampleOptions &samples,
                                  int32_t time_format, int32_t time_scale) {
    if (options.span.empty())
        return {0, 0};
    if (order == 0)
        throw Failure(kExitUsage, "--span " + options.span + ": is the span of a trend: give --trend above 0");
    const size_t comma = options.span.find(',');
    if (comma == std::string::npos || options.span.find(',', comma + 1) != std::string::npos)
        throw Failure(kExitUsage, "--span " + options.span + ": must be START,END");
    const auto time = [&](const std::string &text) {
        return time_of("--span", text, samples, time_format, time_scale);
    };
    const std::pair<double, double> span = {time(options.span.substr(0, comma)), time(options.span.substr(comma + 1))};
    if (!(span.first < span.second))
        throw Failure(kExitUsage, "--span " + options.span + ": START must be before END");
    return span;
}

namespace {

void set_trend(int32_t order, const NuisanceOptions &options, const SampleOptions &samples, toliman_measure *series) {
    const toliman_measure_info info = info_of(series);
    const auto [start, end] = span_of(order, options, samples, info.time_format, info.time_scale);
    const toliman_status status = toliman_measure_set_trend(series, order, start, end);
    if (status == TOLIMAN_E_ARGUMENT)
        malformed(info.name, toliman_last_error_field() == std::string("trend")
                                 ? "all times are equal: a trend needs different times"
                                 : "--trend: " + std::string(toliman_last_error()));
    toliman::check(status);
}

void set_prior(const std::string &text, toliman_measure *series) {
    const size_t equals = text.rfind('=');
    double sigma = 0;
    const bool is_number = equals != std::string::npos && number_of(text.substr(equals + 1), sigma);
    if (!is_number || !(sigma >= kLeastPrior && sigma <= 1 / kLeastPrior))
        throw Failure(kExitUsage, "--prior " + text + ": must be NAME=S with S above 0");
    const std::string name = text.substr(0, equals);
    std::vector<std::string> names;
    for (const Function &function : functions_of(series)) {
        if (name == function.name && function.sigma > 0)
            throw Failure(kExitUsage, "--prior " + text + ": " + name + " is given twice");
        names.emplace_back(function.name);
    }
    const auto place = std::find(names.begin(), names.end(), name) - names.begin();
    if (place == static_cast<std::ptrdiff_t>(names.size()))
        throw Failure(kExitUsage, "--prior " + name + ": must be one of " + joined(names));
    toliman::check(toliman_measure_set_prior(series, place, sigma));
}

// The priors of the functions that the options give; the errors of an orbit have their own.
void set_priors(const NuisanceOptions &options, toliman_measure *series) {
    if (!options.priors.empty() && info_of(series).is_weighted == 0)
        malformed(name_of(series), "has no column sigma: --prior needs the standard deviation of each sample");
    for (const std::string &text : options.priors)
        set_prior(text, series);
}

} // namespace

CLI::Option *add_system_options(CLI::App &command, SeriesOptions &options) {
    CLI::Option *system = add_option(&command, "--system", options.system, "SYSTEM");
    options.reduction.add_to(command, system);
    command.get_option("--scale-sigma")
        ->needs(system)
        ->excludes(command.get_option("--trend"))
        ->excludes(command.get_option("--nuisance-file"));
    return system;
}

toliman::measurements read_series(const SeriesOptions &options, Progress &progress) {
    SampleOptions how = options.samples;
    how.functions = options.nuisance.file;
    return read_series(options.file, how, progress);
}

std::optional<ReductionNote> add_functions(const SeriesOptions &options, bool with_orbit, const std::string &growing,
                                           toliman::measurements &series, Progress &progress) {
    const NuisanceOptions &how = options.nuisance;
    std::optional<ReductionNote> reduced;
    if (options.system)
        reduced = reduce_to_orbit(*options.system, options.reduction, how.scale_sigma, with_orbit && !how.given(),
                                  series, progress);
    const int32_t order = how.trend.value_or(info_of(series.get()).trend);
    if (!growing.empty())
        how.need_span(order, growing);
    set_trend(order, how, options.samples, series.get());
    set_priors(how, series.get());
    return reduced;
}

} // namespace cli
