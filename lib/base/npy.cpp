// Method: a .npy file is a magic, a version, the length of a header, the header (a Python dict literal in ASCII with
// descr, fortran_order and shape), then the raw data. The header is searched for its three keys rather than parsed as
// Python. Format: NumPy documentation, numpy.lib.format. The file is input of a user, so every length is checked
// against what remains before it is used.
#include "base/npy.hpp"

#include <cstring>

#include "base/buffer.hpp"
#include "base/bytes.hpp"

namespace toliman {

namespace {

constexpr size_t kLargestSide = 1 << 20;

// Returns the header's text after "'key':", without leading blanks.
const char *entry(const std::string &header, const char *key, const std::string &source) {
    const std::string quoted = std::string("'") + key + "':";
    const size_t at = header.find(quoted);
    if (at == std::string::npos)
        fail(Status::format, "{%s}: is not a .npy file: its header has no key %s", source.c_str(), key);
    const char *text = header.c_str() + at + quoted.size();
    return text + std::strspn(text, " ");
}

std::string header_of(ByteReader &reader, const std::string &source) {
    const uint8_t *magic = reader.raw(6);
    if (std::memcmp(magic, "SIMPLE", 6) == 0)
        fail(Status::format, "{%s}: is a FITS file, must be .npy: convert it with `toliman convert IN.fits OUT.npy`",
             source.c_str());
    if (std::memcmp(magic, "\x93NUMPY", 6) != 0)
        fail(Status::format, "{%s}: is not a .npy file: wrong magic bytes", source.c_str());
    const unsigned major = reader.u8();
    reader.u8();
    if (major < 1 || major > 3)
        fail(Status::format, "{%s}: .npy format version %u: must be in [1, 3]", source.c_str(), major);
    const size_t size = major == 1 ? reader.u16() : reader.u32();
    return std::string(reinterpret_cast<const char *>(reader.raw(size)), size);
}

size_t side(const char *&text, const std::string &source) {
    text += std::strspn(text, " ");
    size_t value = 0;
    const char *start = text;
    for (; *text >= '0' && *text <= '9' && value <= kLargestSide; text++)
        value = 10 * value + static_cast<size_t>(*text - '0');
    if (text == start || value == 0 || value > kLargestSide)
        fail(Status::format, "{%s}: shape: must be two lengths in [1, %zu]", source.c_str(), kLargestSide);
    text += std::strspn(text, " ");
    return value;
}

void read_shape(const char *text, NpyImage &image, const std::string &source) {
    const auto expect = [&](char sign) {
        if (*text++ != sign)
            fail(Status::format, "{%s}: shape: must be two-dimensional", source.c_str());
    };
    expect('(');
    image.rows = side(text, source);
    expect(',');
    image.cols = side(text, source);
    expect(')');
}

size_t width_of(const std::string &type, const std::string &source) {
    if (type == "|b1" || type == "|u1")
        return 1;
    if (type == "<f4")
        return 4;
    if (type == "<f8")
        return 8;
    fail(Status::format, "{%s}: unsupported dtype %.8s (supported: <f4, <f8, |u1, |b1)", source.c_str(), type.c_str());
}

} // namespace

NpyImage parse_npy(const std::vector<uint8_t> &bytes, const std::string &source) {
    ByteReader reader(bytes.data(), bytes.size(), source.c_str());
    const std::string header = header_of(reader, source);
    const char *descr = entry(header, "descr", source);
    const std::string type = *descr == '\'' ? std::string(descr + 1, std::strcspn(descr + 1, "'")) : "structured";
    const size_t width = width_of(type, source);
    if (std::strncmp(entry(header, "fortran_order", source), "False", 5) != 0)
        fail(Status::format, "{%s}: unsupported Fortran order: must be in C order", source.c_str());
    NpyImage image;
    read_shape(entry(header, "shape", source), image, source);
    const size_t count = checked_product(image.rows, image.cols, source.c_str());
    if (reader.left() != count * width)
        fail(Status::format, "{%s}: has %zu bytes of data: must be %zu (%zu x %zu %s)", source.c_str(), reader.left(),
             count * width, image.rows, image.cols, type.c_str());
    image.values.resize(count);
    for (double &value : image.values)
        value = width == 1 ? reader.u8() : width == 4 ? static_cast<double>(reader.f32()) : reader.f64();
    return image;
}

} // namespace toliman
