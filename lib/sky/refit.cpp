// Method: Gauss-Newton steps on
//     sum ((s/F(q) - g(q) (1 + k))/sigma)^2 + sum ((q - q0)/sigma_q)^2 + (k/sigma_k)^2,
// where s are the measured separations, g is the geometric separation on the orbit with elements q, F the factor
// apparent/geometric, and k the relative error of the plate scale. The prior q0, sigma_q is that of the reference at
// every step. The derivatives contain that of F.
// The steps end when none is longer than 0.01 of the standard deviations after the fit.
// Dividing s by F, instead of subtracting a predicted separation, leaves no annual wave where the elements or the plate
// scale are wrong: 8.4 mas off, 8e-4 of 746 uas of aberration would remain.
#include "sky/refit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/symmetric.hpp"

namespace toliman::sky {

namespace {

constexpr int kMostSteps = 20;
constexpr double kStill = 1e-2; // standard deviations after the fit
constexpr double kMostEccentricity = 0.9999;
constexpr double kFarthest = 10; // standard deviations: beyond, separations and system do not belong together
constexpr size_t kScale = kElements, kAll = kElements + 1;
constexpr const char *kNames[kAll] = {
    "the period", "the semi-major axis",        "the eccentricity",       "the inclination",
    "the node",   "the argument of periastron", "the date of periastron", "the plate scale"};

using Values = std::array<double, kAll>;

// Normal equations of a step, in units of the standard deviations of the prior.
struct Step {
    double matrix[kAll][kAll] = {};
    double gradient[kAll] = {};
    double chi_square = 0, squares = 0;
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

Step step_at(const Predictor &predictor, const std::vector<Measurement> &measurements, const Values &sigma,
             double scale) {
    Step step;
    for (size_t m = 0; m < measurements.size(); m++) {
        const Measurement &one = measurements[m];
        const Prediction seen = mean_of(predictor, measurements, m);
        const double noise = one.sigma_arcsec / seen.factor;
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
        step.chi_square += rest / noise * (rest / noise);
        step.squares += rest * rest;
    }
    return step;
}

} // namespace

Refit refit(const Predictor &reference, const std::vector<Measurement> &measurements, double scale_sigma) {
    Refit out = {};
    out.system = reference.system();
    Values sigma = {}, moved = {}; // moved: from the prior, in its standard deviations
    for (size_t i = 0; i < kElements; i++)
        sigma[i] = out.system.sigma.orbit.*kElementOf[i];
    sigma[kScale] = scale_sigma;
    if (std::all_of(sigma.begin(), sigma.end() - 1, [](double one) { return one == 0; }))
        fail(Status::argument, "{sky}: no element has a standard deviation (sigma.orbit of the system file): there is "
                               "nothing to fit");
    check_known(reference.observer(), measurements);
    const Orbit prior = out.system.value.orbit;
    double longest = 0;
    do {
        const Predictor predictor(out.system, reference);
        Step step = step_at(predictor, measurements, sigma, moved[kScale] * sigma[kScale]);
        for (size_t i = 0; i < kAll; i++) {
            step.matrix[i][i] += 1; // the prior
            step.gradient[i] -= moved[i];
        }
        if (!invert_symmetric(step.matrix[0], kAll))
            fail(Status::argument, "{sky}: the normal equations of the elements are singular");
        longest = 0;
        for (size_t i = 0; i < kAll; i++) {
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
                     "{separations_arcsec}: the fit moves %s by %.3g standard deviations: must be at most 10; check "
                     "system, unit (arcsec), times and plate scale",
                     kNames[i], std::fabs(moved[i]));
        const Orbit &orbit = out.system.value.orbit;
        if (!(orbit.eccentricity >= 0 && orbit.eccentricity <= kMostEccentricity && orbit.period_years > 0 &&
              orbit.semi_major_arcsec > 0 && orbit.inclination_deg >= 0 && orbit.inclination_deg <= 180))
            fail(Status::argument,
                 "{separations_arcsec}: no orbit near that of the system has them: eccentricity %g, "
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
        fail(Status::argument, "{separations_arcsec}: the fit does not converge");
    const Step last = step_at(Predictor(out.system, reference), measurements, sigma, out.scale);
    const auto count = static_cast<double>(std::max<size_t>(measurements.size(), 1));
    out.chi_square = last.chi_square / count;
    out.rms_arcsec = std::sqrt(last.squares / count);
    return out;
}

} // namespace toliman::sky
