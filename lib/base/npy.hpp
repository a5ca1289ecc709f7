// NumPy's .npy files: two-dimensional arrays of the types a mask can have.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace toliman {

struct NpyImage {
    size_t rows = 0, cols = 0;
    std::vector<double> values; // C order
};

// Reads format versions 1 to 3, C order, little-endian float32 and float64, uint8 and bool. Status::format otherwise;
// source names the file in messages.
NpyImage parse_npy(const std::vector<uint8_t> &bytes, const std::string &source);

} // namespace toliman
