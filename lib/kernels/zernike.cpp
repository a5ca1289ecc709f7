// Method: with n and m the radial and angular orders of Noll's index and r, theta the polar coordinates of (x, y),
//     Z = sqrt((2 - delta_m0)(n + 1)) P_((n - m)/2)^(0, m)(2 r^2 - 1) r^m {cos, sin}(m theta)
// P is a Jacobi polynomial by its three-term recurrence. The usual sum of powers of r has large coefficients of
// alternating sign and cancels at high orders. r^m cos and r^m sin are powers of x + i y: no arctangent, and smooth at
// the centre.
//
// Reference: Noll (1976), J. Opt. Soc. Am. 66, 207; Abramowitz and Stegun (1964), 22.7.1.
#include "kernels/zernike.hpp"

#include <cmath>

namespace toliman::kernels {

namespace {

// Jacobi polynomial P_k of orders (0, m) at t.
double jacobi(int k, double m, double t) noexcept {
    double before = 1, value = 0.5 * ((m + 2) * t - m);
    if (k == 0)
        return before;
    for (int i = 2; i <= k; i++) {
        const double s = 2.0 * i + m;
        const double next = ((s - 1) * (s * (s - 2) * t - m * m) * value - 2 * (i - 1) * (i + m - 1) * s * before) /
                            (2 * i * (i + m) * (s - 2));
        before = value;
        value = next;
    }
    return value;
}

} // namespace

double zernike(int noll, double x, double y) noexcept {
    if (noll < 1 || noll > kLargestNoll)
        return std::nan("");
    int n = 0, index = noll - 1; // radial order, and index among its n + 1 polynomials
    while (index > n)
        index -= ++n;
    const int m = n % 2 == 0 ? (index + 1) / 2 * 2 : index / 2 * 2 + 1; // angular order
    double cosine = 1, sine = 0;                                        // r^m cos(m theta), r^m sin(m theta)
    for (int i = 0; i < m; i++) {
        const double next = cosine * x - sine * y;
        sine = cosine * y + sine * x;
        cosine = next;
    }
    const double radial = std::sqrt((m == 0 ? 1.0 : 2.0) * (n + 1)) * jacobi((n - m) / 2, m, 2 * (x * x + y * y) - 1);
    return radial * (noll % 2 == 0 || m == 0 ? cosine : sine);
}

} // namespace toliman::kernels
