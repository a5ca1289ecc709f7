// Method: with the orthonormal q_1, q_2 that are left of cosine and sine, a signal s adds L = |s|^2 to the square of
// the projection of the residuals r on them, which is (sqrt L + n_1)^2 + n_2^2 with standard normal n_1, n_2. The
// highest power near its frequency follows the frequency too: a peak of parabolic shape is displaced by noise by n_3
// standard deviations, and higher by n_3^2. If a share R of the signal is left in the power at another frequency, its
// distance is sqrt(L (1 - R)) standard deviations. So
//     P(recovery | phase, rest) = P((sqrt L + n_1)^2 + n_2^2 + n_3^2 > c rest, n_3 within the tolerance of the period),
// with c = power/(1 - power) at the threshold and the rest of |r|^2 a chi-square, of which only mean and variance are
// used. The distance of an edge of the tolerance is the mean of those of the last frequency of the grid inside and the
// first one, or the best one, outside. The probability of n_1 is elementary; the others are integrated by Gauss' rules,
// the phase by a sum.
//
// Tried: two degrees of freedom, which is too low by 0.06; three without the tolerance, which is too high by 0.5 where
// the functions describe most of the signal.
#include "planet/recovery.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/constants.hpp"
#include "kernels/kepler_rows.hpp"
#include "kernels/poisson.hpp"

