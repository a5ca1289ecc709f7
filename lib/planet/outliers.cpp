// Method: the functions of the series are fitted with weights of Huber's function, min(1, 1.5 s/|z|), of the residuals
// z in units of the sigmas, with the robust standard deviation s = 1.4826 median |z|, beginning with the values
// themselves: a single value of 1e90 has no more influence than one of 1.5 s. Measurements beyond 6 s are left out, and
// a least-squares fit of the functions and of the best sinusoid to the others decides again, until it marks the same
// ones. A sinusoid leaves a part of an eccentric orbit: s is then larger, and near periastron measurements may be
// marked that belong; the search readmits those that its orbits describe (search.cpp).
//
// Rejected: to judge by the residuals of the search alone. A sharp periastron describes any single measurement, so that
// an outlier is where the residuals are least, and the search costs minutes: orbits at all frequencies describe it.
//
// Reference: Huber (1981), Robust Statistics, chapter 7
#include "planet/outliers.hpp"

#include <algorithm>
#include <cmath>

#include "base/robust.hpp"
#include "planet/marginal.hpp"

namespace toliman::planet {

namespace {

constexpr double kHuber = 1.5, kStillScale = 1e-3;
constexpr int kMostRobustSteps = 30, kMostScreenings = 6;
constexpr double kSinusoidStep = 0.2, kMostSinusoids = 20000; // of 1/span
constexpr size_t kLeastOfGroup = 8;
constexpr double kWide = 1e50; // scale of a prior without influence, in units of the sigmas

double sigma_of(const Series &series, size_t i) noexcept {
    return series.sigma[i] > 0 ? series.sigma[i] : 1;
}

std::vector<const Function *> listed(const std::vector<Function> &functions) {
    std::vector<const Function *> all;
    for (const Function &function : functions)
        all.push_back(&function);
    return all;
}

Buffer<double> fitted(const Series &series, const std::vector<const Function *> &functions) {
    return residuals_of(series, functions, series.y, Design(series, functions, series.y, unit_jitter(series)));
}

// Residuals of the robust fit of the functions.
Buffer<double> robust_residuals(Series &series) {
    const std::vector<const Function *> functions = listed(series.functions);
    Buffer<double> residuals = series.y;
    double before = 0;
    for (int step = 0; step < kMostRobustSteps; step++) {
        const double scale = scale_of(series, residuals);
        if (!(scale > 0) || std::fabs(scale - before) < kStillScale * scale)
            break;
        before = scale;
        for (size_t i = 0; i < series.n; i++) {
            const double size = std::fabs(residuals[i] / sigma_of(series, i));
            series.factor[i] = size > kHuber * scale ? std::sqrt(kHuber * scale / size) : 1;
        }
        residuals = fitted(series, functions);
    }
    return residuals;
}

// What a sinusoid takes from the sum of squares.
double gain(const Moments &moments, double scale) noexcept {
    const AmplitudeFit fit = fit_amplitudes(moments, scale);
    double sum = 0;
    for (size_t i = 0; i < moments.size; i++)
        sum += fit.mean[i] * moments.right[i];
    return sum;
}

// The two or four functions of the best sinusoid.
std::vector<Function> best_sinusoid(const Series &series, double frequency_min, double frequency_max) {
    const Design design(series, listed(series.functions), series.y, unit_jitter(series));
    ShapeWork work(series);
    const double scale = kWide * std::max(series.median_sigma, 1e-50);
    Orbit best = {frequency_min, 0, 0};
    double most = -1;
    const double range = frequency_max - frequency_min;
    const double step = std::max(kSinusoidStep / series.span, range / kMostSinusoids);
    for (int i = 0; i * step <= range; i++) {
        const Orbit orbit = {frequency_min + i * step, 0, 0};
        const double found = gain(work.moments(series, design, orbit), scale);
        if (found > most) {
            most = found;
            best = orbit;
        }
    }
    return shape_functions(series, best);
}

// The scale of each group, as instruments have different jitters; of all for one with few measurements.
std::vector<double> scales_of_groups(const Series &series, const Buffer<double> &residuals) {
    const double of_all = scale_of(series, residuals);
    std::vector<std::vector<double>> sizes(series.groups.size());
    for (size_t i = 0; i < series.n; i++)
        sizes[series.group[i]].push_back(residuals[i] / sigma_of(series, i));
    std::vector<double> scales;
    for (std::vector<double> &own : sizes)
        scales.push_back(own.size() < kLeastOfGroup || sizes.size() == 1
                             ? of_all
                             : std::max(robust_sigma(std::move(own)), series.median_sigma > 0 ? 1.0 : 0.0));
    return scales;
}

} // namespace

double scale_of(const Series &series, const Buffer<double> &residuals) {
    std::vector<double> sizes(series.n);
    for (size_t i = 0; i < series.n; i++)
        sizes[i] = residuals[i] / sigma_of(series, i);
    return std::max(robust_sigma(std::move(sizes)), series.median_sigma > 0 ? 1.0 : 0.0);
}

Buffer<double> residuals_of(const Series &series, const std::vector<const Function *> &functions,
                            const Buffer<double> &values, const Design &design) {
    const std::vector<double> coefficients = design.coefficients();
    Buffer<double> residuals(series.n);
    for (size_t i = 0; i < series.n; i++) {
        residuals[i] = values[i];
        for (size_t j = 0; j < functions.size(); j++)
            residuals[i] -= coefficients[j] * functions[j]->values[i];
    }
    return residuals;
}

std::vector<bool> far_residuals(const Series &series, const Buffer<double> &residuals) {
    std::vector<bool> far(series.n);
    const std::vector<double> scales = scales_of_groups(series, residuals);
    size_t count = 0;
    for (size_t i = 0; i < series.n; i++) {
        const double limit = kOutlierSigmas * scales[series.group[i]];
        far[i] = limit > 0 && std::fabs(residuals[i] / sigma_of(series, i)) > limit;
        count += far[i];
    }
    return count * 5 < series.n && series.n - count >= series.functions.size() + 6 ? far : std::vector<bool>(series.n);
}

std::vector<bool> screen(Series series, double frequency_min, double frequency_max) {
    const size_t numbers = series.functions.size() + series.amplitudes();
    if (series.n < 3 * numbers)
        return std::vector<bool>(series.n);
    std::vector<bool> far = far_residuals(series, robust_residuals(series));
    for (int turn = 0; turn < kMostScreenings; turn++) {
        series.leave_out(far);
        const std::vector<Function> sinusoid = best_sinusoid(series, frequency_min, frequency_max);
        std::vector<const Function *> functions = listed(series.functions);
        for (const Function &function : sinusoid)
            functions.push_back(&function);
        std::vector<bool> next = far_residuals(series, fitted(series, functions));
        if (next == far)
            break;
        far = std::move(next);
    }
    return far;
}

double rms_of(const Series &series, const Design &design) noexcept {
    double weight = 0, square = 0;
    for (size_t i = 0; i < series.primary; i++) {
        weight += design.weights()[i] * design.weights()[i];
        square += design.residuals()[i] * design.residuals()[i];
    }
    return std::sqrt(square / weight);
}

// Weighted rms about the weighted mean of each instrument: offsets between instruments are no scatter.
double spread_of(const Series &series, const Buffer<double> &values) {
    const Buffer<double> weights = series.weights(unit_jitter(series));
    std::vector<double> weight(series.groups.size()), mean(series.groups.size());
    for (size_t i = 0; i < series.primary; i++) {
        const double square = weights[i] * weights[i];
        weight[series.group[i]] += square;
        mean[series.group[i]] += square * values[i];
    }
    double sum = 0, all = 0;
    for (size_t i = 0; i < series.primary; i++) {
        const size_t group = series.group[i];
        const double off = weights[i] > 0 ? values[i] - mean[group] / weight[group] : 0;
        sum += weights[i] * weights[i] * off * off;
        all += weights[i] * weights[i];
    }
    return std::sqrt(sum / all);
}

Goodness series_goodness(const Series &series, const Buffer<double> &residuals, const Design &design,
                         bool with_left_out) {
    if (!(series.median_sigma > 0))
        return {};
    const std::vector<double> leverages = design.leverages();
    double square = 0, largest = 0, freedom = 0;
    size_t count = 0;
    for (size_t i = 0; i < series.primary; i++) {
        if (!with_left_out && series.factor[i] == 0)
            continue;
        const double size = std::fabs(residuals[i] / series.sigma[i]);
        square += size * size;
        largest = std::max(largest, size);
        freedom += 1 - leverages[i];
        count++;
    }
    freedom = std::max(freedom, 1.0);
    return goodness_of(square / freedom, chi_square_sigma(count, 0, freedom), largest, kSeriesSigmas);
}

Goodness goodness_with_jitter(const Series &series, const Design &design) {
    const std::vector<double> leverages = design.leverages();
    double square = 0, largest = 0, freedom = 0;
    for (size_t i = 0; i < series.n; i++) {
        square += design.residuals()[i] * design.residuals()[i];
        largest = std::max(largest, std::fabs(design.residuals()[i]));
        freedom += series.factor[i] > 0 ? 1 - leverages[i] : 0;
    }
    freedom = std::max(freedom, 1.0);
    return goodness_of(square / freedom, chi_square_sigma(series.used, 0, freedom), largest, kSeriesSigmas);
}

} // namespace toliman::planet
