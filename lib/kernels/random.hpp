// Scalar random numbers for initial weights, shuffles and bootstraps: Philox-4x32-10 of Random123 (Salmon et al. 2011).
// kernels/poisson.hpp has a vectorised form of the same generator for whole images.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Random123/philox.h>

namespace toliman::kernels {

// The sequence of (seed, stream). Sequences of different seeds or streams share no (key, counter) pair.
class Rng {
  public:
    // stream < 2^16; kernels/poisson.hpp lists the streams in use
    Rng(uint64_t seed, uint32_t stream) noexcept
        : key_{{static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32)}}, stream_(stream) {}

    // Returned  64 random bits
    uint64_t bits() noexcept {
        if (half_ == 0) {
            const r123::Philox4x32::ctr_type counter = {
                {static_cast<uint32_t>(block_), stream_ << 16, static_cast<uint32_t>(block_ >> 32), 0}};
            words_ = r123::Philox4x32()(counter, key_);
            block_++;
        }
        const size_t first = size_t{2} * half_;
        half_ = 1 - half_;
        return words_[first] | static_cast<uint64_t>(words_[first + 1]) << 32;
    }

    // Returned  uniform on the centres of 2^52 cells of (0, 1): never 0 or 1
    double uniform() noexcept { return (static_cast<double>(bits() >> 12) + 0.5) * 0x1p-52; }

    // Returned  a standard normal variate
    // Notes     the second of each pair is returned by the next call
    // Reference Box and Muller (1958), Ann. Math. Statist. 29, 610
    double normal() noexcept {
        if (has_spare_) {
            has_spare_ = false;
            return spare_;
        }
        const double radius = std::sqrt(-2.0 * std::log(uniform()));
        const double angle = 6.283185307179586 * uniform();
        spare_ = radius * std::sin(angle);
        has_spare_ = true;
        return radius * std::cos(angle);
    }

  private:
    r123::Philox4x32::key_type key_;
    r123::Philox4x32::ctr_type words_ = {};
    uint64_t block_ = 0;
    uint32_t stream_;
    uint32_t half_ = 0;
    double spare_ = 0;
    bool has_spare_ = false;
};

} // namespace toliman::kernels
