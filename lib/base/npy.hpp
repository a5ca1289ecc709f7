// Parser of NumPy's .npy files: two-dimensional arrays of the types that masks use.
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

// Parses format versions 1 to 3 in C order, of little-endian float32 or float64, uint8 or bool; Status::format for
// anything else. `source` names the file in messages.
NpyImage parse_npy(const std::vector<uint8_t> &bytes, const std::string &source);

} // namespace toliman
