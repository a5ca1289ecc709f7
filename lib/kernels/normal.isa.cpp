// Method: sums run in eight lanes along the row, in a fixed order and without contraction: the same bits on every
// instruction set. Partial sums of 2^16 pixels in double precision are known to 1e-13 of the sum of their magnitudes,
// which is 1e-8 of the noise of a gradient.
#include "kernels/normal.hpp"

#include <cmath>

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

typedef double Vector __attribute__((vector_size(64), aligned(8), may_alias));
constexpr size_t kColumns = 4; // products with one line at a time
constexpr double kSaturationSigmas = 5;

// Pointers: clang takes a reference to be aligned as the vector, not as its typedef.
const Vector *at(const double *from) noexcept {
    return reinterpret_cast<const Vector *>(from);
}
Vector *at(double *from) noexcept {
    return reinterpret_cast<Vector *>(from);
}

bool weigh(const double *counts, const double *light, const double *response, const CountModel &how, double blend,
           size_t n, double *weight, double *residual, size_t *used, size_t *saturated) noexcept {
    double unfinite = 0, in = 0, out = 0;
    for (size_t i = 0; i < n; i++) {
        unfinite += counts[i] - counts[i]; // NaN if one is not finite
        const double electrons = (counts[i] - how.bias) * how.e_per_count;
        const double factor = response[i];
        const double expected = factor * light[i] + how.dark, mean = expected + blend * (electrons - expected);
        double variance = (mean > 0 ? mean : 0) + how.added_variance;
        variance = variance > how.floor ? variance : how.floor;
        const double margin = how.limit - expected, reach = kSaturationSigmas * kSaturationSigmas * variance;
        const bool below = (electrons < how.limit) & (margin > 0) & (margin * margin > reach),
                   use = below & (factor > 0);
        weight[i] = use ? factor * factor / variance : 0;
        residual[i] = use ? (electrons - expected) / factor : 0;
        in += use ? 1 : 0;
        out += (below | !(factor > 0)) ? 0 : 1;
    }
    *used += static_cast<size_t>(in);
    *saturated += static_cast<size_t>(out);
    return unfinite == 0;
}

void largest(const double *weight, const double *residual, double tail, size_t n, double *square,
             double *excess) noexcept {
    const Vector zero = {}, tails = tail - zero;
    Vector most = *square - zero, beyond = *excess - zero;
    const auto take = [&](const Vector &weights, const Vector &value) {
        const Vector weighted = weights * value, of_square = weighted * value;
        const Vector of_excess = weighted * (value - (value > zero ? tails : zero));
        most = of_square > most ? of_square : most;
        beyond = of_excess > beyond ? of_excess : beyond;
    };
    size_t i = 0;
    for (; i + kNormalLanes <= n; i += kNormalLanes) {
        const Vector weights = *at(weight + i), value = *at(residual + i); // as a reference is taken to be aligned
        take(weights, value);
    }
    for (; i < n; i++)
        take(weight[i] - zero, residual[i] - zero);
    for (size_t lane = 0; lane < kNormalLanes; lane++) {
        *square = most[lane] > *square ? most[lane] : *square;
        *excess = beyond[lane] > *excess ? beyond[lane] : *excess;
    }
}

template <size_t Columns>
void products(const double *line, const double *const *others, size_t n, double *const *sums) noexcept {
    Vector sum[Columns];
    for (size_t c = 0; c < Columns; c++)
        sum[c] = *at(sums[c]);
    size_t i = 0;
    for (; i + kNormalLanes <= n; i += kNormalLanes) {
        const Vector value = *at(line + i);
        for (size_t c = 0; c < Columns; c++)
            sum[c] += value * *at(others[c] + i);
    }
    for (size_t c = 0; c < Columns; c++)
        *at(sums[c]) = sum[c];
    for (size_t lane = 0; i + lane < n; lane++)
        for (size_t c = 0; c < Columns; c++)
            sums[c][lane] += line[i + lane] * others[c][i + lane];
}

void add(const double *const *lines, size_t count, const double *weight, size_t n, double *scratch,
         double *sums) noexcept {
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < n; k++)
            scratch[k] = weight[k] * lines[i][k];
        double *into[kColumns];
        size_t j = i;
        for (; j + kColumns <= count; j += kColumns) {
            for (size_t c = 0; c < kColumns; c++)
                into[c] = sums + (i * count + j + c) * kNormalLanes;
            products<kColumns>(scratch, lines + j, n, into);
        }
        for (; j < count; j++) {
            into[0] = sums + (i * count + j) * kNormalLanes;
            products<1>(scratch, lines + j, n, into);
        }
    }
}
void whiten(double *weight, const double *residual, const double *light, const double *predicted, size_t n,
            double *image) noexcept {
    for (size_t i = 0; i < n; i++) {
        weight[i] = std::sqrt(weight[i]);
        image[i] = weight[i] * (residual[i] + (light[i] - predicted[i]));
    }
}

void correlate(const double *const *lines, size_t count, const double *root, const double *filter, size_t n,
               double *scratch, double *sums) noexcept {
    for (size_t i = 0; i < n; i++)
        scratch[i] = root[i] > 0 ? filter[i] : 0;
    double *into[kColumns] = {sums + count * kNormalLanes};
    const double *const self[] = {scratch};
    products<1>(scratch, self, n, into);
    for (size_t i = 0; i < n; i++)
        scratch[i] *= root[i];
    size_t j = 0;
    for (; j + kColumns <= count; j += kColumns) {
        for (size_t c = 0; c < kColumns; c++)
            into[c] = sums + (j + c) * kNormalLanes;
        products<kColumns>(scratch, lines + j, n, into);
    }
    for (; j < count; j++) {
        into[0] = sums + j * kNormalLanes;
        products<1>(scratch, lines + j, n, into);
    }
}

} // namespace
} // namespace TOLIMAN_ISA

const NormalKernels TOLIMAN_ISA_TABLE(normal) = {TOLIMAN_ISA::weigh, TOLIMAN_ISA::largest, TOLIMAN_ISA::add,
                                                 TOLIMAN_ISA::whiten, TOLIMAN_ISA::correlate};

} // namespace toliman::kernels
