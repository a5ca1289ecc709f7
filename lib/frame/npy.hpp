// Headers and numbers of NumPy's .npy files. tools/cli compiles it too: standard library only, and no error.hpp.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace toliman {

struct NpyHeader {
    std::string type;          // NumPy's dtype without byte order: f4, f8, b1, u1, u2, u4, u8, i2, i4 or i8
    std::vector<size_t> shape; // a length that exceeds size_t is the largest size_t
    size_t size = 0;           // bytes before the numbers, which are in C order and little-endian

    size_t width() const noexcept { return static_cast<size_t>(type[1] - '0'); } // bytes of a number
};

// Reads the header, of format version 1, 2 or 3, by read(data, size), which returns false if fewer bytes are left.
// Returns "", or what is wrong ("unsupported dtype ...").
std::string read_npy_header(const std::function<bool(void *data, size_t size)> &read, NpyHeader &header);

// Converts numbers of a type of NpyHeader.
void convert_npy(const std::string &type, const unsigned char *raw, size_t count, double *values) noexcept;

} // namespace toliman
