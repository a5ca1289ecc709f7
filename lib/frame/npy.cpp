// Method: a .npy file is a magic, a version, the length of a header, the header (a Python dict literal in ASCII with
// descr, fortran_order and shape), then the raw data. The header is searched for its three keys rather than parsed as
// Python. Format: NumPy documentation, numpy.lib.format. The file is input of a user, so every length is checked
// before it is used.
#include "frame/npy.hpp"

#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace toliman {

namespace {

constexpr size_t kLongestHeader = 1 << 20; // NumPy itself reads at most 10,000 bytes

// The text of the header; `complaint` is set if there is none.
std::string header_text(const std::function<bool(void *data, size_t size)> &read, size_t &size,
                        std::string &complaint) {
    const auto refuse = [&](const std::string &why) {
        complaint = why;
        return std::string();
    };
    unsigned char magic[6], version[2], length[4] = {};
    if (!read(magic, sizeof magic) || std::memcmp(magic, "\x93NUMPY", sizeof magic) != 0)
        return refuse("is not a .npy file");
    if (!read(version, sizeof version))
        return refuse("the .npy header is truncated");
    if (version[0] < 1 || version[0] > 3)
        return refuse(".npy format version " + std::to_string(version[0]) + ": must be in [1, 3]");
    const size_t width = version[0] == 1 ? 2 : 4;
    if (!read(length, width))
        return refuse("the .npy header is truncated");
    const size_t bytes = length[0] + (size_t{length[1]} << 8) + (size_t{length[2]} << 16) + (size_t{length[3]} << 24);
    if (bytes > kLongestHeader)
        return refuse("the .npy header has " + std::to_string(bytes) + " bytes: must be at most " +
                      std::to_string(kLongestHeader));
    std::string text(bytes, ' ');
    size = sizeof magic + sizeof version + width + bytes;
    return read(text.data(), bytes) ? text : refuse("the .npy header is truncated");
}

// The address after 'key': and blanks, at most the end of the text; nullptr if there is no such key.
const char *entry(const std::string &text, const char *key) noexcept {
    const size_t at = text.find(key);
    if (at == std::string::npos)
        return nullptr;
    const char *const value = text.c_str() + at + std::strlen(key);
    return value + std::strspn(value, " ");
}

// The type in quotes, at most 20 characters of it; a list describes a structured type.
std::string type_at(const char *descr) {
    return *descr == '\'' ? std::string(descr + 1, std::strcspn(descr + 1, "'")).substr(0, 20) : "structured";
}

bool known(const std::string &type) noexcept {
    for (const char *name : {"f4", "f8", "b1", "u1", "u2", "u4", "u8", "i2", "i4", "i8"})
        if ((type[0] == '<' || type[0] == '|') && type.substr(1) == name)
            return true;
    return false;
}

// Reads "(2, 256, 256)"; false if it is not a tuple of lengths.
bool read_shape(const char *text, std::vector<size_t> &shape) {
    if (*text++ != '(')
        return false;
    while (*(text += std::strspn(text, " ")) != ')') {
        if (*text < '0' || *text > '9')
            return false;
        char *end = nullptr;
        shape.push_back(std::strtoull(text, &end, 10));
        text = end + std::strspn(end, " ");
        if (*text == ',')
            text++;
        else if (*text != ')')
            return false;
    }
    return true;
}

template <class T> void convert(const unsigned char *raw, size_t count, double *values) noexcept {
    for (size_t i = 0; i < count; i++) {
        T value;
        std::memcpy(&value, raw + i * sizeof value, sizeof value);
        values[i] = static_cast<double>(value);
    }
}

} // namespace

std::string read_npy_header(const std::function<bool(void *data, size_t size)> &read, NpyHeader &header) {
    std::string complaint;
    const std::string text = header_text(read, header.size, complaint);
    if (!complaint.empty())
        return complaint;
    const char *const descr = entry(text, "'descr':"), *const order = entry(text, "'fortran_order':"),
                      *const shape = entry(text, "'shape':");
    if (descr == nullptr || order == nullptr || shape == nullptr)
        return std::string("is not a .npy file: its header has no key ") + (descr == nullptr   ? "descr"
                                                                            : order == nullptr ? "fortran_order"
                                                                                               : "shape");
    const std::string type = type_at(descr);
    if (!known(type))
        return "unsupported dtype " + type + ": must be little-endian f4, f8, u1, u2, u4, u8, i2, i4, i8, or b1";
    header.type = type.substr(1);
    if (std::strncmp(order, "False", 5) != 0)
        return "unsupported Fortran order: must be in C order";
    return read_shape(shape, header.shape) ? "" : "shape: must be lengths in parentheses";
}

void convert_npy(const std::string &type, const unsigned char *raw, size_t count, double *values) noexcept {
    using Convert = void (*)(const unsigned char *raw, size_t count, double *values) noexcept;
    static constexpr struct {
        char kind, width;
        Convert convert;
    } converters[] = {{'f', '4', convert<float>},    {'f', '8', convert<double>},   {'b', '1', convert<uint8_t>},
                      {'u', '1', convert<uint8_t>},  {'u', '2', convert<uint16_t>}, {'u', '4', convert<uint32_t>},
                      {'u', '8', convert<uint64_t>}, {'i', '2', convert<int16_t>},  {'i', '4', convert<int32_t>},
                      {'i', '8', convert<int64_t>}};
    for (const auto &one : converters)
        if (type[0] == one.kind && type[1] == one.width)
            one.convert(raw, count, values);
}

} // namespace toliman
