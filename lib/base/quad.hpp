// Quad precision, 113 bits of mantissa, for a few scalars whose difference would cancel in double. Emulated in software
// on x86-64, so not for arrays.
#pragma once

namespace toliman {

#if defined(__x86_64__)
__extension__ using Quad = __float128;
#else
using Quad = long double;
#endif

} // namespace toliman
