#include "series/planet_search.hpp"

#include <CLI/App.hpp>

#include "options/command.hpp"
#include "scenes/observer_options.hpp"
#include "series/nuisance.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

constexpr size_t kLimitPeriods = 40;
constexpr double kMostMass = 500, kMostParallax = 770; // solar masses, mas

// The error of the library in terms of the series and of options.
[[noreturn]] void fail(const toliman::error &error, const std::string &series) {
    refuse_option(error, {{"prior.period_min", "--period-min"},
                          {"prior.period_max", "--period-max"},
                          {"threshold", "--threshold"},
                          {"detection_fap", "--fap"},
                          {"samples", "--samples"},
                          {"star_mass", "--star-masses"},
                          {"parallax_arcsec", "--parallax"}});
    if (error.field() == "series")
        throw Failure(kExitInput, message_about(series, error));
    if (error.status() == TOLIMAN_E_STATE)
        malformed(series, error.what());
    throw error;
}

// Parallax and masses that are not given are those of the system to which the series is reduced.
toliman_planet_options for_library(const PlanetOptions &options, const toliman_measure_info &series,
                                   Progress &progress) {
    auto how = with_progress<toliman_planet_options>(progress);
    how.flags = (options.no_jitter ? TOLIMAN_PLANET_NO_JITTER : 0) | (options.clip ? TOLIMAN_PLANET_CLIP : 0);
    how.max_planets = options.most;
    how.threads = options.threads;
    how.parallax_arcsec = options.parallax_mas ? *options.parallax_mas / 1000 : series.parallax_arcsec;
    std::copy(std::begin(series.star_mass), std::end(series.star_mass), how.star_mass);
    if (!options.star_masses.empty())
        how.star_mass[1] = 0;
    std::copy(options.star_masses.begin(), options.star_masses.end(), how.star_mass);
    how.prior.period_min = options.period_min.value_or(0);
    how.prior.period_max = options.period_max.value_or(0);
    how.threshold = options.threshold;
    how.detection_fap = options.fap;
    how.samples = options.samples;
    how.seed = options.seed;
    return how;
}

Instruments instruments_in(const PlanetSearch &search) {
    const auto all =
        all_of<toliman_measure_instrument>([&](toliman_measure_instrument *items, size_t capacity, size_t *count) {
            return toliman_planet_get_instruments(search.handle.get(), items, capacity, count);
        });
    return all.size() > 1 ? all : Instruments();
}

void check_positive(const char *option, double value, double most, const char *unit) {
    if (!(value > 0 && value <= most))
        throw Failure(kExitUsage, formatted("%s %g: must be in (0, %g]%s", option, value, most, unit));
}

} // namespace

void PlanetOptions::add_to(CLI::App &command) {
    command.add_option("--star-masses", star_masses)->delimiter(',')->allow_extra_args(false)->type_name("A,B");
    add_option(&command, "--velocities", velocities[0], "FILE");
    add_option(&command, "--velocities-b", velocities[1], "FILE");
    command.add_option("--velocity-trend", velocity_trend)->check(CLI::Range(0, kMostTrend));
    add_option(&command, "--parallax", parallax_mas, "MAS");
    command.add_option("--max", most)->check(CLI::Range(1u, TOLIMAN_PLANET_MOST));
    command.add_flag("--no-jitter", no_jitter);
    command.add_flag("--clip", clip);
    command.add_option("--period-min", period_min);
    command.add_option("--period-max", period_max);
    command.add_option("--threshold", threshold);
    command.add_option("--fap", fap);
    command.add_option("--samples", samples)->check(CLI::Range(100u, 1000000u));
    add_seed(command, seed);
    command.add_option("--threads", threads)->check(CLI::Range(0u, 1024u));
}

void PlanetOptions::check(const ValueUnit &unit) const {
    for (const double mass : star_masses)
        check_positive("--star-masses", mass, kMostMass, " solar masses");
    const size_t most_stars = unit.is_velocity ? 1 : 2;
    if (star_masses.size() > most_stars)
        throw Failure(kExitUsage,
                      formatted("--star-masses: has %zu numbers: must be %s", star_masses.size(),
                                unit.is_velocity ? "one, as the series has the velocities of one star" : "A,B"));
    if (parallax_mas)
        check_positive("--parallax", *parallax_mas, kMostParallax, " mas");
    for (const char *option : {"--velocities", "--velocities-b"})
        if (!velocities[option == std::string("--velocities") ? 0 : 1].empty() &&
            (unit.is_velocity || unit.factor == 0))
            throw Failure(kExitUsage, std::string(option) + ": is for separations of known unit (--unit, --system)");
    if (parallax_mas && unit.is_velocity)
        throw Failure(kExitUsage, "--parallax: is for separations, not with --unit " + unit.name);
    for (const auto &[option, value] : {std::pair("--period-min", period_min), {"--period-max", period_max}})
        if (value)
            check_positive(option, *value, 1e9, "");
    if (!(threshold > 0 && std::isfinite(threshold)))
        throw Failure(kExitUsage, formatted("--threshold %g: must be above 0 and finite", threshold));
    if (!(fap > 0 && fap < 1))
        throw Failure(kExitUsage, formatted("--fap %g: must be in (0, 1)", fap));
}

