// Method: each block of kBlock outputs accumulates in registers over all taps; the loads are contiguous along the
// image.
#include "kernels/shift.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

typedef double Vector __attribute__((vector_size(64), aligned(8), may_alias));
constexpr size_t kLanes = 8, kVectors = 4;

// Pointers: clang takes a reference to be aligned as the vector, not as its typedef.
const Vector *at(const double *from) noexcept {
    return reinterpret_cast<const Vector *>(from);
}
Vector *at(double *from) noexcept {
    return reinterpret_cast<Vector *>(from);
}

// out[o][i] = sum over t of weights[o][t] samples[offset[t] + i] for the pixels i of a block from `first` on.
template <size_t Orders, size_t Vectors>
void block(const double *samples, const size_t *offset, const double *weights, size_t taps, double *const *out,
           size_t first) noexcept {
    Vector sum[Orders][Vectors] = {};
    for (size_t t = 0; t < taps; t++) {
        const double *const from = samples + offset[t] + first;
        for (size_t v = 0; v < Vectors; v++) {
            const Vector sample = *at(from + v * kLanes);
            for (size_t o = 0; o < Orders; o++)
                sum[o][v] += weights[o * kMostTaps + t] * sample;
        }
    }
    for (size_t o = 0; o < Orders; o++)
        for (size_t v = 0; v < Vectors; v++)
            *at(out[o] + first + v * kLanes) = sum[o][v];
}

template <size_t Orders>
void sum_orders(const double *samples, const size_t *offset, const double *weights, size_t taps, size_t count,
                double *const *out) noexcept {
    size_t i = 0;
    for (; i + kVectors * kLanes <= count; i += kVectors * kLanes)
        block<Orders, kVectors>(samples, offset, weights, taps, out, i);
    for (; i + kLanes <= count; i += kLanes)
        block<Orders, 1>(samples, offset, weights, taps, out, i);
    for (; i < count; i++)
        for (size_t o = 0; o < Orders; o++) {
            double value = 0;
            for (size_t t = 0; t < taps; t++)
                value += weights[o * kMostTaps + t] * samples[offset[t] + i];
            out[o][i] = value;
        }
}

void sum(const double *samples, const size_t *offset, const double *weights, size_t orders, size_t taps, size_t count,
         double *const *out) noexcept {
    (orders == 1   ? sum_orders<1>
     : orders == 2 ? sum_orders<2>
                   : sum_orders<3>)(samples, offset, weights, taps, count, out);
}

void spread(const double *values, const size_t *offset, const double *weights, size_t taps, size_t count,
            double *samples) noexcept {
    for (size_t t = 0; t < taps; t++) {
        double *const to = samples + offset[t];
        size_t i = 0;
        for (; i + kLanes <= count; i += kLanes)
            *at(to + i) += weights[t] * *at(values + i);
        for (; i < count; i++)
            to[i] += weights[t] * values[i];
    }
}

} // namespace
} // namespace TOLIMAN_ISA

const ShiftKernels TOLIMAN_ISA_TABLE(shift) = {TOLIMAN_ISA::sum, TOLIMAN_ISA::spread};

} // namespace toliman::kernels
