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
    int n = 0, rest = noll - 1; // radial order, and place among its n + 1 polynomials
    while (rest > n)
        rest -= ++n;
    const int m = n % 2 == 0 ? (rest + 1) / 2 * 2 : rest / 2 * 2 + 1; // angular order
    double cosine = 1, sine = 0;                                      // r^m cos(m theta), r^m sin(m theta)
    for (int i = 0; i < m; i++) {
        const double turned = cosine * x - sine * y;
        sine = cosine * y + sine * x;
        cosine = turned;
    }
    const double radial = std::sqrt((m == 0 ? 1.0 : 2.0) * (n + 1)) * jacobi((n - m) / 2, m, 2 * (x * x + y * y) - 1);
    return radial * (noll % 2 == 0 || m == 0 ? cosine : sine);
}

} // namespace toliman::kernels
