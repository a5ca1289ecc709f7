// Method: sums over frames of photons times x^a y^b, a + b <= 6, in 128-bit integers. x and y carry the error e of the
// registration, independent of the place and nearly Gaussian: it adds its covariance to that of the places, which is
// subtracted, and nothing to cumulants of higher order. Places are at most 16 px from the predicted one, so that a
// number is below 2^24 and a term below 2^(30 + 24 + 36); 2^37 frames fit.
#include <cmath>

#include "coadd/moments.hpp"

namespace toliman::coadd {

void WeightedSum::save(ByteWriter &out) const {
    out.u64(static_cast<uint64_t>(sum_));
    out.i64(static_cast<int64_t>(sum_ >> 64));
}

void WeightedSum::load(ByteReader &in) {
    const uint64_t low = in.u64();
    sum_ = static_cast<Wide>(in.i64()) * (static_cast<Wide>(1) << 64) + static_cast<Wide>(low);
}

void Moments::add(int64_t photons, double x, double y, double xx, double xy, double yy) noexcept {
    double power_x[fit::kSpreadOrder + 1] = {1}, power_y[fit::kSpreadOrder + 1] = {1};
    for (size_t i = 0; i < fit::kSpreadOrder; i++) {
        power_x[i + 1] = power_x[i] * x;
        power_y[i + 1] = power_y[i] * y;
    }
    for (size_t n = 0; n <= fit::kSpreadOrder; n++)
        for (size_t b = 0; b <= n; b++)
            sums_[fit::term_of(n - b, b)].add(photons, power_x[n - b] * power_y[b]);
    noise_[0].add(photons, xx);
    noise_[1].add(photons, xy);
    noise_[2].add(photons, yy);
}

void Moments::mean(int64_t photons, double *place) const noexcept {
    place[0] = static_cast<double>(sums_[fit::term_of(1, 0)].over(photons));
    place[1] = static_cast<double>(sums_[fit::term_of(0, 1)].over(photons));
}

Spread Moments::spread(int64_t photons) const noexcept {
    fit::Series moments;
    for (size_t i = 0; i < fit::kSpreadTerms; i++)
        moments[i] = sums_[i].over(photons);
    const fit::Series cumulants = fit::cumulants_of(moments);
    Spread spread;
    const auto covariance = [&](size_t a, size_t b, size_t noise) {
        return static_cast<double>(cumulants[fit::term_of(a, b)]) - registered(noise, photons);
    };
    spread.xx = std::fmax(0, covariance(2, 0, 0));
    spread.yy = std::fmax(0, covariance(0, 2, 2));
    const double most = std::sqrt(spread.xx * spread.yy);
    spread.xy = std::fmin(most, std::fmax(-most, covariance(1, 1, 1)));
    for (size_t i = 0; i < kCumulants && spread.xx + spread.yy > 0; i++) // without motion, those of the registration
        spread.cumulants[i] = static_cast<double>(cumulants[fit::kSpreadTerms - kCumulants + i]);
    return spread;
}

void Moments::save(ByteWriter &out) const {
    for (const WeightedSum &sum : sums_)
        sum.save(out);
    for (const WeightedSum &sum : noise_)
        sum.save(out);
}

void Moments::load(ByteReader &in) {
    for (WeightedSum &sum : sums_)
        sum.load(in);
    for (WeightedSum &sum : noise_)
        sum.load(in);
}

} // namespace toliman::coadd
