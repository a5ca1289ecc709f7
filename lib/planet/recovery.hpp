// Which planets a search recovers: of one orbit, by simulated series, and of a range of orbits, by injection.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

#include "kernels/random.hpp"
#include "planet/circular.hpp"
#include "planet/mass.hpp"

namespace toliman::planet {

// Planets to inject; star -1: sizes are amplitudes.
struct InjectionCell {
    int star;
    double period_min, period_max, size_min, size_max;
    bool is_circular;
    size_t count;
    uint64_t seed;
};

// A planet is recovered if CircularSearch calls its series a planet's. Several threads may use an object.
class Recovery {
  public:
    // threshold: log10 of the Bayes factor that a planet needs. The detection must outlive the object.
    Recovery(const Detection &detection, double threshold) : detection_(detection), threshold_(threshold) {}

    const Detection &detection() const noexcept { return detection_; }
    // Amplitude at which a circular orbit is recovered with this probability, in the mean of phases and noises;
    // infinity if there is none.
    double recoverable(double frequency, double probability) const;
    // Number of planets that are recovered from white noise.
    size_t inject(const InjectionCell &cell, const Units &units) const;

  private:
    Buffer<double> injected(const InjectionCell &cell, const Units &units, size_t index, kernels::Rng &rng) const;
    const CircularSearch &whole() const;

    const Detection &detection_;
    double threshold_;
    mutable std::once_flag once_;
    mutable std::unique_ptr<CircularSearch> whole_; // of all frequencies, as it needs much memory
};

} // namespace toliman::planet
