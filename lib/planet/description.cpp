// Method: errors follow from the covariance of the numbers that are fitted, f, e cos w, e sin w and amplitudes, by
// differences of the description.
#include "planet/description.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/constants.hpp"

namespace toliman::planet {

// At the anomaly M, in turns at the reference time, periastron is at -M/f: the passage nearest to the reference.
Description describe(const Planet &planet) noexcept {
    const Orbit &orbit = planet.orbit;
    return {1 / orbit.frequency, orbit.eccentricity, periastron_of(planet.amplitudes) * 180 / kPi,
            -std::remainder(orbit.anomaly, 1) / orbit.frequency, amplitude_of(planet.amplitudes)};
}

// Square roots of the diagonal of J C J^T, with the covariance C of the fitted numbers and the derivatives J of the
// description by them: central differences over 2e-3 standard deviations. Periastron and epoch are differences on a
// circle.
Description errors_of(const Series &series, const Planet &planet, const Design &design, size_t first, size_t all) {
    const std::vector<double> covariance = design.covariance();
    const size_t count = series.amplitudes() + kOrbitNumbers;
    std::vector<Description> slopes(count);
    for (size_t i = 0; i < count; i++) {
        const double sigma = std::sqrt(covariance[(first + i) * (all + 1)]), size = 1e-3 * sigma;
        if (!(sigma > 0))
            continue;
        std::vector<double> changes(count);
        changes[i] = size;
        const Description more = describe(changed(series, planet, changes.data()));
        changes[i] = -size;
        const Description less = describe(changed(series, planet, changes.data()));
        for (size_t d = 0; d < kDescribed; d++)
            slopes[i][d] = (more[d] - less[d]) / (2 * size);
        slopes[i][2] = std::remainder(more[2] - less[2], 360) / (2 * size);
        slopes[i][3] = std::remainder(more[3] - less[3], more[0]) / (2 * size);
    }
    Description errors = {};
    for (size_t d = 0; d < kDescribed; d++) {
        double variance = 0;
        for (size_t i = 0; i < count; i++)
            for (size_t j = 0; j < count; j++)
                variance += slopes[i][d] * covariance[(first + i) * all + first + j] * slopes[j][d];
        errors[d] = std::sqrt(std::max(variance, 0.0));
    }
    return errors;
}

// s^T (1 - Q Q^T) s / s^T s with the whitened signal s and the orthonormal functions Q: 1 if they describe nothing of
// it.
double power_left(const Series &series, const Design &design, const Planet &planet) {
    Buffer<double> signal = signal_of(series, planet);
    for (size_t i = 0; i < series.n; i++)
        signal[i] *= design.weights()[i];
    Buffer<double> left = signal;
    design.project(left.data());
    double before = 0, after = 0;
    for (size_t i = 0; i < series.n; i++) {
        before += signal[i] * signal[i];
        after += signal[i] * left[i];
    }
    return before > 0 ? std::max(after / before, 0.0) : 0;
}

} // namespace toliman::planet
