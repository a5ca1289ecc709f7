// Priors of the parameters that are not marginalised analytically.
#pragma once
#include <vector>

namespace toliman::planet {

struct Prior {
    double frequency_min, frequency_max; // ln frequency is uniform between them
    double eccentricity_max;
    std::vector<double> scales; // of the amplitudes, of equal weight
    double jitter_max = 0;      // 0: no jitter
    double jitter_knee = 0;     // s0 of the density 1/(s + s0)

    // Share of the prior in a range of frequencies.
    double share(double from, double to) const noexcept;
    // Share of the prior of eccentricities from `low` to `high`, and the value at the share `part` of it.
    double eccentricity_share(double low, double high) const noexcept;
    double eccentricity_in(double low, double high, double part) const noexcept;
    // The value at the share u of the prior, in [0, 1].
    double jitter(double u) const noexcept;
};

// Scales from `least` to `most`, with equal ratios.
std::vector<double> scales_between(double least, double most);

// Share of the distribution Beta(0.867, 3.03) below e < 1, times a constant.
double beta_share(double e) noexcept;

} // namespace toliman::planet
