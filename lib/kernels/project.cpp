// Method: inner products by Dot2 (project.isa.cpp), which accumulates the rounding errors of every product and of every
// addition and adds them at the end; projections by Gram-Schmidt, done twice. Compensated, because nuisance images are
// nearly parallel to the derivative image and to each other: the small remainder carries the information.
//     |error| <= eps |a.b| + (n eps)^2 |a|.|b|
// Reference: Ogita, Rump and Oishi (2005), SIAM J. Sci. Comput. 26, 1955.
#include "kernels/project.hpp"

#include <cmath>

namespace toliman::kernels {

// Adds the partial sums by two-sum; all rounding errors are added at the end.
double Dot::total() const noexcept {
    double whole = 0, correction = 0;
    for (size_t p = 0; p < kDotParts; p++) {
        const double next = whole + sum[p], shifted = next - whole;
        correction += ((whole - (next - shifted)) + (sum[p] - shifted)) + error[p];
        whole = next;
    }
    return whole + correction;
}

double dot(const double *a, const double *b, size_t n) noexcept {
    Dot dot;
    project_kernels().add(a, b, n, dot);
    return dot.total();
}

void whiten(const double *image, const double *variance, size_t n, double *out) noexcept {
    project_kernels().whiten(image, variance, n, out);
}

void project_out(const double *basis, size_t count, size_t n, double *vector) noexcept {
    for (size_t k = 0; k < count; k++) {
        const double *unit = basis + k * n;
        const double component = dot(unit, vector, n);
        for (size_t i = 0; i < n; i++)
            vector[i] -= component * unit[i];
    }
}

Lengths project_out_twice(const double *basis, size_t count, size_t n, double *vector) noexcept {
    const double before = std::sqrt(dot(vector, vector, n));
    project_out(basis, count, n, vector);
    project_out(basis, count, n, vector);
    const double after = std::sqrt(dot(vector, vector, n));
    return {before, after > kRounding * before ? after : 0};
}

size_t orthonormalise(double *vectors, size_t count, size_t n) noexcept {
    size_t rank = 0;
    for (size_t k = 0; k < count; k++) {
        double *vector = vectors + rank * n;
        for (size_t i = 0; i < n; i++)
            vector[i] = vectors[k * n + i];
        const double after = project_out_twice(vectors, rank, n, vector).after;
        if (after == 0)
            continue;
        for (size_t i = 0; i < n; i++)
            vector[i] /= after;
        rank++;
    }
    return rank;
}

} // namespace toliman::kernels
