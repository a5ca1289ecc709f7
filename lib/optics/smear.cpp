// Method: while the image moves along a path of length L, with its place (L/2) t at t in [-1, 1], the frame is the mean
//     I_L(x) = integral of I(x - (L/2) t d) p(t) dt,   d the direction,
// over the density p of places: 1/2 for uniform motion, 1/(pi sqrt(1 - t^2)) for whole periods of a sinusoid. Its
// transfer function is sinc(f L) or J_0(pi f L), f the frequency along d. A Gauss quadrature of n nodes (Legendre,
// Chebyshev) makes it a sum of cos(2 pi f a) over displacements a, which are products of filters along x and y
// (pixel.cpp); sinc and J_0 of f_x d_x + f_y d_y are not.
// Error: of the mean of cos(z t) with z = pi f L, at most 2 (z/2)^(2 n)/(2 n)! for both rules, from their remainders.
// The weights are positive and sum to 1, so that nothing cancels.
// Derivative: by parts, with the second derivative I'' of the image along d,
//     dI_L/d(L^2) = 1/16 integral of (1 - t^2) I''(x - (L/2) t d) p(t) dt    (1/8 for a sinusoid),
// which exists at L = 0, I''/24 and I''/16: half the variance of the places, over L^2, as for jitter.
// Reference: Davis and Rabinowitz 1984, Methods of Numerical Integration, sections 2.7 and 4.3.
#include "optics/smear.hpp"

#include <cmath>

#include "base/constants.hpp"

namespace toliman::optics {

namespace {

constexpr size_t kMostNodes = 1000;

// Node i = 0 ... of n on [0, 1], from 1 downwards, with the weight of both signs.
Path::Node chebyshev_node(size_t n, size_t i) noexcept {
    return {std::cos(kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(n)), 2 / static_cast<double>(n)};
}

// Newton's method from an approximation of the root of P_n; the weight of a node is 2/((1 - t^2) P_n'(t)^2), half of it
// for a density of 1/2.
Path::Node legendre_node(size_t n, size_t i) noexcept {
    constexpr int kIterations = 10; // converges quadratically; 5 suffice
    const auto order = static_cast<double>(n);
    double t = std::cos(kPi * (static_cast<double>(i) + 0.75) / (order + 0.5)), slope = 1;
    for (int iteration = 0; iteration < kIterations; iteration++) {
        double last = 1, now = t;
        for (size_t k = 2; k <= n; k++) {
            const auto degree = static_cast<double>(k);
            const double next = ((2 * degree - 1) * t * now - (degree - 1) * last) / degree;
            last = now;
            now = next;
        }
        slope = order * (last - t * now) / (1 - t * t);
        t -= now / slope;
    }
    return {t, 2 / ((1 - t * t) * slope * slope)};
}

// An exact 0 along an axis, so that one filter suffices there.
double component(double value) noexcept {
    constexpr double kZero = 1e-15;
    return std::fabs(value) < kZero ? 0 : value;
}

// One node more than the mean needs, for the factor 1 - t^2 of its derivative.
Path quadrature(const Smear &smear, double cutoff, double accuracy) {
    const double half = kPi * cutoff * smear.length_px / 2, angle = smear.angle_deg * kPi / 180;
    Path path;
    path.x = component(std::cos(angle));
    path.y = component(std::sin(angle));
    double error = 2;
    size_t n = 0;
    while (n < kMostNodes && !(error <= accuracy)) {
        n++;
        const auto order = static_cast<double>(2 * n);
        error *= half * half / (order * (order - 1));
    }
    path.error = error;
    n++;
    for (size_t i = 0; 2 * i < n; i++) {
        Path::Node node = smear.kind == Smear::Kind::linear ? legendre_node(n, i) : chebyshev_node(n, i);
        if (2 * i + 1 == n) // its own mirror image
            node = {0, node.weight / 2};
        path.nodes.push_back(node);
    }
    return path;
}

void scale_to(double half_length, Path &path) noexcept {
    for (Path::Node &node : path.nodes)
        node.at *= half_length;
}

} // namespace

Path path_of(const Smear &smear, double cutoff, double accuracy) {
    if (smear.length_px == 0)
        return {};
    Path path = quadrature(smear, cutoff, accuracy);
    scale_to(smear.length_px / 2, path);
    return path;
}

Path path_of_rate(const Smear &smear, double cutoff, double accuracy) {
    Path path = quadrature(smear, cutoff, accuracy);
    for (Path::Node &node : path.nodes)
        node.weight *= (1 - node.at * node.at) / (smear.kind == Smear::Kind::linear ? 16 : 8);
    scale_to(smear.length_px / 2, path);
    return path;
}

} // namespace toliman::optics
