// Test of many numbers for infinity and NaN, without branches.
#pragma once
#include <cstdint>

namespace toliman::kernels {

// 1 for infinity and NaN, whose exponent bits are all set; 0 for a finite number. Static, so that each file keeps the
// copy of its own instruction set (kernels/isa.hpp).
static inline uint64_t not_finite(double value) noexcept {
    uint64_t bits;
    __builtin_memcpy(&bits, &value, sizeof bits);
    return (bits & 0x7ff0000000000000u) == 0x7ff0000000000000u;
}

} // namespace toliman::kernels
