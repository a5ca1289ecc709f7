// SHA-1 of a text: the hash of leap-seconds.list, which finds damage. Not for secrets. Reference: FIPS 180-4.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

namespace toliman {

// Five words of 32 bits.
std::array<uint32_t, 5> sha1(std::string_view text);

} // namespace toliman
