// C interface of the interpolation window and its sums.
#include "kernels/shift.hpp"

using namespace toliman::kernels;

extern "C" double shim_shift_beta(size_t taps, double cutoff) {
    return Window::make(taps, cutoff).beta;
}

extern "C" void shim_shift_weights(size_t taps, double beta, double fraction, double *weights) {
    Window::of(taps, beta).weights(fraction, kShiftOrders, weights);
}

extern "C" double shim_shift_transform(size_t taps, double beta, double frequency) {
    return Window::of(taps, beta).transform(frequency);
}

extern "C" double shim_shift_error(size_t taps, double beta, double cutoff) {
    return Window::of(taps, beta).error(cutoff);
}

extern "C" int shim_shift_isas(void) {
    return static_cast<int>(host_isa()) + 1;
}

namespace {

const ShiftKernels &kernels_of(int isa) {
#if defined(__x86_64__)
    const ShiftKernels *tables[] = {&shift_baseline, &shift_avx2, &shift_avx512};
#else
    const ShiftKernels *tables[] = {&shift_baseline};
#endif
    return *tables[isa];
}

} // namespace

extern "C" void shim_shift_sum(int isa, const double *samples, const size_t *offset, const double *weights,
                               size_t orders, size_t taps, size_t count, double *const *out) {
    kernels_of(isa).sum(samples, offset, weights, orders, taps, count, out);
}

extern "C" void shim_shift_spread(int isa, const double *values, const size_t *offset, const double *weights,
                                  size_t taps, size_t count, double *samples) {
    kernels_of(isa).spread(values, offset, weights, taps, count, samples);
}
