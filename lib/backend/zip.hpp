// zlib: CRC32, deflate, and inflate into a buffer of exactly the known size.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace toliman::zip {

// CRC32 of the data, or of these after others whose CRC32 was `before`.
uint32_t crc32(const void *data, size_t size, uint32_t before = 0) noexcept;

std::vector<uint8_t> deflate(const void *data, size_t size);

// Inflates exactly `size` bytes into out; Status::format unless the stream ends just there and all input is used.
void inflate(const void *packed, size_t packed_size, void *out, size_t size, const char *kind);

} // namespace toliman::zip
