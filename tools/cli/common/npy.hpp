// Headers of NumPy .npy files: writes float64, reads the common number types.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "common/input.hpp"
#include "common/output.hpp"

namespace cli {

// Header of a C-order little-endian float64 array; the numbers follow through OutputFile::write.
void write_npy_header(OutputFile &out, const std::vector<size_t> &shape);

struct NpyHeader {
    std::string type; // NumPy's dtype without byte order, e.g. "f8"
    std::vector<size_t> shape;
    size_t size; // bytes before the numbers
};

// Reads the header; the file is then positioned at the first number.
NpyHeader read_npy_header(InputFile &file);

} // namespace cli
