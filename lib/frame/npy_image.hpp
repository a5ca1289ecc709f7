// Two-dimensional .npy arrays, as masks and maps are.
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

// Parses a whole file of any type of npy.hpp; Status::format for anything else. `source` names the file in messages.
NpyImage parse_npy(const std::vector<uint8_t> &bytes, const std::string &source);

} // namespace toliman
