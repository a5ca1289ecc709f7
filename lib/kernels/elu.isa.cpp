#include "kernels/elu.hpp"

#include "kernels/elu_row.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

void slope(const float *values, size_t count, float *gradient) noexcept {
    for (size_t i = 0; i < count; i++)
        gradient[i] *= values[i] > 0 ? 1.0f : values[i] + 1.0f;
}

// Sums in float32 over runs of pixels and in double over the runs. Adjacent pixels fill the vector lanes.
void sum_pixels(const float *image, size_t count, size_t channels, float *sums) noexcept {
    constexpr size_t kLanes = 64, kRun = 32;
    double total[kLanes] = {};
    const size_t whole = count / kLanes * kLanes;
    for (size_t i = 0; i < whole; i += kRun * kLanes) {
        const size_t end = whole - i < kRun * kLanes ? whole : i + kRun * kLanes;
        float part[kLanes] = {};
        for (size_t at = i; at < end; at += kLanes)
            for (size_t k = 0; k < kLanes; k++)
                part[k] += image[at + k];
        for (size_t k = 0; k < kLanes; k++)
            total[k] += static_cast<double>(part[k]);
    }
    for (size_t at = whole; at < count; at++)
        total[at - whole] += static_cast<double>(image[at]);
    for (size_t k = 0; k < kLanes; k++)
        sums[k % channels] += static_cast<float>(total[k]);
}

} // namespace
} // namespace TOLIMAN_ISA

const EluKernels TOLIMAN_ISA_TABLE(elu) = {TOLIMAN_ISA::elu, TOLIMAN_ISA::slope, TOLIMAN_ISA::sum_pixels};

} // namespace toliman::kernels
