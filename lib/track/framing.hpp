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

// A file without its frame.
struct Content {
    ByteReader in;
    uint32_t version;
};

// Returns the content of a file of version 1 to `newest`; bytes.size() must be at least kFramingSize. Status::format if
// it is damaged.
inline Content checked_content(const std::vector<uint8_t> &bytes, const char *magic, uint32_t newest,
                               const char *kind) {
    const size_t size = bytes.size() - 4;
    ByteReader in(bytes.data(), size, kind), crc(bytes.data() + size, 4, kind);
    const bool has_magic = std::memcmp(in.raw(4), magic, 4) == 0;
    const uint32_t version = in.u32();
    if (!has_magic || version < 1 || version > newest || crc.u32() != zip::crc32(bytes.data(), size))
        fail(Status::format, "%s: is damaged or has another version", kind);
    return {in, version};
}

} // namespace toliman::track
