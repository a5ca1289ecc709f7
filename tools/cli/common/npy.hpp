// Headers of NumPy .npy files.
#pragma once
#include "common/common.hpp"
#include "frame/npy.hpp"

namespace cli {

// Header of a C-order little-endian float64 array; the numbers follow through OutputFile::write.
void write_npy_header(OutputFile &out, const std::vector<size_t> &shape);
// The whole file. An empty shape is that of the vector.
void write_npy(OutputFile &out, const std::vector<double> &values, const std::vector<size_t> &shape = {});
void write_npy(OutputFile &out, const std::vector<uint8_t> &values, const std::vector<size_t> &shape);

// Reads the header; the file is then positioned at the first number.
toliman::NpyHeader read_npy_header(InputFile &file);

} // namespace cli
