// Planets of a series: options of the command line, search, limits.
#pragma once
#include <array>

#include "series/goodness.hpp"
#include "series/reduction.hpp"
#include "series/series.hpp"

namespace cli {

struct PlanetOptions {
    uint32_t most = 1;
    bool no_jitter = false, clip = false;
    std::optional<double> period_min, period_max; // units of t
    double threshold = 2, fap = 1e-3;
    uint32_t samples = 4096, threads = 0;
    uint64_t seed = 0;
    std::vector<double> star_masses; // solar masses
    std::optional<double> parallax_mas;
    std::string velocities[2];           // files of A and B
    int32_t velocity_trend = 3;          // of each star
    SampleOptions velocity_samples = {}; // how to read them

    void add_to(CLI::App &command);
    // Throws Failure for bad values and for those that do not suit the unit.
    void check(const ValueUnit &unit) const;
};

struct PlanetSearch {
    toliman::planet_set handle;
    ValueUnit unit = {};
    toliman_planet_options options = toliman::sized<toliman_planet_options>(); // as the library received them
    toliman_planet_info info = toliman::sized<toliman_planet_info>();
    std::vector<toliman_planet_candidate> candidates; // as they were found
    std::vector<int64_t> outliers;                    // indices of the samples that do not belong
    size_t velocities = 0, velocity_outliers = 0;     // samples of velocities, and those that do not belong
    Instruments instruments;                          // of a series with several, or with velocities; otherwise none

    // The first candidates: those of the joint fit, whose odds reach the threshold.
    size_t fitted() const noexcept;
    // Reasons against a planet; empty for a planet.
    std::vector<std::string> reasons(size_t index) const;

    double uas(double value) const noexcept { return value * unit.factor * 1e6; }
    bool knows_mass(size_t star) const noexcept;
};

// Velocities of the stars, of the options; NULL: none.
using Velocities = std::array<toliman::measurements, 2>;
Velocities velocities_of(const PlanetOptions &options, Progress &progress);

// Throws Failure for options and series that the library refuses.
PlanetSearch find_planets(const toliman_measure *series, const PlanetOptions &options, const ValueUnit &unit,
                          Progress &progress);

constexpr double kLimitProbability = 0.95;
// Limits at periods from the shortest to the longest, with equal steps of their logarithm.
std::vector<toliman_planet_limit> limits_of(const PlanetSearch &search);
// Those at other periods.
std::vector<toliman_planet_limit> limits_at(const PlanetSearch &search, const std::vector<double> &periods);

// [count + 1] numbers from `first` to `last` with equal ratios.
std::vector<double> edges_between(double first, double last, size_t count);

} // namespace cli
