// FNV-1a, 64 bit: identity digests of layouts, scenes and grids. Not used as a checksum (files have a CRC32) and not
// cryptographic.
#pragma once
#include <cstddef>
#include <cstdint>

namespace toliman {

constexpr uint64_t kFnvOffset = 0xcbf29ce484222325u;

constexpr uint64_t fnv1a(const char *text, size_t size, uint64_t hash = kFnvOffset) noexcept {
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ static_cast<uint8_t>(text[i])) * 0x100000001b3u;
    return hash;
}

// Hash of a number's eight bytes, lowest first.
constexpr uint64_t fnv1a(uint64_t number, uint64_t hash) noexcept {
    for (int i = 0; i < 8; i++)
        hash = (hash ^ (number >> (8 * i) & 0xff)) * 0x100000001b3u;
    return hash;
}

// Hash of an array's bytes.
template <class Array> uint64_t fnv1a(const Array &numbers, uint64_t hash) noexcept {
    return fnv1a(reinterpret_cast<const char *>(numbers.data()), numbers.size() * sizeof numbers[0], hash);
}

} // namespace toliman
