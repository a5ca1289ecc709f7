// Headers of NumPy .npy files: float64 out, the usual numbers in.
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
    std::string type; // numpy's type text without byte order, e.g. "f8"
    std::vector<size_t> shape;
    size_t size; // bytes before the numbers
};

// Leaves the file where the numbers start.
NpyHeader read_npy_header(InputFile &file);

} // namespace cli
