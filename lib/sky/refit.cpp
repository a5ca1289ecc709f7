// Method: Gauss-Newton steps on
//     sum ((s/F(q) - g(q) (1 + k))/sigma)^2 + sum ((q - q0)/sigma_q)^2 + (k/sigma_k)^2,
// where s are the measured separations, g is the geometric separation on the orbit with elements q, F the factor
// apparent/geometric, and k the relative error of the plate scale. The prior q0, sigma_q is that of the reference at
// every step. The derivatives contain that of F.
// The steps end when none is longer than 0.01 of the standard deviations after the fit.
// If chi-square is poor, the sigmas are added in quadrature to a jitter, with which it is 1, and the fit is repeated
// until the jitter stays: the errors of the elements are then those of the residuals, not of the sigmas.
// Dividing s by F, instead of subtracting a predicted separation, leaves no annual wave where the elements or the plate
// scale are wrong: 8.4 mas off, 8e-4 of 746 uas of aberration would remain.
#include "sky/refit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/robust.hpp"
#include "base/symmetric.hpp"

namespace toliman::sky {

namespace {

constexpr int kMostSteps = 20, kMostTurns = 10, kBisections = 60;
constexpr double kStill = 1e-2; // standard deviations after the fit
constexpr double kMostEccentricity = 0.9999;
constexpr double kFarthest = 10; // standard deviations: beyond, separations and system do not belong together
constexpr size_t kScale = kElements, kAll = kElements + 1;
constexpr const char *kFittedNames[kAll] = {
    "the period", "the semi-major axis",        "the eccentricity",       "the inclination",
    "the node",   "the argument of periastron", "the date of periastron", "the plate scale"};

using FittedValues = std::array<double, kAll>;

// Normal equations of a step, in units of the standard deviations of the prior.
struct Step {
    double matrix[kAll][kAll] = {};
    double gradient[kAll] = {};
    double squares = 0;            // of the residuals of the geometric separations
    std::vector<double> residuals; // of the measured ones, arcsec
};

// Fails if the mean over an exposure cannot be predicted.
void check_known(const Observer &observer, const std::vector<Measurement> &measurements) {
    for (size_t i = 0; i < measurements.size(); i++)
        if (const std::string why = why_unknown(observer, measurements[i].exposure); !why.empty())
            fail(Status::argument, "measurement %zu: {intervals}: %s", i, why.c_str());
}

Prediction mean_of(const Predictor &predictor, const std::vector<Measurement> &measurements, size_t i) {
    try {
        return predictor.mean(measurements[i].exposure.intervals);
    } catch (const Error &error) {
        fail_within(error, error.status(), "measurement %zu: %s", i, error.what());
    }
}

Step step_at(const Predictor &predictor, const std::vector<Measurement> &measurements, const FittedValues &sigma,
             double scale, double jitter) {
    Step step;
    for (size_t m = 0; m < measurements.size(); m++) {
        const Measurement &one = measurements[m];
        const Prediction seen = mean_of(predictor, measurements, m);
        const double noise = std::hypot(one.sigma_arcsec, jitter) / seen.factor;
        const double rest = one.separation_arcsec / seen.factor - seen.geometric_arcsec * (1 + scale);
        double row[kAll];
        for (size_t i = 0; i < kElements; i++)
            row[i] = seen.partials[i] * (1 + scale) * sigma[i] / noise;
        row[kScale] = seen.geometric_arcsec * sigma[kScale] / noise;
        for (size_t i = 0; i < kAll; i++) {
            step.gradient[i] += row[i] * rest / noise;
            for (size_t j = i; j < kAll; j++)
                step.matrix[i][j] += row[i] * row[j];
        }
        step.squares += rest * rest;
        step.residuals.push_back(rest * seen.factor);
    }
    return step;
}

// The jitter with which the sum of squares over the variances is the number of degrees of freedom: that of the largest
// likelihood, but for the numbers that are fitted. By bisection; 0 if the sum is smaller without a jitter.
double jitter_of(const std::vector<double> &residuals, const std::vector<Measurement> &measurements, double freedom) {
    const auto sum = [&](double jitter) {
        double square = 0;
        for (size_t i = 0; i < residuals.size(); i++)
            square += std::pow(residuals[i] / std::hypot(measurements[i].sigma_arcsec, jitter), 2);
        return square;
    };
    double low = 0, high = 0;
    for (const double residual : residuals)
        high += std::fabs(residual);
    for (int i = 0; i < kBisections; i++) {
        const double middle = (low + high) / 2;
        (sum(middle) > freedom ? low : high) = middle;
    }
    return sum(0) > freedom ? high : 0;
}

void set_goodness(const std::vector<double> &residuals, const std::vector<Measurement> &measurements, double determined,
                  Refit &out) {
    const auto count = static_cast<double>(residuals.size());
    const double freedom = std::max(count - determined, 1.0);
    std::vector<double> sizes;
    double square = 0, largest = 0;
    for (size_t i = 0; i < residuals.size(); i++) {
        sizes.push_back(std::fabs(residuals[i] / measurements[i].sigma_arcsec));
        square += sizes[i] * sizes[i];
        largest = std::max(largest, sizes[i]);
    }
    out.goodness =
        goodness_of(square / freedom, chi_square_sigma(residuals.size(), 0, freedom), largest, kSeriesSigmas);
    const double limit = kOutlierSigmas * std::max(robust_sigma(sizes), 1.0);
    out.outliers =
        static_cast<size_t>(std::count_if(sizes.begin(), sizes.end(), [&](double size) { return size > limit; }));
    out.next_jitter_arcsec = jitter_of(residuals, measurements, freedom);
}

// The fit with a given jitter.
Refit fit(const Predictor &reference, const std::vector<Measurement> &measurements, double scale_sigma, double jitter) {
    Refit out = {};
    out.jitter_arcsec = jitter;
    out.system = reference.system();
    FittedValues sigma = {}, moved = {}; // moved: from the prior, in its standard deviations
    for (size_t i = 0; i < kElements; i++)
        sigma[i] = out.system.sigma.orbit.*kElementOf[i];
    sigma[kScale] = scale_sigma;
    if (std::all_of(sigma.begin(), sigma.end() - 1, [](double one) { return one == 0; }))
        fail(Status::argument, "{sky}: no element has a standard deviation (sigma.orbit of the system file): there is "
                               "nothing to fit");
    const Orbit prior = out.system.value.orbit;
    double longest = 0, determined = 0; // numbers that the measurements determine: a prior is one, too
    do {
        const Predictor predictor(out.system, reference);
        Step step = step_at(predictor, measurements, sigma, moved[kScale] * sigma[kScale], jitter);
        for (size_t i = 0; i < kAll; i++) {
            step.matrix[i][i] += 1; // the prior
            step.gradient[i] -= moved[i];
        }
        if (!invert_symmetric(step.matrix[0], kAll))
            fail(Status::argument, "{sky}: the normal equations of the elements are singular");
        longest = 0;
        determined = 0;
        for (size_t i = 0; i < kAll; i++) {
            determined += sigma[i] > 0 ? 1 - step.matrix[i][i] : 0;
            double change = 0;
            for (size_t j = 0; j < kAll; j++)
                change += step.matrix[i][j] * step.gradient[j];
            moved[i] += change;
            longest = std::max(longest, std::fabs(change) / std::sqrt(step.matrix[i][i]));
        }
        for (size_t i = 0; i < kElements; i++) {
            const auto element = kElementOf[i];
            out.system.value.orbit.*element = prior.*element + moved[i] * sigma[i];
            out.system.sigma.orbit.*element = sigma[i] * std::sqrt(step.matrix[i][i]);
            for (size_t j = 0; j < kElements; j++)
                out.covariance[i][j] = sigma[i] * sigma[j] * step.matrix[i][j];
        }
        for (size_t i = 0; i < kAll; i++)
            if (!(std::fabs(moved[i]) <= kFarthest))
                fail(Status::argument,
                     "{measured}: the fit moves %s by %.3g standard deviations: must be at most 10; check "
                     "system, unit (arcsec), times and plate scale",
                     kFittedNames[i], std::fabs(moved[i]));
        const Orbit &orbit = out.system.value.orbit;
        if (!(orbit.eccentricity >= 0 && orbit.eccentricity <= kMostEccentricity && orbit.period_years > 0 &&
              orbit.semi_major_arcsec > 0 && orbit.inclination_deg >= 0 && orbit.inclination_deg <= 180))
            fail(Status::argument,
                 "{measured}: no orbit near that of the system has them: eccentricity %g, "
                 "semi-major axis %g arcsec, period %g years, inclination %g deg",
                 orbit.eccentricity, orbit.semi_major_arcsec, orbit.period_years, orbit.inclination_deg);
        out.scale = moved[kScale] * sigma[kScale];
        out.scale_sigma = sigma[kScale] * std::sqrt(step.matrix[kScale][kScale]);
        out.iterations++;
    } while (longest > kStill && out.iterations < kMostSteps);
    double &periastron = out.system.value.orbit.periastron_deg; // system files have at most one turn
    if (std::fabs(periastron) > 360)
        periastron -= std::copysign(360, periastron);
    if (longest > kStill)
        fail(Status::argument, "{measured}: the fit does not converge");
    const Step last = step_at(Predictor(out.system, reference), measurements, sigma, out.scale, jitter);
    out.rms_arcsec = std::sqrt(last.squares / static_cast<double>(measurements.size()));
    set_goodness(last.residuals, measurements, determined, out);
    return out;
}

std::vector<int64_t> starts_of(const std::vector<Measurement> &measurements) {
    std::vector<int64_t> starts;
    for (const Measurement &measurement : measurements)
        starts.push_back(measurement.exposure.intervals.front().start_ns);
    return starts;
}

} // namespace

Refit refit(const Predictor &reference, const std::vector<Measurement> &measurements, double scale_sigma) {
    if (measurements.empty())
        fail(Status::argument, "{count} = 0: must be at least 1");
    check_known(reference.observer(), measurements);
    const Refitted dates = dates_of(starts_of(measurements));
    if (is_refitted_to(reference.system(), dates))
        fail(Status::argument,
             "{sky}: its orbit was refitted to measurements of %.3f to %.3f, also of these dates: give the system "
             "before that refit",
             reference.system().refit->first, reference.system().refit->last);
    Refit found = fit(reference, measurements, scale_sigma, 0);
    for (int turn = 0; turn < kMostTurns && found.goodness.verdict == GoodnessVerdict::poor; turn++) {
        const double before = found.jitter_arcsec, jitter = found.next_jitter_arcsec;
        found = fit(reference, measurements, scale_sigma, jitter);
        if (std::fabs(jitter - before) <= kStill * jitter)
            break;
    }
    const Refitted before = reference.system().refit.value_or(dates);
    found.system.refit = {std::min(before.first, dates.first), std::max(before.last, dates.last)};
    return found;
}

} // namespace toliman::sky
