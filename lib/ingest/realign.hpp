// Finds a frame in a file of pixels that has lost or gained bytes before it.
#pragma once
#include <cstdint>
#include <optional>

#include "backend/file.hpp"

namespace toliman::ingest {

// Where a frame may be.
struct Search {
    int64_t first, last; // offsets of its first byte in the file
    size_t pixels, pixel_bytes;
};

// The offset at which a frame looks most like `reference` [pixels], little-endian numbers of 2 or 4 bytes; none if it
// nowhere looks like it.
std::optional<int64_t> find_frame(const file::Reader &file, const Search &search, const void *reference);

} // namespace toliman::ingest
