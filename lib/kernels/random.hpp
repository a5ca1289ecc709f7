// Random numbers one at a time, for initial weights and the like: Philox-4x32-10 by Random123, counter-based.
// Noise of whole images has its own vector form of the same generator: kernels/poisson.hpp.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Random123/philox.h>

namespace toliman::kernels {

// The sequence of (seed, stream); two sequences of different seed or stream share no counter.
class Rng {
  public:
    // stream < 2^16, see kernels/poisson.hpp for those in use
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
    // Reference Box and Muller (1958); the second of each pair is kept for the next call
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
