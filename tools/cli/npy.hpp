// NumPy .npy files: float64 out, the usual numbers in.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "output.hpp"

namespace cli {

// Header of a C-order little-endian float64 array; the numbers follow through OutputFile::write.
void write_npy_header(OutputFile &out, const std::vector<size_t> &shape);

// Frames of a headerless or .npy file, one at a time, as double.
class FrameFile {
  public:
    // dtype ("u16le", "u32le") and shape are needed for headerless files only.
    FrameFile(const std::string &path, const std::string &dtype, size_t rows, size_t cols);
    ~FrameFile();
    FrameFile(const FrameFile &) = delete;
    FrameFile &operator=(const FrameFile &) = delete;
    size_t count() const noexcept { return count_; }
    size_t rows() const noexcept { return rows_; }
    size_t cols() const noexcept { return cols_; }
    void read(double *image);

  private:
    void open_npy();
    [[noreturn]] void malformed(const std::string &why) const;
    std::string path_, type_; // numpy's type text without byte order, e.g. "f8"
    size_t count_ = 0, rows_ = 0, cols_ = 0, data_start_ = 0;
    std::FILE *file_ = nullptr;
    std::vector<unsigned char> raw_;
};

} // namespace cli
