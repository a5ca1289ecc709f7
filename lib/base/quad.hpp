// The widest number the compiler has: 113 bits of mantissa. For a handful of scalars whose difference must survive.
#pragma once

namespace toliman {

#if defined(__x86_64__)
__extension__ using Quad = __float128;
#else
using Quad = long double;
#endif

} // namespace toliman
