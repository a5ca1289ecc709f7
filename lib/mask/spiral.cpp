// Method: the coarseness of a mask is drawn first, uniformly from 1 to 14 cycles along the radius, so that coarse and
// fine masks are equally frequent. Random numbers depend on (seed, k) only: splitmix64 (Steele, Lea, Flood 2014).
#include "mask/spiral.hpp"

#include <cmath>

namespace toliman::mask {

namespace {

// Random numbers that depend on (seed, k) only.
class RandomStream {
  public:
    RandomStream(uint64_t seed, uint64_t k) : state_(seed) {
        state_ = next() ^ k;
        state_ = next();
    }
    double uniform(double low, double high) {
        return low + (high - low) * (static_cast<double>(next() >> 11) * 0x1p-53);
    }
    bool chance(double probability) { return uniform(0, 1) < probability; }
    double whole(double low, double high) { return std::floor(uniform(low, high + 1)); }

  private:
    uint64_t next() {
        uint64_t z = state_ += 0x9e3779b97f4a7c15;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
        z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
        return z ^ (z >> 31);
    }
    uint64_t state_;
};

} // namespace

std::vector<SpiralTerm> draw_terms(uint64_t seed, uint64_t k) {
    constexpr double turn = 6.2831; // not 2 pi to the last digit: that would change the mask of every (seed, k)
    RandomStream random(seed, k);
    std::vector<SpiralTerm> terms(static_cast<size_t>(random.whole(2, 6)));
    const double coarse = random.uniform(1, 14), most = std::floor(2 * coarse) + 1;
    for (SpiralTerm &term : terms) {
        term.a = random.uniform(0.4, 1);
        term.f = random.uniform(0, coarse);
        term.l = random.chance(0.5) ? random.uniform(-12, 12) : 0;
        term.m = random.whole(-most, most);
        term.p = random.uniform(0, turn);
    }
    return terms;
}

} // namespace toliman::mask
