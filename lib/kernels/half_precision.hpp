// Conversions to bf16 and fp16, and to float32 without subnormals. Rounding to nearest, ties to even.
#pragma once
#include <cstdint>

namespace toliman::kernels {

// Given     value, finite
// Returned  the nearest float32; 0 if that is subnormal (below 2^-126)
// Notes     Arithmetic on subnormal numbers is slow, and weights of that size have no effect.
float to_float32(double value) noexcept;

// bfloat16, the upper half of a float32: 8 bits of precision and the range of float32.
// Given     value, finite
// Returned  its bits; infinity if it rounds beyond the largest number
uint16_t to_bf16(float value) noexcept;
float from_bf16(uint16_t bits) noexcept;

// IEEE binary16: 11 bits of precision; subnormal below 2^-14, in steps of 2^-24; largest number 65504.
// Given     value, finite
// Returned  its bits; infinity from 65520 on
uint16_t to_fp16(double value) noexcept;
double from_fp16(uint16_t bits) noexcept;

} // namespace toliman::kernels
