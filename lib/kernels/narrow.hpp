// Numbers of 16 bits, and float32 without its slow end: rounding to the nearest, ties to even.
#pragma once
#include <cstdint>

namespace toliman::kernels {

// Given     value, finite
// Returned  the nearest float32; 0 for what is below 2^-126, the least normal one
// Notes     Subnormal numbers slow the arithmetic down and carry nothing here.
float to_float32(double value) noexcept;

// bfloat16, the upper half of a float32: 8 bits of precision and the whole range.
// Given     value, finite
// Returned  its bits; infinity for what rounds beyond the largest
uint16_t to_bf16(float value) noexcept;
float from_bf16(uint16_t bits) noexcept;

// IEEE binary16: 11 bits of precision, steps of 2^-24 below 2^-14, at most 65504.
// Given     value, finite
// Returned  its bits; infinity from 65520 on
uint16_t to_fp16(double value) noexcept;
double from_fp16(uint16_t bits) noexcept;

} // namespace toliman::kernels
