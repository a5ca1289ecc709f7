// Method: an image S without frequencies above f_c is interpolated as
//     S(u) = sum over samples j of a_j g(u - j),   A(f) = S(f)/G(f),
// where g is a window of a few samples, G its transform and A the spectrum of the coefficients a_j. The only errors
// are aliases: frequency f also appears at f + m with the factor G(f + m)/G(f), m = +-1, +-2, ... The Kaiser-Bessel
// window
//     g(x) = I_0(beta sqrt(1 - (2 x/T)^2)),   G(f) = T sinh(z)/z,   z = sqrt(beta^2 - (pi T f)^2)
// is within a small factor of the window with the smallest aliases: with T taps they fall as exp(-pi T sqrt(1 - 2
// f_c)). beta is 0.97 of the value that ends the main lobe of G at the first alias, 1 - f_c (the best of five, T = 4
// ... 28). Largest alias, f_c = 0.21: 1.7e-7 for T = 8, 1.3e-9 for 10, 1.7e-11 for 12; f_c = 0.3: 5e-10 for 14.
// Interpolation without the division by G takes about three times the taps.
// I_0 and its derivatives are power series of positive terms.
// Reference: Kaiser and Schafer 1980, IEEE Trans. ASSP 28, 105; Fourmont 2003, J. Fourier Anal. Appl. 9, 431.
#include "kernels/shift.hpp"

#include <cmath>

#include "base/constants.hpp"

namespace toliman::kernels {

namespace {

constexpr double kShape = 0.97;
constexpr int kAliases = 64, kFrequencies = 32;

// I_0(2 sqrt(z)) = sum over k of z^k/(k!)^2, and its first two derivatives by z; z <= 2600.
void bessel(double z, double *value) noexcept {
    double term = 1;
    value[0] = value[1] = value[2] = 0;
    for (int k = 1; k == 1 || term > 1e-18 * value[2] || k * k < z; k++) { // terms rise until k = sqrt(z)
        value[0] += term;
        value[1] += term / k;
        value[2] += term / (k * (k + 1.0));
        term *= z / (static_cast<double>(k) * k);
    }
}

double sinhc(double square) noexcept { // of the square root of its argument
    const double root = std::sqrt(std::fabs(square));
    if (root < 1e-4)
        return 1 + square / 6;
    return (square > 0 ? std::sinh(root) : std::sin(root)) / root;
}

} // namespace

Window Window::make(size_t taps, double cutoff) noexcept {
    return of(taps, kShape * kPi * static_cast<double>(taps) * (1 - cutoff));
}

Window Window::of(size_t taps, double beta) noexcept {
    double value[kShiftOrders];
    bessel(beta * beta / 4, value);
    return {taps, beta, value[0]};
}

void Window::weights(double fraction, size_t orders, double *weights) const noexcept {
    double at[kShiftOrders];
    const double half = 0.5 * static_cast<double>(taps), scale = beta / (2 * half);
    for (size_t t = 0; t < taps; t++) {
        const double distance = fraction + half - 1 - static_cast<double>(t);
        // z = (beta/2)^2 (1 - (distance/half)^2), and its derivatives by the distance
        const double z = scale * scale * (half - distance) * (half + distance), slope = -2 * scale * scale * distance,
                     curve = -2 * scale * scale;
        bessel(z, at);
        weights[t] = at[0] / peak;
        if (orders > 1)
            weights[kMostTaps + t] = at[1] * slope / peak;
        if (orders > 2)
            weights[2 * kMostTaps + t] = (at[2] * slope * slope + at[1] * curve) / peak;
    }
}

double Window::transform(double frequency) const noexcept {
    const double phase = kPi * static_cast<double>(taps) * frequency;
    return static_cast<double>(taps) * sinhc((beta - phase) * (beta + phase)) / peak;
}

double Window::error(double cutoff) const noexcept {
    double worst = 0;
    for (int i = 0; i <= kFrequencies; i++) {
        const double frequency = cutoff * i / kFrequencies;
        double sum = 0;
        for (int m = 1; m <= kAliases; m++)
            sum += std::fabs(transform(m - frequency)) + std::fabs(transform(m + frequency));
        worst = std::fmax(worst, sum / transform(frequency));
    }
    return worst;
}

} // namespace toliman::kernels