namespace toliman::planet {

namespace {

constexpr int kPhases = 32;

// Points and weights of Gauss-Hermite quadrature for a normal variate.
constexpr double kHermite[][2] = {{-2.8569700138728056, 0.0112574113277207},
                                  {-1.3556261799742659, 0.2220759220056126},
                                  {0, 0.5333333333333333},
                                  {1.3556261799742659, 0.2220759220056126},
                                  {2.8569700138728056, 0.0112574113277207}};
// Points and weights of Gauss-Legendre quadrature on [-1, 1].
constexpr double kLegendre[][2] = {{-0.9602898564975363, 0.1012285362903763}, {-0.7966664774136267, 0.2223810344533745},
                                   {-0.5255324099163290, 0.3137066458778873}, {-0.1834346424956498, 0.3626837833783620},
                                   {0.1834346424956498, 0.3626837833783620},  {0.5255324099163290, 0.3137066458778873},
                                   {0.7966664774136267, 0.2223810344533745},  {0.9602898564975363, 0.1012285362903763}};
constexpr double kFarthest = 5; // standard deviations

double normal_share(double x) noexcept {
    return std::erfc(-x * std::sqrt(0.5)) / 2;
}

// Probability that (length + n_1)^2 exceeds a square.
double exceeds(double length, double square) noexcept {
    if (square <= 0)
        return 1;
    const double least = std::sqrt(square);
    return normal_share(length - least) + normal_share(-length - least);
}

// Probability that (length + n_1)^2 + n_2^2 + n_3^2 exceeds a square, with n_3 in (0, end).
double recovered(double length, double square, double end) noexcept {
    const double half = std::min(end, kFarthest) / 2;
    double sum = 0;
    for (const auto &[point, weight] : kLegendre) {
        const double n3 = half * (1 + point), density = std::exp(-n3 * n3 / 2) / std::sqrt(2 * kPi);
        for (const auto &[n2, share] : kHermite)
            sum += weight * density * share * exceeds(length, square - n2 * n2 - n3 * n3);
    }
    return sum * half;
}

// What is left of cosine and sine at all frequencies, whitened and orthonormal, [2 frequencies][rows]; 0 where less
// than 1e-12 is left.
Buffer<double> directions_of(const Detection &detection) {
    const Series &series = detection.problem().series;
    const DetectionGrid &grid = detection.grid();
    const Design &design = detection.design();
    const size_t rows = series.rows;
    Buffer<double> all(2 * grid.count * rows), shapes(series.amplitudes() * rows);
    for (size_t i = 0; i < grid.count; i++) {
        double *const x = &all[2 * i * rows], *const y = x + rows;
        set_shapes(series, {grid.at(i), 0, 0}, shapes.data());
        double before = 0;
        for (size_t row = 0; row < rows; row++) {
            x[row] = design.weights()[row] * shapes[row];
            y[row] = design.weights()[row] * shapes[rows + row];
            before += x[row] * x[row] + y[row] * y[row];
        }
        design.project(x);
        design.project(y);
        const CircularPair pair = detection.pair_at(grid.at(i));
        const double left_x = pair.xx, slope = left_x > 0 ? pair.xy / left_x : 0, left_y = pair.yy - slope * pair.xy;
        const double scale_x = left_x > 1e-12 * before ? 1 / std::sqrt(left_x) : 0;
        const double scale_y = left_y > 1e-12 * before ? 1 / std::sqrt(left_y) : 0;
        for (size_t row = 0; row < rows; row++) {
            y[row] = scale_y * (y[row] - slope * x[row]);
            x[row] *= scale_x;
        }
    }
    return all;
}

} // namespace

Recovery::Recovery(const Detection &detection) : detection_(detection), directions_(directions_of(detection)) {}

// A circular orbit: for each phase, the square of what is left of a signal of amplitude 1, and the roots of the shares
// of it that are lost at the edges of the tolerance, below and above the frequency.
struct Recovery::Target {
    std::array<double, kPhases> square = {}, below = {}, above = {};
};

Recovery::Target Recovery::target_at(double frequency) const {
    const Series &series = detection_.problem().series;
    const DetectionGrid &grid = detection_.grid();
    const size_t rows = series.rows;
    Buffer<double> shapes(series.amplitudes() * rows);
    set_shapes(series, {frequency, 0, 0}, shapes.data());
    for (size_t i = 0; i < 2; i++)
        for (size_t row = 0; row < rows; row++)
            shapes[i * rows + row] *= detection_.design().weights()[row];
    std::vector<double> along(4 * grid.count);
    kernels::kepler_kernels().products(directions_.data(), 2 * grid.count, shapes.data(), &shapes[rows], rows,
                                       along.data());
    const CircularPair pair = detection_.pair_at(frequency);
    Target target;
    for (size_t phase = 0; phase < kPhases; phase++) {
        const double angle = kPi * (static_cast<double>(phase) + 0.5) / kPhases;
        const double cosine = std::cos(angle), sine = std::sin(angle);
        const double square = std::max(pair.square(cosine, sine), 0.0);
        double inside[2] = {0, 0}, outside[2] = {1, 1}; // below and above: roots of the shares that are lost
        for (size_t i = 0; i < grid.count && square > 0; i++) {
            const double ratio = frequency / grid.at(i); // of the period that is found
            const double x = cosine * along[4 * i] + sine * along[4 * i + 1];
            const double y = cosine * along[4 * i + 2] + sine * along[4 * i + 3];
            const double lost = std::sqrt(std::max(1 - (x * x + y * y) / square, 0.0));
            const size_t side = ratio > 1 ? 0 : 1;
            if (std::fabs(ratio - 1) > kPeriodTolerance)
                outside[side] = std::min(outside[side], lost);
            else
                inside[side] = std::max(inside[side], lost);
        }
        target.square[phase] = square;
        target.below[phase] = (inside[0] + outside[0]) / 2;
        target.above[phase] = (inside[1] + outside[1]) / 2;
    }
    return target;
}

double Recovery::efficiency(const Target &target, double amplitude) const {
    const double left = std::pow(10, detection_.log10_threshold()), ratio = (1 - left) / left;
    const auto used = static_cast<double>(detection_.design().free());
    const double freedom = std::max(static_cast<double>(detection_.problem().series.used) - used - 3, 1.0);
    double sum = 0;
    for (size_t phase = 0; phase < kPhases; phase++) {
        const double length = amplitude * std::sqrt(target.square[phase]);
        for (const auto &[point, share] : kHermite) {
            const double square = ratio * (freedom + point * std::sqrt(2 * freedom));
            sum += share * (recovered(length, square, length * target.below[phase]) +
                            recovered(length, square, length * target.above[phase]));
        }
    }
    return std::min(sum / kPhases, 1.0); // the weights sum to 1 within 1e-6
}

double Recovery::efficiency(double frequency, double amplitude) const {
    return efficiency(target_at(frequency), amplitude);
}

double Recovery::recoverable(double frequency, double probability) const {
    const Target target = target_at(frequency);
    const double size = *std::max_element(target.square.begin(), target.square.end());
    if (!(size > 0))
        return HUGE_VAL;
    double high = 1 / std::sqrt(size), low = 0;
    for (int i = 0; i < 60 && efficiency(target, high) < probability; i++)
        high *= 2;
    for (int i = 0; i < 50; i++) {
        const double middle = (low + high) / 2;
        (efficiency(target, middle) < probability ? low : high) = middle;
    }
    return efficiency(target, high) >= probability ? high : HUGE_VAL;
}

// Whitened values of one injection.
struct Recovery::Injected {
    double period;
    Buffer<double> values;
};

// The values have errors of the functions with a prior, drawn from it.
Recovery::Injected Recovery::injected(const InjectionCell &cell, const Units &units, size_t index,
                                      kernels::Rng &rng) const {
    const Problem &problem = detection_.problem();
    const Series &series = problem.series;
    const double period = cell.period_min * std::pow(cell.period_max / cell.period_min, rng.uniform());
    const double size = cell.size_min * std::pow(cell.size_max / cell.size_min, rng.uniform());
    const double share = rng.uniform(), e = cell.circular ? 0 : problem.prior.eccentricity(share);
    const double phase = 2 * kPi * rng.uniform();
    const double amplitude = cell.star < 0 ? size : units.amplitude(cell.star, period, e, size);
    const Planet planet = {{1 / period, e, rng.uniform()}, {amplitude * std::cos(phase), amplitude * std::sin(phase)}};
    Injected made = {period, signal_of(series, planet)};
    for (const Function *function : problem.functions) {
        const double error = function->precision > 0 ? rng.normal() / std::sqrt(function->precision) : 0;
        for (size_t i = 0; i < series.n; i++)
            made.values[i] += error * function->values[i];
    }
    Buffer<double> noise(series.rows);
    kernels::poisson_kernels().gaussian(series.n, 0, {cell.seed, index, kernels::kStreamInjectionNoise}, noise.data());
    for (size_t i = 0; i < series.rows; i++)
        made.values[i] = series.factor[i] > 0 ? detection_.design().weights()[i] * made.values[i] + noise[i] : 0;
    return made;
}

size_t Recovery::inject(const InjectionCell &cell, const Units &units) const {
    const kernels::KeplerKernels &kernel = kernels::kepler_kernels();
    const DetectionGrid &grid = detection_.grid();
    const Design &design = detection_.design();
    const size_t rows = detection_.problem().series.rows, functions = design.functions();
    std::vector<double> along(4 * grid.count), described(2 * functions);
    kernels::Rng rng(cell.seed, kernels::kStreamInjection);
    const auto is_detected = [&](const Injected &made, size_t which) {
        double highest = -1, square = 0;
        size_t at = 0;
        for (size_t i = 0; i < grid.count; i++) {
            const double x = along[4 * i + which], y = along[4 * i + 2 + which], gain = x * x + y * y;
            if (gain > highest) {
                highest = gain;
                at = i;
            }
        }
        for (const double value : made.values)
            square += value * value;
        for (size_t j = 0; j < functions; j++)
            square -= described[2 * j + which] * described[2 * j + which];
        return std::log10(std::max(1 - highest / square, 1e-300)) <= detection_.log10_threshold() &&
               std::fabs(1 / (grid.at(at) * made.period) - 1) <= kPeriodTolerance;
    };
    size_t detected = 0;
    for (size_t i = 0; i < cell.count; i += 2) { // the products of two series take the time of one
        const Injected first = injected(cell, units, i, rng), second = injected(cell, units, i + 1, rng);
        const double *const x = first.values.data(), *const y = second.values.data();
        kernel.products(directions_.data(), 2 * grid.count, x, y, rows, along.data());
        kernel.products(design.table(), functions, x, y, rows, described.data());
        detected += is_detected(first, 0);
        detected += i + 1 < cell.count && is_detected(second, 1);
    }
    return detected;
}

} // namespace toliman::planet
