#include "npy.hpp"

#include <cerrno>
#include <cstring>
#include <sys/stat.h>

#include "failure.hpp"

namespace cli {

namespace {

constexpr char kMagic[] = "\x93NUMPY";
constexpr size_t kMagicSize = 6, kPrefixSize = 10; // magic, version, u16 length of the header's text

template <class T> void convert(const unsigned char *raw, size_t count, double *out) noexcept {
    for (size_t i = 0; i < count; i++) {
        T value;
        std::memcpy(&value, raw + i * sizeof value, sizeof value);
        out[i] = static_cast<double>(value);
    }
}

size_t size_of(const std::string &type) noexcept {
    return static_cast<size_t>(type[1] - '0');
}

bool known(const std::string &type) noexcept {
    for (const char *name : {"f8", "f4", "u1", "u2", "u4", "u8", "i2", "i4", "i8"})
        if (type == name)
            return true;
    return false;
}

// What stands behind 'key': in the header's dictionary, up to one of the stops.
std::string value_of(const std::string &header, const std::string &key, const char *stops) {
    const size_t at = header.find("'" + key + "':");
    if (at == std::string::npos)
        return "";
    const size_t start = header.find_first_not_of(' ', at + key.size() + 3);
    if (start == std::string::npos)
        return "";
    const size_t end = header.find_first_of(stops, start + 1);
    return end == std::string::npos ? "" : header.substr(start, end - start);
}

} // namespace

void write_npy_header(OutputFile &out, const std::vector<size_t> &shape) {
    std::string text = "{'descr': '<f8', 'fortran_order': False, 'shape': (";
    for (size_t length : shape)
        text += std::to_string(length) + ", ";
    text += "), }";
    text.resize((kPrefixSize + text.size() + 64) / 64 * 64 - kPrefixSize - 1, ' ');
    text += '\n';
    const unsigned char prefix[4] = {1, 0, static_cast<unsigned char>(text.size() & 255),
                                     static_cast<unsigned char>(text.size() >> 8)};
    out.write(kMagic, kMagicSize);
    out.write(prefix, sizeof prefix);
    out.write(text.data(), text.size());
}

FrameFile::FrameFile(const std::string &path, const std::string &dtype, size_t rows, size_t cols)
    : path_(path), rows_(rows), cols_(cols), file_(std::fopen(path.c_str(), "rb")) {
    struct stat facts = {};
    if (file_ == nullptr || ::fstat(::fileno(file_), &facts) != 0)
        throw Failure(kExitInput, path + ": " + std::strerror(errno));
    try {
        if (!S_ISREG(facts.st_mode))
            malformed("not a regular file");
        const bool npy = path.size() > 4 && path.compare(path.size() - 4, 4, ".npy") == 0;
        if (npy) {
            open_npy();
        } else {
            if (dtype != "u16le" && dtype != "u32le")
                throw Failure(kExitUsage,
                              path + ": a headerless file needs --dtype u16le or u32le and --shape ROWSxCOLS");
            if (rows == 0 || cols == 0)
                throw Failure(kExitUsage, path + ": a headerless file needs --shape ROWSxCOLS");
            type_ = dtype == "u16le" ? "u2" : "u4";
            count_ = static_cast<size_t>(facts.st_size) / (rows_ * cols_ * size_of(type_));
        }
        const size_t frame = rows_ * cols_ * size_of(type_);
        if (data_start_ + count_ * frame != static_cast<size_t>(facts.st_size))
            malformed("holds " + std::to_string(facts.st_size) + " bytes, " + std::to_string(count_) + " frames of " +
                      std::to_string(rows_) + "x" + std::to_string(cols_) + " take " +
                      std::to_string(data_start_ + count_ * frame));
        raw_.resize(frame);
    } catch (...) {
        std::fclose(file_);
        throw;
    }
}

FrameFile::~FrameFile() {
    std::fclose(file_);
}

void FrameFile::malformed(const std::string &why) const {
    throw Failure(kExitInput, path_ + ": " + why);
}

void FrameFile::open_npy() {
    unsigned char prefix[kPrefixSize];
    if (std::fread(prefix, 1, kPrefixSize, file_) != kPrefixSize || std::memcmp(prefix, kMagic, kMagicSize) != 0)
        malformed("is not a .npy file");
    if (prefix[6] != 1)
        malformed(".npy version " + std::to_string(prefix[6]) + ": version 1 is read");
    const size_t length = static_cast<size_t>(prefix[8]) + size_t{256} * prefix[9];
    std::string header(length, ' ');
    if (std::fread(header.data(), 1, length, file_) != length)
        malformed("its .npy header is truncated");
    data_start_ = kPrefixSize + length;
    const std::string type = value_of(header, "descr", ","), order = value_of(header, "fortran_order", ",");
    const std::string shape = value_of(header, "shape", ")");
    if (type.size() != 5 || (type[1] != '<' && type[1] != '|') || !known(type.substr(2, 2)))
        malformed("its numbers are " + type + ": little-endian f4 f8 u1 u2 u4 u8 i2 i4 i8 are read");
    if (order != "False")
        malformed("is in Fortran order: C order is read");
    type_ = type.substr(2, 2);
    std::vector<size_t> lengths;
    for (const char *next = shape.c_str(); *next != '\0';) {
        if (*next < '0' || *next > '9') {
            next++;
            continue;
        }
        char *end = nullptr;
        lengths.push_back(std::strtoull(next, &end, 10));
        next = end;
    }
    if (lengths.size() == 2)
        lengths.insert(lengths.begin(), 1);
    if (lengths.size() != 3)
        malformed("has " + std::to_string(lengths.size()) + " axes: frames need 2 or 3");
    for (size_t i = 0; i < 3; i++)
        if (lengths[i] > (size_t{1} << 24) || (i > 0 && lengths[i] == 0))
            malformed("its shape " + shape + ") is impossible");
    count_ = lengths[0];
    rows_ = lengths[1];
    cols_ = lengths[2];
}

void FrameFile::read(double *image) {
    if (std::fread(raw_.data(), 1, raw_.size(), file_) != raw_.size())
        malformed("ends early");
    const size_t n = rows_ * cols_;
    const auto is = [&](const char *type) { return type_ == type; };
    if (is("f8"))
        convert<double>(raw_.data(), n, image);
    else if (is("f4"))
        convert<float>(raw_.data(), n, image);
    else if (is("u1"))
        convert<uint8_t>(raw_.data(), n, image);
    else if (is("u2"))
        convert<uint16_t>(raw_.data(), n, image);
    else if (is("u4"))
        convert<uint32_t>(raw_.data(), n, image);
    else if (is("u8"))
        convert<uint64_t>(raw_.data(), n, image);
    else if (is("i2"))
        convert<int16_t>(raw_.data(), n, image);
    else if (is("i4"))
        convert<int32_t>(raw_.data(), n, image);
    else
        convert<int64_t>(raw_.data(), n, image);
}

} // namespace cli
