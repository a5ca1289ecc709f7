// Which planets a search recovers: by theory, and by injection.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/random.hpp"
#include "planet/detection.hpp"
#include "planet/mass.hpp"

namespace toliman::planet {

// Planets to inject; star -1: sizes are amplitudes.
struct InjectionCell {
    int star;
    double period_min, period_max, size_min, size_max;
    bool circular;
    size_t count;
    uint64_t seed;
};

// A planet is recovered if the highest power reaches the threshold, within kPeriodTolerance of its period.
constexpr double kPeriodTolerance = 0.1;

class Recovery {
  public:
    // The detection must outlive the object.
    explicit Recovery(const Detection &detection);

    // Probability that a circular orbit is recovered, in the mean of phases and noises.
    double efficiency(double frequency, double amplitude) const;
    // Amplitude with this efficiency; infinity if none has it.
    double recoverable(double frequency, double probability) const;
    // Number of planets that are recovered from white noise.
    size_t inject(const InjectionCell &cell, const Units &units) const;

  private:
    struct Target;
    struct Injected;
    Target target_at(double frequency) const;
    double efficiency(const Target &target, double amplitude) const;
    Injected injected(const InjectionCell &cell, const Units &units, size_t index, kernels::Rng &rng) const;

    const Detection &detection_;
    Buffer<double> directions_; // [2 frequencies][rows]: what is left of cosine and sine, whitened and orthonormal
};

} // namespace toliman::planet