size_t PlanetSearch::fitted() const noexcept {
    const auto is_fitted = [](const toliman_planet_candidate &one) {
        return (one.reasons & TOLIMAN_PLANET_REASON_ODDS) == 0;
    };
    return static_cast<size_t>(std::count_if(candidates.begin(), candidates.end(), is_fitted));
}

std::vector<std::string> PlanetSearch::reasons(size_t index) const {
    std::vector<std::string> texts;
    for (uint32_t bit = 1; bit != 0; bit <<= 1)
        if ((candidates[index].reasons & bit) != 0)
            texts.emplace_back(toliman_constant_name(static_cast<int32_t>(bit)));
    return texts;
}

bool PlanetSearch::knows_mass(size_t star) const noexcept {
    return unit.factor > 0 && options.star_mass[star] > 0 && (unit.is_velocity || options.parallax_arcsec > 0);
}

namespace {

// A series for the search, in a unit.
toliman::measurements measured_in(const ValueUnit &unit, const toliman_measure *series) {
    auto data = toliman::sized<toliman_measure_data>();
    data.kind = unit.is_velocity ? TOLIMAN_MEASURE_VELOCITY : TOLIMAN_MEASURE_REDUCED;
    data.unit = unit.factor;
    return changed(series, data);
}

} // namespace

Velocities velocities_of(const PlanetOptions &options, Progress &progress) {
    Velocities found;
    for (size_t star = 0; star < found.size(); star++) {
        const std::string &file = options.velocities[star];
        if (file.empty())
            continue;
        const toliman::measurements series = read_series(plain(file), options.velocity_samples, progress);
        const toliman_measure_info info = info_of(series.get());
        if (info.is_weighted == 0)
            malformed(info.name, "has no column sigma: must have the standard deviation of each velocity");
        const ValueUnit unit = unit_of(info.unit_name[0] == '\0' ? "m/s" : "", series.get(), std::nullopt);
        if (!unit.is_velocity)
            malformed(info.name, std::string("y is in ") + info.unit_name + ": must be velocities");
        found[star] = measured_in(unit, series.get());
        const std::vector<double> times = values_of(series.get(), "t");
        if (std::adjacent_find(times.begin(), times.end(), std::not_equal_to<>()) != times.end())
            toliman::check(toliman_measure_set_trend(found[star].get(), options.velocity_trend, 0, 0));
    }
    return found;
}

PlanetSearch find_planets(const toliman_measure *series, const PlanetOptions &options, const ValueUnit &unit,
                          Progress &progress) {
    const toliman_measure_info info = info_of(series);
    if (info.is_weighted == 0 && options.no_jitter)
        malformed(info.name, "has no column sigma: must have one with --no-jitter");
    PlanetSearch search;
    search.unit = unit;
    search.options = for_library(options, info, progress);
    const Velocities velocities = velocities_of(options, progress);
    search.options.velocity_a = velocities[0].get();
    search.options.velocity_b = velocities[1].get();
    for (const toliman::measurements &one : velocities)
        search.velocities += one ? static_cast<size_t>(info_of(one.get()).n) : 0;
    try {
        const toliman::measurements given = measured_in(unit, series);
        search.handle = toliman::make<toliman::planet_set>(toliman_planet_create, given.get(), &search.options);
    } catch (const toliman::error &error) {
        for (size_t star = 0; star < 2; star++)
            if (error.field() == (star == 0 ? "options->velocity_a" : "options->velocity_b"))
                throw Failure(kExitInput, message_about(options.velocities[star], error));
        fail(error, info.name);
    }
    search.options.velocity_a = search.options.velocity_b = nullptr; // they end here
    search.info = toliman::result<toliman_planet_info>(toliman_planet_get_info, search.handle.get());
    const toliman_planet *const found = search.handle.get();
    search.candidates = items_of(toliman_planet_get_candidate, found, search.info.candidates);
    search.outliers.resize(search.info.outliers);
    toliman::check(toliman_planet_get_outliers(search.handle.get(), search.outliers.size(), search.outliers.data()));
    const auto of_velocities = std::lower_bound(search.outliers.begin(), search.outliers.end(), info.n);
    search.velocity_outliers = static_cast<size_t>(search.outliers.end() - of_velocities);
    search.outliers.erase(of_velocities, search.outliers.end());
    search.instruments = instruments_in(search);
    return search;
}

std::vector<toliman_planet_limit> limits_of(const PlanetSearch &search) {
    return limits_at(search, edges_between(search.info.period_min, search.info.period_max, kLimitPeriods - 1));
}

std::vector<toliman_planet_limit> limits_at(const PlanetSearch &search, const std::vector<double> &periods) {
    std::vector<toliman_planet_limit> limits(periods.size(), toliman::sized<toliman_planet_limit>());
    toliman::check(toliman_planet_get_limits(search.handle.get(), periods.data(), periods.size(), kLimitProbability,
                                             limits.data()));
    return limits;
}

std::vector<double> edges_between(double first, double last, size_t count) {
    std::vector<double> edges;
    for (size_t i = 0; i <= count; i++)
        edges.push_back(first * std::pow(last / first, static_cast<double>(i) / static_cast<double>(count)));
    edges.back() = last; // pow rounds
    return edges;
}

} // namespace cli
