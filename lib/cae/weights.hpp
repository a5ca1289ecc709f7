// The weights blob "TLMW", lib/FORMATS.md: a whole network as bytes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cae/network.hpp"

namespace toliman::cae {

constexpr size_t kMaxBlob = 4u << 20; // above what any blob can need

// The same network gives the same bytes.
std::vector<uint8_t> to_blob(const Network &network);

// Status::format for anything but a whole, undamaged blob of this version with usable numbers.
Network from_blob(const void *bytes, size_t size);

} // namespace toliman::cae
