#include "common/npy.hpp"

#include <cstdlib>
#include <cstring>

#include "common/content.hpp"
#include "common/failure.hpp"

namespace cli {

namespace {

constexpr char kMagic[] = "\x93NUMPY";
constexpr size_t kMagicSize = 6, kPrefixSize = 10; // magic, version, u16 length of the header's text

bool known(const std::string &type) noexcept {
    for (const char *name : {"f8", "f4", "u1", "u2", "u4", "u8", "i2", "i4", "i8"})
        if (type == name)
            return true;
    return false;
}

// The text after 'key': in the header's dictionary, up to one of the characters in `stops`.
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

// The numbers in "(2, 256, 256"; one that exceeds size_t becomes the largest size_t.
std::vector<size_t> numbers_of(const std::string &text) {
    std::vector<size_t> numbers;
    for (const char *next = text.c_str(); *next != '\0';) {
        if (*next < '0' || *next > '9') {
            next++;
            continue;
        }
        char *end = nullptr;
        numbers.push_back(std::strtoull(next, &end, 10));
        next = end;
    }
    return numbers;
}

} // namespace

void write_npy_header(OutputFile &out, const std::vector<size_t> &shape) {
    std::string text = "{'descr': '<f8', 'fortran_order': False, 'shape': (";
    for (size_t i = 0; i < shape.size(); i++)
        text += (i > 0 ? ", " : "") + std::to_string(shape[i]);
    text += shape.size() == 1 ? ",), }" : "), }";
    text.resize(kNpyHeaderSize - kPrefixSize - 1, ' '); // the header's size marks files of this program
    text += '\n';
    const unsigned char prefix[4] = {1, 0, static_cast<unsigned char>(text.size() & 255),
                                     static_cast<unsigned char>(text.size() >> 8)};
    out.write(kMagic, kMagicSize);
    out.write(prefix, sizeof prefix);
    out.write(text.data(), text.size());
}

NpyHeader read_npy_header(InputFile &file) {
    unsigned char prefix[kPrefixSize];
    if (file.ended())
        malformed(file.path(), "is empty");
    if (!file.read(prefix, kPrefixSize) || std::memcmp(prefix, kMagic, kMagicSize) != 0)
        malformed(file.path(), "is not a .npy file" + kind_of(file.path()));
    if (prefix[6] != 1)
        malformed(file.path(), "unsupported .npy version " + std::to_string(prefix[6]) + ": must be 1");
    std::string text(static_cast<size_t>(prefix[8]) + size_t{256} * prefix[9], ' ');
    if (!file.read(text.data(), text.size()))
        malformed(file.path(), "the .npy header is truncated");
    const std::string type = value_of(text, "descr", ",");
    if (type.size() != 5 || (type[1] != '<' && type[1] != '|') || !known(type.substr(2, 2)))
        malformed(file.path(),
                  "unsupported dtype " + type + ": must be little-endian f4, f8, u1, u2, u4, u8, i2, i4 or i8");
    if (value_of(text, "fortran_order", ",") != "False")
        malformed(file.path(), "is in Fortran order: must be in C order");
    return {type.substr(2, 2), numbers_of(value_of(text, "shape", ")")), kPrefixSize + text.size()};
}

} // namespace cli
