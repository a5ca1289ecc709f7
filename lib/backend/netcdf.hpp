// netCDF-4 files. The library netCDF is loaded when the first file is opened, because it brings HDF5, curl and OpenSSL
// into a process that may never read one.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace toliman::netcdf {

// Version of the loaded library; "" if this library was built without it, or if it is not installed.
const char *version();

// netCDF has global state: calls from several threads wait for each other. All names are those of the file. Failures
// are Status::format with the path.
class File {
  public:
    // Status::not_found if there is no such file; Status::unsupported without the library; Status::format for another
    // file than HDF5.
    explicit File(const std::string &path);
    ~File();
    File(const File &) = delete;
    File &operator=(const File &) = delete;

    bool has(const char *variable) const;
    // Lengths of the dimensions of a variable of integers, or of numbers. Refuses chunks above 256 MiB.
    std::vector<size_t> shape(const char *variable, bool integers) const;
    // The whole vector, or a block of a variable: start and count of each dimension. Numbers that do not fit are
    // refused.
    void read(const char *variable, const size_t *start, const size_t *count, int32_t *values) const;
    void read(const char *variable, const size_t *start, const size_t *count, int64_t *values) const;
    void read(const char *variable, const size_t *start, const size_t *count, double *values) const;

    // Attributes of the file, or of a variable; empty if there is none of this kind.
    std::optional<std::string> text(const std::string &attribute) const;
    std::optional<double> number(const std::string &attribute, const char *variable = nullptr) const;
    const char *path() const noexcept { return path_.c_str(); }

  private:
    int id_of(const char *variable) const;
    void check(int status, const char *what) const;
    std::string path_;
    int file_ = -1;
};

} // namespace toliman::netcdf
