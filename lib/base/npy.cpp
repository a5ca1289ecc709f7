#include "base/npy.hpp"

#include <cstring>

#include "base/buffer.hpp"
#include "base/bytes.hpp"

namespace toliman {

namespace {

constexpr size_t kLargestSide = 1 << 20;

// Text of the header after "'key':" up to the end, or an error.
const char *entry(const std::string &header, const char *key, const std::string &source) {
    const std::string quoted = std::string("'") + key + "':";
    const size_t at = header.find(quoted);
    if (at == std::string::npos)
        fail(Status::format, "{%s}: not a .npy file: its header has no %s", source.c_str(), key);
    const char *text = header.c_str() + at + quoted.size();
    return text + std::strspn(text, " ");
}

std::string header_of(ByteReader &reader, const std::string &source) {
    const uint8_t *magic = reader.raw(6);
    if (std::memcmp(magic, "SIMPLE", 6) == 0)
        fail(Status::format, "{%s}: is FITS, must be .npy: `toliman convert IN.fits OUT.npy` makes one",
             source.c_str());
    if (std::memcmp(magic, "\x93NUMPY", 6) != 0)
        fail(Status::format, "{%s}: not a .npy file: wrong magic bytes", source.c_str());
    const unsigned major = reader.u8();
    reader.u8();
    if (major < 1 || major > 3)
        fail(Status::format, "{%s}: .npy version %u: must be 1 to 3", source.c_str(), major);
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
        fail(Status::format, "{%s}: its shape must be two sides of 1 to %zu", source.c_str(), kLargestSide);
    text += std::strspn(text, " ");
    return value;
}

void read_shape(const char *text, NpyImage &image, const std::string &source) {
    const auto expect = [&](char sign) {
        if (*text++ != sign)
            fail(Status::format, "{%s}: must be a two-dimensional array", source.c_str());
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
    fail(Status::format, "{%s}: element type %.8s: must be <f4, <f8, |u1 or |b1", source.c_str(), type.c_str());
}

} // namespace

NpyImage parse_npy(const std::vector<uint8_t> &bytes, const std::string &source) {
    ByteReader reader(bytes.data(), bytes.size(), source.c_str());
    const std::string header = header_of(reader, source);
    const char *descr = entry(header, "descr", source);
    const std::string type = *descr == '\'' ? std::string(descr + 1, std::strcspn(descr + 1, "'")) : "structured";
    const size_t width = width_of(type, source);
    if (std::strncmp(entry(header, "fortran_order", source), "False", 5) != 0)
        fail(Status::format, "{%s}: must be in C order", source.c_str());
    NpyImage image;
    read_shape(entry(header, "shape", source), image, source);
    const size_t count = checked_product(image.rows, image.cols, source.c_str());
    if (reader.left() != count * width)
        fail(Status::format, "{%s}: %zu bytes of data: %zu x %zu of %s need %zu", source.c_str(), reader.left(),
             image.rows, image.cols, type.c_str(), count * width);
    image.values.resize(count);
    for (double &value : image.values)
        value = width == 1 ? reader.u8() : width == 4 ? static_cast<double>(reader.f32()) : reader.f64();
    return image;
}

} // namespace toliman
