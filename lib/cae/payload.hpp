// Payloads of the weights blob and the bank (tools/docs/formats.md): blocks of float32, bf16 or fp16 numbers in one
// zlib stream.
#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "base/buffer.hpp"

namespace toliman::cae {

enum class Encoding : uint16_t { float32 = 0, bf16 = 1, fp16 = 2 };
constexpr uint16_t kEncodings = 3;

constexpr char kBlob[] = "weights blob"; // in messages

// Range of the magnitude of a payload's nonzero numbers: no subnormal float32, infinity or NaN.
constexpr double kMinMagnitude = 0x1p-126, kMaxMagnitude = 0x1p100;

// A tensor or a plane. positive: a number that would round to 0 becomes the smallest positive one (variances).
struct Block {
    size_t count;
    Encoding encoding;
    bool positive = false;
};

// Encodes and compresses the values of all blocks, in order. Status::range for a value out of range; `what` names the
// values in messages.
std::vector<uint8_t> pack(const Buffer<float> &values, const std::vector<Block> &blocks, const char *what);

// Inverse of pack. Status::format unless the payload consists of exactly these blocks, with numbers in range.
Buffer<float> unpack(const uint8_t *packed, size_t packed_size, const std::vector<Block> &blocks, const char *what);

constexpr size_t kChecksumSize = 4; // CRC32 at the end of a file

// Checks magic, version, size and checksum of a file, before anything else is read: the first 16 bytes are four of
// magic, the version as u32 and the size of the file as u64; the file is longer than header and checksum.
// Status::format otherwise; `kind` names the file in messages.
void check_envelope(const void *bytes, size_t size, const char *kind, const char *magic,
                    std::initializer_list<uint32_t> versions, size_t header);

} // namespace toliman::cae
