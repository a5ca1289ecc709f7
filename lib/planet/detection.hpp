// Detection of a sinusoid in the residuals of known planets: false alarm probability, upper limits.
#pragma once
#include <cstddef>

#include "period/fap.hpp"
#include "planet/lattice.hpp"

namespace toliman::planet {

// Frequencies with equal steps.
struct Frequencies {
    double first, step;
    size_t count;

    double at(size_t i) const noexcept { return first + step * static_cast<double>(i); }
};

// Those of the search for the highest power: 1/(10 span) apart.
Frequencies detection_grid(const Series &series, const Prior &prior) noexcept;

// Normal equations of a circular orbit along the mean axis.
struct CircularPair {
    double right[2], xx, xy, yy;

    // What the sinusoid takes from the sum of squares; 0 if the functions leave nothing of it.
    double gain() const noexcept;

    // Squared length of what is left of cosine * C + sine * S.
    double square(double cosine, double sine) const noexcept {
        return xx * cosine * cosine + 2 * xy * cosine * sine + yy * sine * sine;
    }
};

CircularPair circular_pair(const Moments &moments) noexcept;

// Of a series whose functions are those of the design.
period::Sampling sampling_of(const Series &series, const Design &design, const Frequencies &grid) noexcept;

class Detection {
  public:
    // fap: that of a detection. The problem and the design must outlive the object.
    Detection(const Problem &problem, const Design &design, double fap);

    const Problem &problem() const noexcept { return problem_; }
    const Design &design() const noexcept { return design_; }
    const Frequencies &grid() const noexcept { return grid_; }
    // log10 of 1 - power at the threshold.
    double log10_threshold() const noexcept { return log10_threshold_; }
    CircularPair pair_at(double frequency) const;

    // log10 of the false alarm probability of the highest power.
    double log10_fap() const;
    // Amplitude of which this share of circular orbits would give a larger gain than the series; infinity if none is.
    double upper(double frequency, double probability) const;

  private:
    const Problem &problem_;
    const Design &design_;
    Frequencies grid_;
    double log10_threshold_;
};

} // namespace toliman::planet
