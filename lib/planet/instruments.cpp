// Method: restricted maximum likelihood of the variances theta_k = s_k^2 of the jitters, by Fisher scoring in
// x_k = ln s_k. With the whitened residuals r_i of the least-squares fit, the weights w_i^2 = 1/(sigma_i^2 + theta_k)
// and the leverages h_i,
//     dL/dx_k = theta_k sum over group k of w_i^2 (r_i^2 - (1 - h_i)),
//     I_kk    = 2 theta_k^2 sum over group k of w_i^4 (1 - h_i)^2.
// A group with few measurements, or with sigmas that explain its residuals, hardly determines its jitter: a Gaussian
// prior of x_k about the mean of all instruments of its series, with a standard deviation of ln 10, does.
//
// The integral over the jitter (jitter.cpp) then runs over a common factor of all jitters. Rejected: an axis for each
// instrument. The integrals over the others are nearly the same with and without a planet, and cost a factor of ten for
// each.
// Reference: Patterson and Thompson (1971), Biometrika 58, 545
#include "planet/instruments.hpp"

#include <algorithm>
#include <cmath>

namespace toliman::planet {

namespace {

const double kSpread = std::log(10.0); // of the logarithms of jitters of one series
constexpr double kLeast = 1e-3, kLeastInformation = 1e-3, kMostStep = 1.5, kStillScales = 1e-3;
constexpr int kMostScaleSteps = 40;

// Calls with each measurement of a group.
template <class Call> void each_of(const Series &series, size_t group, Call call) {
    const Group &own = series.groups[group];
    for (size_t i = own.first; i < own.first + own.count; i++)
        if (series.group[i] == group && series.factor[i] > 0)
            call(i);
}

// rms of the residuals of each group, in units of its values; of all for a group without measurements in use.
std::vector<double> sizes_of(const Series &series, const Design &design) {
    std::vector<double> sizes;
    for (size_t k = 0; k < series.groups.size(); k++) {
        double square = 0, count = 0;
        each_of(series, k, [&](size_t i) {
            square += std::pow(design.residuals()[i] / design.weights()[i], 2);
            count++;
        });
        sizes.push_back(count > 0 ? std::sqrt(square / count) : 0);
    }
    return sizes;
}

// Mean of the logarithms of the jitters of the series of each group.
std::vector<double> means_of(const Series &series, const std::vector<double> &logs) {
    std::vector<double> means;
    for (const Group &group : series.groups) {
        double sum = 0, count = 0;
        for (size_t k = 0; k < logs.size(); k++)
            if (series.groups[k].source == group.source) {
                sum += logs[k];
                count++;
            }
        means.push_back(sum / count);
    }
    return means;
}

// Slope and information of the logarithm of the jitter theta^(1/2) of a group; the latter with that of the prior.
struct Score {
    double slope, information;
};

Score score_of(const Series &series, const Design &design, const std::vector<double> &leverage, size_t group,
               double theta) {
    Score score = {0, kLeastInformation + 1 / (kSpread * kSpread)};
    each_of(series, group, [&](size_t i) {
        const double w = std::pow(design.weights()[i], 2), free = std::max(1 - leverage[i], 0.0);
        score.slope += theta * w * (std::pow(design.residuals()[i], 2) - free);
        score.information += 2 * std::pow(theta * w * free, 2);
    });
    return score;
}

// One step of the scoring. Returns the largest change.
double improve(const Series &series, const Design &design, const std::vector<double> &sizes,
               std::vector<double> &logs) {
    const std::vector<double> leverage = design.leverages(), means = means_of(series, logs);
    double most = 0;
    for (size_t k = 0; k < logs.size(); k++) {
        const Score score = score_of(series, design, leverage, k, std::exp(2 * logs[k]));
        const double step = (score.slope - (logs[k] - means[k]) / (kSpread * kSpread)) / score.information;
        const double least = sizes[k] > 0 ? std::log(kLeast * sizes[k]) : logs[k];
        const double next = std::max(logs[k] + std::clamp(step, -kMostStep, kMostStep), least);
        most = std::max(most, std::fabs(next - logs[k]));
        logs[k] = next;
    }
    return most;
}

} // namespace

std::vector<double> jitters_of(const Series &series, const std::vector<const Function *> &functions,
                               const Buffer<double> &values) {
    Series own = series;
    own.set_jitter_scales(std::vector<double>(own.groups.size(), 1.0));
    const std::vector<double> sizes = sizes_of(own, Design(own, functions, values, unit_jitter(own)));
    const double largest = *std::max_element(sizes.begin(), sizes.end());
    std::vector<double> jitters, logs;
    for (const double size : sizes)
        logs.push_back(std::log(size > 0 ? size : largest > 0 ? largest : 1.0));
    for (int step = 0; step < kMostScaleSteps; step++) {
        jitters.clear();
        for (const double log : logs)
            jitters.push_back(std::exp(log));
        own.set_jitter_scales(jitters);
        if (improve(own, Design(own, functions, values, 1), sizes, logs) < kStillScales)
            break;
    }
    return jitters;
}

std::vector<double> jitter_scales_of(const Series &series, const std::vector<const Function *> &functions,
                                     const Buffer<double> &values, std::vector<double> scales, double rms) {
    const std::vector<double> sizes = sizes_of(series, Design(series, functions, values, unit_jitter(series)));
    double largest = 0; // of the jitters over the rms of their groups
    for (size_t k = 0; k < scales.size(); k++)
        largest = std::max(largest, sizes[k] > 0 ? scales[k] / sizes[k] : 0);
    for (double &scale : scales)
        scale = largest > 0 ? scale / (largest * rms) : 1;
    return scales;
}

// The error of x_k = ln s_k is 1/sqrt(I_kk): the 68 % interval is s_k exp(-+ error).
std::vector<std::array<double, 3>> jitter_intervals(const Series &series, const Design &design, double jitter) {
    const std::vector<double> leverage = design.leverages();
    std::vector<std::array<double, 3>> intervals;
    for (size_t k = 0; k < series.groups.size(); k++) {
        const double own = jitter * series.jitter_scales()[k];
        const double error = 1 / std::sqrt(score_of(series, design, leverage, k, own * own).information);
        intervals.push_back({own * std::exp(-error), own, own * std::exp(error)});
    }
    return intervals;
}

std::vector<Goodness> goodness_of_groups(const Series &series, const Design &design, bool with_jitter) {
    const std::vector<double> leverage = design.leverages();
    std::vector<Goodness> all;
    for (size_t k = 0; k < series.groups.size(); k++) {
        double square = 0, largest = 0, freedom = 0;
        size_t count = 0;
        each_of(series, k, [&](size_t i) {
            const double own = with_jitter ? 1 : design.weights()[i] * series.sigma[i];
            const double size = std::fabs(design.residuals()[i]) / own;
            square += size * size;
            largest = std::max(largest, size);
            freedom += std::max(1 - leverage[i], 0.0);
            count++;
        });
        all.push_back(count > 0 && freedom > 0.5
                          ? goodness_of(square / freedom, chi_square_sigma(count, 0, freedom), largest, kSeriesSigmas)
                          : Goodness());
    }
    return all;
}

std::vector<Instrument> instruments_of(const Series &series, const Design &design,
                                       const std::vector<std::array<double, 3>> &jitters) {
    const std::vector<Goodness> goodness = series.median_sigma > 0 ? goodness_of_groups(series, design, false)
                                                                   : std::vector<Goodness>(series.groups.size());
    const std::vector<double> coefficients = design.coefficients(), covariance = design.covariance();
    std::vector<Instrument> all;
    for (size_t k = 0; k < series.groups.size(); k++) {
        const Group &group = series.groups[k];
        Instrument &one = all.emplace_back(Instrument{group.source, 0, 0, 0, jitters[k], goodness[k]});
        each_of(series, k, [&](size_t) { one.samples++; });
        if (group.instrument > 0) {
            one.offset = coefficients[group.offset];
            one.offset_error = std::sqrt(covariance[group.offset * (coefficients.size() + 1)]);
        }
    }
    return all;
}

std::vector<Instrument> instruments_alone(const GivenSeries &given) {
    Series series(given);
    std::vector<const Function *> functions;
    for (const Function &function : series.functions)
        functions.push_back(&function);
    series.set_jitter_scales(jitters_of(series, functions, series.y));
    const Design design(series, functions, series.y, 1);
    return instruments_of(series, design, jitter_intervals(series, design, 1));
}

} // namespace toliman::planet
