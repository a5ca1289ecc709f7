#include "backend/zip.hpp"

#include <algorithm>
#include <memory>
#include <zlib.h>

#include "base/error.hpp"

namespace toliman::zip {

uint32_t crc32(const void *data, size_t size, uint32_t before) noexcept {
    return static_cast<uint32_t>(::crc32_z(before, static_cast<const Bytef *>(data), size));
}

std::vector<uint8_t> deflate(const void *data, size_t size) {
    uLongf packed_size = ::compressBound(size);
    std::vector<uint8_t> packed(packed_size);
    if (::compress2(packed.data(), &packed_size, static_cast<const Bytef *>(data), size, Z_DEFAULT_COMPRESSION) != Z_OK)
        fail(Status::memory, "deflate: out of memory");
    packed.resize(packed_size);
    return packed;
}

std::vector<uint8_t> inflate(const void *packed, size_t packed_size, size_t size, const char *kind) {
    constexpr size_t kMostRatio = 1032; // 258 bytes from 2 bits
    if (packed_size > UINT32_MAX || size > UINT32_MAX)
        fail(Status::format, "%s: the payload exceeds 4 GiB", kind);
    std::vector<uint8_t> out(size <= kMostRatio * packed_size ? size : 0);
    z_stream stream = {};
    stream.next_in = static_cast<z_const Bytef *>(const_cast<void *>(packed));
    stream.avail_in = static_cast<uInt>(packed_size);
    stream.next_out = out.data();
    stream.avail_out = static_cast<uInt>(out.size());
    if (::inflateInit(&stream) != Z_OK)
        fail(Status::memory, "inflate: out of memory");
    const int result = out.empty() ? Z_DATA_ERROR : ::inflate(&stream, Z_FINISH);
    const bool exact = result == Z_STREAM_END && stream.avail_in == 0 && stream.avail_out == 0;
    ::inflateEnd(&stream);
    if (!exact)
        fail(Status::format, "%s: the compressed payload is damaged or has another size than stated", kind);
    return out;
}

bool is_gzip(const std::vector<uint8_t> &data) noexcept {
    return data.size() >= 2 && data[0] == 0x1f && data[1] == 0x8b;
}

// Files may have several members, one after the other.
std::vector<uint8_t> gunzip(const std::vector<uint8_t> &packed, size_t limit, const char *path) {
    constexpr int kGzip = 16 + MAX_WBITS;
    constexpr size_t kChunk = size_t{1} << 16, kMost = size_t{1} << 30;
    z_stream stream = {};
    if (::inflateInit2(&stream, kGzip) != Z_OK)
        fail(Status::memory, "inflate: out of memory");
    const std::unique_ptr<z_stream, int (*)(z_stream *)> owner(&stream, ::inflateEnd);
    std::vector<uint8_t> out;
    stream.next_in = const_cast<Bytef *>(packed.data());
    stream.avail_in = static_cast<uInt>(std::min(packed.size(), kMost));
    for (int result = Z_OK; result != Z_STREAM_END || stream.avail_in > 0;) {
        if (result == Z_STREAM_END)
            ::inflateReset(&stream);
        const size_t before = out.size();
        if (before > limit)
            fail(Status::format, "{%s}: has more than %zu bytes when unpacked", path, limit);
        out.resize(before + kChunk);
        stream.next_out = out.data() + before;
        stream.avail_out = kChunk;
        result = ::inflate(&stream, Z_NO_FLUSH);
        out.resize(out.size() - stream.avail_out);
        if (result != Z_OK && result != Z_STREAM_END)
            fail(Status::format, "{%s}: is a damaged or truncated gzip file", path);
    }
    return out;
}

} // namespace toliman::zip
