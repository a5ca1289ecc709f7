// C interface of the interpolation window and its sums.
#include "isa_tables.hpp"
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

extern "C" void shim_shift_sum(int isa, const double *samples, const size_t *offset, const double *weights,
                               size_t orders, size_t taps, size_t count, double *const *out) {
    KERNELS(shift, isa).sum(samples, offset, weights, orders, taps, count, out);
}

extern "C" void shim_shift_spread(int isa, const double *values, const size_t *offset, const double *weights,
                                  size_t taps, size_t count, double *samples) {
    KERNELS(shift, isa).spread(values, offset, weights, taps, count, samples);
}
