// zlib: CRC32, deflate, and inflate into a buffer of exactly the known size.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace toliman::zip {

// CRC32 of the data; `before` is the CRC32 of preceding data.
uint32_t crc32(const void *data, size_t size, uint32_t before = 0) noexcept;

std::vector<uint8_t> deflate(const void *data, size_t size);

// Inflates into out[size]. Status::format unless the stream ends after exactly `size` bytes and all input is consumed.
void inflate(const void *packed, size_t packed_size, void *out, size_t size, const char *kind);

} // namespace toliman::zip
