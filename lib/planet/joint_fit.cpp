// Method: variable projection. The sum of squares, with the amplitudes and coefficients that minimise it, is a function
// of the orbits alone; each step solves the linearised problem in all numbers, changes the orbits by it, or by a half,
// a quarter, ... of it if the sum of squares would not fall, and solves for the amplitudes again.
//
// An orbit is described by f, k = e cos w and h = e sin w with the mean anomaly 2 pi f t - w, and amplitudes that
// multiply the position turned by w: there is no singularity at e = 0. k and h have Gaussian priors of mean 0 and
// standard deviation 0.3, as wide as the prior of e; without them the orbit of a weak signal would go to the largest e.
// Derivatives are central differences of signals with errors of 1e-10, which change the steps, but not the minimum.
//
// Reference: Golub and Pereyra (1973), SIAM J. Numer. Anal. 10, 413; Kaufman (1975), BIT 15, 49
#include "planet/joint_fit.hpp"

#include <cmath>

#include "base/constants.hpp"

namespace toliman::planet {

namespace {

constexpr double kEccentricitySigma = 0.3, kDifference = 1e-5, kLeastFall = 1e-7;
constexpr int kMostFitSteps = 100, kMostHalvings = 30;

// The numbers that are fitted.
struct Numbers {
    double frequency, k, h;
    Amplitudes turned;
    int star;
};

// Turns pairs of amplitudes by an angle.
Amplitudes turned(const Amplitudes &amplitudes, double angle) noexcept {
    const double cosine = std::cos(angle), sine = std::sin(angle);
    Amplitudes out;
    for (size_t pair = 0; pair < kMostAmplitudes; pair += 2) {
        out[pair] = amplitudes[pair] * cosine - amplitudes[pair + 1] * sine;
        out[pair + 1] = amplitudes[pair] * sine + amplitudes[pair + 1] * cosine;
    }
    return out;
}

Numbers numbers_of(const Planet &planet) noexcept {
    const double longitude = -2 * kPi * planet.orbit.anomaly, e = planet.orbit.eccentricity;
    return {planet.orbit.frequency, e * std::cos(longitude), e * std::sin(longitude),
            turned(planet.amplitudes, longitude), planet.orbit.star};
}

Planet planet_of(const Numbers &numbers) noexcept {
    const double longitude = std::atan2(numbers.h, numbers.k);
    return {{numbers.frequency, std::hypot(numbers.k, numbers.h), -longitude / (2 * kPi), numbers.star},
            turned(numbers.turned, -longitude)};
}

double &number(Numbers &numbers, size_t i) noexcept {
    return i == 0 ? numbers.frequency : i == 1 ? numbers.k : numbers.h;
}

double eccentricity_square(const std::vector<FittedPlanet> &planets) noexcept {
    double sum = 0;
    for (const FittedPlanet &fitted : planets)
        sum += std::pow(fitted.planet.orbit.eccentricity / kEccentricitySigma, 2);
    return sum;
}

std::vector<Function> shapes_of(const Series &series, const FittedPlanet &fitted) {
    std::vector<Function> functions = shape_functions(series, fitted.planet.orbit);
    for (Function &function : functions)
        function.precision = 1 / (fitted.scale * fitted.scale);
    return functions;
}

// Solves for the amplitudes of the orbits at hand. Returns the sum of squares.
double solve_amplitudes(const Series &series, double jitter, std::vector<FittedPlanet> &planets) {
    std::vector<std::vector<Function>> shapes;
    shapes.reserve(planets.size());
    std::vector<const Function *> all;
    for (const Function &function : series.functions)
        all.push_back(&function);
    for (const FittedPlanet &fitted : planets)
        shapes.push_back(shapes_of(series, fitted));
    for (const auto &own : shapes)
        for (const Function &function : own)
            all.push_back(&function);
    const Design design(series, all, series.y, jitter);
    const std::vector<double> coefficients = design.coefficients();
    size_t next = series.functions.size();
    for (FittedPlanet &fitted : planets)
        for (size_t j = 0; j < series.amplitudes(); j++)
            fitted.planet.amplitudes[j] = coefficients[next++];
    return design.square() + eccentricity_square(planets);
}

// The planets with a part of the changes of a step; false if an orbit is then impossible.
bool change(const Series &series, const std::vector<double> &changes, double part, double eccentricity_max,
            std::vector<FittedPlanet> &planets) {
    size_t next = series.functions.size();
    for (FittedPlanet &fitted : planets) {
        double own[kMostAmplitudes + kOrbitNumbers];
        for (size_t i = 0; i < series.amplitudes() + kOrbitNumbers; i++)
            own[i] = part * changes[next++];
        fitted.planet = changed(series, fitted.planet, own);
        const Orbit &orbit = fitted.planet.orbit;
        if (!(orbit.eccentricity <= eccentricity_max && orbit.frequency > 0))
            return false;
    }
    return true;
}

} // namespace

Planet changed(const Series &series, const Planet &planet, const double *changes) {
    Planet next = planet;
    for (size_t i = 0; i < series.amplitudes(); i++)
        next.amplitudes[i] += changes[i];
    Numbers numbers = numbers_of(next);
    for (size_t i = 0; i < kOrbitNumbers; i++)
        number(numbers, i) += changes[series.amplitudes() + i];
    return planet_of(numbers);
}

std::vector<Function> derivatives_of(const Series &series, const FittedPlanet &fitted) {
    std::vector<Function> functions = shapes_of(series, fitted);
    for (size_t j = 0; j < functions.size(); j++)
        functions[j].target = -fitted.planet.amplitudes[j];
    const Numbers centre = numbers_of(fitted.planet);
    for (size_t i = 0; i < kOrbitNumbers; i++) {
        const double size = i == 0 ? kDifference / series.span : kDifference;
        Numbers more = centre, less = centre;
        number(more, i) += size;
        number(less, i) -= size;
        Function function;
        function.values = signal_of(series, planet_of(more));
        const Buffer<double> below = signal_of(series, planet_of(less));
        for (size_t row = 0; row < series.rows; row++)
            function.values[row] = (function.values[row] - below[row]) / (2 * size);
        if (i > 0) {
            function.precision = 1 / (kEccentricitySigma * kEccentricitySigma);
            function.target = i == 1 ? -centre.k : -centre.h;
        }
        functions.push_back(std::move(function));
    }
    return functions;
}

double fit_jointly(const Series &series, double jitter, double eccentricity_max, std::vector<FittedPlanet> &planets) {
    double square = solve_amplitudes(series, jitter, planets);
    for (int step = 0; step < kMostFitSteps; step++) {
        const JointFunctions functions(series, planets, planets.size());
        const Design design(series, functions.all(), without_planets(series, planets, planets.size()), jitter);
        const std::vector<double> changes = design.coefficients();
        const double before = square;
        for (int halving = 0; halving <= kMostHalvings; halving++) {
            std::vector<FittedPlanet> next = planets;
            if (!change(series, changes, std::ldexp(1.0, -halving), eccentricity_max, next))
                continue;
            const double reached = solve_amplitudes(series, jitter, next);
            if (reached < square) {
                planets = next;
                square = reached;
                break;
            }
        }
        if (!(before - square > kLeastFall))
            break;
    }
    return square;
}

Buffer<double> without_planets(const Series &series, const std::vector<FittedPlanet> &planets, size_t kept) {
    Buffer<double> values = series.y;
    for (size_t p = 0; p < planets.size(); p++)
        if (p != kept) {
            const Buffer<double> signal = signal_of(series, planets[p].planet);
            for (size_t i = 0; i < series.n; i++)
                values[i] -= signal[i];
        }
    return values;
}

JointFunctions::JointFunctions(const Series &series, const std::vector<FittedPlanet> &planets, size_t kept) {
    for (size_t p = 0; p < planets.size(); p++)
        if (p != kept)
            derivatives_.push_back(derivatives_of(series, planets[p]));
    for (const Function &function : series.functions)
        all_.push_back(&function);
    for (const auto &own : derivatives_)
        for (const Function &function : own)
            all_.push_back(&function);
}

} // namespace toliman::planet
