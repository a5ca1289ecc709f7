#include "frame/npy_image.hpp"

#include <algorithm>
#include <cstring>

#include "base/buffer.hpp"
#include "base/error.hpp"
#include "frame/npy.hpp"

namespace toliman {

namespace {

constexpr size_t kLargestSide = 1 << 20;

} // namespace

NpyImage parse_npy(const std::vector<uint8_t> &bytes, const std::string &source) {
    if (bytes.size() >= 6 && std::memcmp(bytes.data(), "SIMPLE", 6) == 0)
        fail(Status::format, "{%s}: is a FITS file, must be .npy: convert it with `toliman convert IN.fits OUT.npy`",
             source.c_str());
    size_t at = 0;
    NpyHeader header;
    const auto read = [&](void *data, size_t size) {
        const size_t left = bytes.size() - at;
        std::copy_n(bytes.data() + at, std::min(size, left), static_cast<uint8_t *>(data));
        at += std::min(size, left);
        return size <= left;
    };
    const std::string complaint = read_npy_header(read, header);
    if (!complaint.empty())
        fail(Status::format, "{%s}: %s", source.c_str(), complaint.c_str());
    const bool sized = std::all_of(header.shape.begin(), header.shape.end(),
                                   [](size_t side) { return side >= 1 && side <= kLargestSide; });
    if (header.shape.size() != 2 || !sized)
        fail(Status::format, "{%s}: shape: must be two lengths in [1, %zu]", source.c_str(), kLargestSide);
    NpyImage image = {header.shape[0], header.shape[1], {}};
    const size_t count = checked_product(image.rows, image.cols, source.c_str());
    if (bytes.size() - at != count * header.width())
        fail(Status::format, "{%s}: has %zu bytes of data: must be %zu (%zu x %zu %s)", source.c_str(),
             bytes.size() - at, count * header.width(), image.rows, image.cols, header.type.c_str());
    image.values.resize(count);
    convert_npy(header.type, bytes.data() + at, count, image.values.data());
    return image;
}

} // namespace toliman
