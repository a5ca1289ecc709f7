// Quad precision, 113 bits of mantissa, for a few scalars whose difference would cancel in double. Emulated in software
// on x86-64, so not for arrays.
#pragma once
#include <cmath>

namespace toliman {

#if defined(__x86_64__)
#define TOLIMAN_QUAD_IS_WIDER // than long double: templates are instantiated for both
__extension__ using Quad = __float128;
#else
using Quad = long double;
#endif

inline long double root(long double x) noexcept {
    return std::sqrt(x);
}

#ifdef TOLIMAN_QUAD_IS_WIDER
// One Newton step from the root in long double: accurate to 113 bits.
inline Quad root(Quad x) noexcept {
    const Quad near = std::sqrt(static_cast<long double>(x));
    return near > 0 ? (near + x / near) / 2 : near;
}
#endif

} // namespace toliman
