// zlib: CRC32, deflate, inflate into a buffer of exactly the known size, and gzip files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace toliman::zip {

// CRC32 of the data; `before` is the CRC32 of preceding data.
uint32_t crc32(const void *data, size_t size, uint32_t before = 0) noexcept;

std::vector<uint8_t> deflate(const void *data, size_t size);

// Inflates to `size` bytes. Status::format unless the stream ends after exactly these and all input is consumed; memory
// is only allocated for a size that the input can have.
std::vector<uint8_t> inflate(const void *packed, size_t packed_size, size_t size, const char *kind);

// Whether data begin as a gzip file.
bool is_gzip(const std::vector<uint8_t> &data) noexcept;

// The content of a gzip file, of at most `limit` bytes. Status::format, with the path, if it is damaged or larger.
std::vector<uint8_t> gunzip(const std::vector<uint8_t> &packed, size_t limit, const char *path);

} // namespace toliman::zip
