// Method: the OPD of a polished surface has a power spectrum that falls as a power of the frequency,
//     P(f) = P_0 for f <= 4 cycles per aperture, P_0 (f/4)^-2.5 above,
// with P_0 such that the variance of each cell, the mean of P over all frequencies of the grid, is that of the options.
// A covariance C with this spectrum is a convolution: C^(1/2) z is the inverse transform of sqrt(P) times the transform
// of z. With the unknown z, the prior is the sum of squares of z.
// The transform is periodic: cells at opposite edges of the grid are neighbours for the prior. A round aperture meets
// these edges at four points, so that few cells are correlated by mistake, and the frames outweigh the prior there.
// Piston has no effect on frames, and tilts the same as the places of the stars: both are left to the prior.
// A forward transform takes the place of the inverse one: it has the indices reversed, modulo n.
#include "calibrate/map_prior.hpp"

#include <cmath>

namespace toliman::calibrate {

namespace {

constexpr double kCorner = 4, kSlope = -2.5; // cycles per aperture; exponent above

double power_at(double frequency) noexcept {
    return frequency <= kCorner ? 1 : std::pow(frequency / kCorner, kSlope);
}

} // namespace

MapPrior::MapPrior(size_t n, double rms_m) : n_(n), power_(n * n), fft_(n) {
    double sum = 0;
    const auto frequency = [n](size_t i) { return static_cast<double>(i <= n / 2 ? i : n - i); };
    for (size_t i = 0; i < n * n; i++)
        sum += power_[i] = power_at(std::hypot(frequency(i / n), frequency(i % n)));
    for (double &power : power_)
        power *= rms_m * rms_m * static_cast<double>(n * n) / sum;
}

// gain(i): of a frequency, equal for opposite ones.
template <class Gain> Buffer<double> MapPrior::filtered(const Buffer<double> &map, const Gain &gain) {
    const size_t n = n_;
    std::complex<double> *const data = fft_.data();
    for (size_t i = 0; i < n * n; i++)
        data[i] = map[i];
    fft_.transform();
    for (size_t i = 0; i < n * n; i++)
        data[i] *= gain(i) / static_cast<double>(n * n);
    fft_.transform();
    Buffer<double> result(n * n);
    for (size_t i = 0; i < n * n; i++)
        result[i] = data[(n - i / n) % n * n + (n - i % n) % n].real();
    return result;
}

Buffer<double> MapPrior::opd_of(const Buffer<double> &unknown) {
    return filtered(unknown, [this](size_t i) { return std::sqrt(power_[i]); });
}

Buffer<double> MapPrior::unknown_of(const Buffer<double> &opd_m) {
    return filtered(opd_m, [this](size_t i) { return 1 / std::sqrt(power_[i]); });
}

Buffer<double> MapPrior::preconditioned(const Buffer<double> &unknown, const double (&curvature)[2], double excess) {
    const Parities parts = parities_of(unknown);
    Buffer<double> even = filtered(parts.even, [&](size_t i) { return 1 / (excess + curvature[0] * power_[i]); });
    const Buffer<double> odd = filtered(parts.odd, [&](size_t i) { return 1 / (excess + curvature[1] * power_[i]); });
    for (size_t i = 0; i < even.size(); i++)
        even[i] += odd[i];
    return even;
}

Parities parities_of(const Buffer<double> &map) {
    Parities parts = {map, map};
    for (size_t i = 0; i < map.size(); i++) {
        const double opposite = map[map.size() - 1 - i];
        parts.even[i] = 0.5 * (map[i] + opposite);
        parts.odd[i] = 0.5 * (map[i] - opposite);
    }
    return parts;
}

} // namespace toliman::calibrate
