// C interface to the half-precision conversions, for the test.
#include "kernels/half_precision.hpp"

extern "C" float shim_to_float32(double value) {
    return toliman::kernels::to_float32(value);
}

extern "C" uint16_t shim_to_bf16(float value) {
    return toliman::kernels::to_bf16(value);
}

extern "C" float shim_from_bf16(uint16_t bits) {
    return toliman::kernels::from_bf16(bits);
}

extern "C" uint16_t shim_to_fp16(double value) {
    return toliman::kernels::to_fp16(value);
}

extern "C" double shim_from_fp16(uint16_t bits) {
    return toliman::kernels::from_fp16(bits);
}
