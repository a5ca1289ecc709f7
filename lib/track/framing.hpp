// Framing of small files: magic and version first, CRC32 of all bytes before it last.
#pragma once
#include <cstring>
#include <vector>

#include "backend/zip.hpp"
#include "base/bytes.hpp"

namespace toliman::track {

constexpr size_t kFramingSize = 4 + 4 + 4;

inline ByteWriter begin_file(const char *magic, uint32_t version) {
    ByteWriter out;
    out.raw(magic, 4);
    out.u32(version);
    return out;
}

inline std::vector<uint8_t> finish_file(ByteWriter out) {
    out.u32(zip::crc32(out.bytes().data(), out.bytes().size()));
    return out.take();
}

// Returns a reader of the content between; bytes.size() must be at least kFramingSize. Status::format if it is damaged.
inline ByteReader checked_content(const std::vector<uint8_t> &bytes, const char *magic, uint32_t version,
                                  const char *kind) {
    const size_t size = bytes.size() - 4;
    ByteReader in(bytes.data(), size, kind), crc(bytes.data() + size, 4, kind);
    if (std::memcmp(in.raw(4), magic, 4) != 0 || in.u32() != version || crc.u32() != zip::crc32(bytes.data(), size))
        fail(Status::format, "%s: is damaged or has another version", kind);
    return in;
}

} // namespace toliman::track
