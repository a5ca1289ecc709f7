// Payloads of the weights blob, tools/docs/formats.md: blocks of numbers, each as float32, bf16 or fp16, in one zlib
// stream.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/buffer.hpp"

namespace toliman::cae {

enum class Encoding : uint16_t { float32 = 0, bf16 = 1, fp16 = 2 };
constexpr uint16_t kEncodings = 3;

// Numbers of a payload are finite and 0 or within these in size.
constexpr double kLeastValue = 0x1p-126, kLargestValue = 0x1p100;

// A tensor or a plane. Where a positive block's number rounds to 0 it becomes the least that is not.
struct Block {
    size_t count;
    Encoding encoding;
    bool positive = false;
};

// Values of all blocks, one block after the other. Status::range for a value that no payload holds.
std::vector<uint8_t> pack(const Buffer<float> &values, const std::vector<Block> &blocks, const char *what);

// The values again. Status::format unless the payload holds just these blocks and usable numbers.
Buffer<float> unpack(const uint8_t *packed, size_t packed_size, const std::vector<Block> &blocks, const char *what);

} // namespace toliman::cae
