// Method: numbers are rounded to their format, byte-shuffled (byte k of every number before byte k + 1 of any) and
// deflated. Shuffling puts the exponents next to each other, which is what deflate can compress; mantissas are close to
// random (in a prototype, deflate made float32 weights 1.08 to 1.17 times smaller). An fp16 block has a common
// power-of-two scale that maps its largest magnitude to 2^15 ... 65504, since binary16 alone spans only 2^-24 to 65504.
//
// Rounding is to nearest, ties to even, and idempotent: what is read gives the same bytes again in the same format.
// bf16 and fp16 shrink a blob of 2.00 MB to 1.05 and 1.21 MB; the efficiency is the same within 3e-4. Subnormal float32
// are excluded because they would slow the network down.
#include "cae/payload.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "base/error.hpp"
#include "kernels/half_precision.hpp"

namespace toliman::cae {

namespace {

constexpr int kTopExponent = 15;                                               // exponent of the largest fp16
constexpr int kMinScale = -126 - kTopExponent, kMaxScale = 100 - kTopExponent; // from kMinMagnitude, kMaxMagnitude
constexpr size_t kScaleBytes = 2;

constexpr size_t width(Encoding encoding) noexcept {
    return encoding == Encoding::float32 ? 4 : 2;
}

size_t raw_size(const std::vector<Block> &blocks) noexcept {
    size_t size = 0;
    for (const Block &block : blocks)
        size += (block.encoding == Encoding::fp16 ? kScaleBytes : 0) + width(block.encoding) * block.count;
    return size;
}

size_t count_of(const std::vector<Block> &blocks) noexcept {
    size_t count = 0;
    for (const Block &block : blocks)
        count += block.count;
    return count;
}

bool is_impossible(float value) noexcept {
    const double size = std::fabs(static_cast<double>(value));
    return (static_cast<int>(!(size <= kMaxMagnitude)) |
            (static_cast<int>(size > 0) & static_cast<int>(size < kMinMagnitude))) != 0;
}

// A pass without branches decides whether the values need the scan for the first impossible one.
void check_values(const Buffer<float> &values, Status status, const char *what) {
    int bad = 0;
    for (const float value : values)
        bad |= static_cast<int>(is_impossible(value));
    if (bad == 0)
        return;
    const auto i = static_cast<size_t>(std::find_if(values.begin(), values.end(), is_impossible) - values.begin());
    fail(status, "%s: {%s[%zu]} = %g: must be 0 or of magnitude in [%.3g, %.3g]", kBlob, what, i,
         static_cast<double>(values[i]), kMinMagnitude, kMaxMagnitude);
}

// Exponent of the power of two that scales the largest magnitude to 2^15 ... 65504. It is the same for the values after
// rounding, so that encoding is idempotent.
int scale_of(const float *values, size_t count) noexcept {
    double largest = 0;
    for (size_t i = 0; i < count; i++)
        largest = std::max(largest, std::fabs(static_cast<double>(values[i])));
    if (largest == 0)
        return 0;
    const int scale = std::ilogb(largest) - kTopExponent;
    return std::isfinite(kernels::from_fp16(kernels::to_fp16(std::ldexp(largest, -scale)))) ? scale : scale + 1;
}

uint32_t bits_of(float value, const Block &block, int scale) noexcept {
    if (block.encoding == Encoding::bf16)
        return kernels::to_bf16(value);
    if (block.encoding == Encoding::fp16) {
        const uint32_t bits = kernels::to_fp16(std::ldexp(static_cast<double>(value), -scale));
        return block.positive && value > 0 ? std::max(bits, 1u) : bits;
    }
    uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
}

float value_of(uint32_t bits, const Block &block, int scale) noexcept {
    if (block.encoding == Encoding::bf16)
        return kernels::from_bf16(static_cast<uint16_t>(bits));
    if (block.encoding == Encoding::fp16)
        return static_cast<float>(std::ldexp(kernels::from_fp16(static_cast<uint16_t>(bits)), scale));
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

// Byte-shuffled: byte k of every number precedes byte k + 1 of any.
uint8_t *write_block(const float *values, const Block &block, uint8_t *out) noexcept {
    int scale = 0;
    if (block.encoding == Encoding::fp16) {
        scale = scale_of(values, block.count);
        *out++ = static_cast<uint8_t>(scale);
        *out++ = static_cast<uint8_t>(scale >> 8);
    }
    const size_t bytes = width(block.encoding);
    for (size_t i = 0; i < block.count; i++) {
        const uint32_t bits = bits_of(values[i], block, scale);
        for (size_t k = 0; k < bytes; k++)
            out[k * block.count + i] = static_cast<uint8_t>(bits >> (8 * k));
    }
    return out + bytes * block.count;
}

const uint8_t *read_block(const uint8_t *raw, const Block &block, float *values) {
    int scale = 0;
    if (block.encoding == Encoding::fp16) {
        scale = static_cast<int16_t>(raw[0] | raw[1] << 8);
        raw += kScaleBytes;
        if (scale < kMinScale || scale > kMaxScale)
            fail(Status::format, "%s: scale of a block = 2^%d: must be in [2^%d, 2^%d]", kBlob, scale, kMinScale,
                 kMaxScale);
    }
    const size_t bytes = width(block.encoding), n = block.count;
    if (block.encoding == Encoding::float32) { // without a branch per value: most of a large blob
        const uint8_t *__restrict in = raw;
        float *__restrict out = values;
        for (size_t i = 0; i < n; i++)
            out[i] = with_bits<float>(in[i] | static_cast<uint32_t>(in[n + i]) << 8 |
                                      static_cast<uint32_t>(in[2 * n + i]) << 16 |
                                      static_cast<uint32_t>(in[3 * n + i]) << 24);
        return raw + bytes * n;
    }
    for (size_t i = 0; i < n; i++) {
        uint32_t bits = 0;
        for (size_t k = 0; k < bytes; k++)
            bits |= static_cast<uint32_t>(raw[k * n + i]) << (8 * k);
        values[i] = value_of(bits, block, scale);
    }
    return raw + bytes * block.count;
}

} // namespace

std::vector<uint8_t> pack(const Buffer<float> &values, const std::vector<Block> &blocks, const char *what) {
    Buffer<float> normal(values.size());
    std::transform(values.begin(), values.end(), normal.begin(),
                   [](float value) { return kernels::to_float32(static_cast<double>(value)); });
    check_values(normal, Status::range, what);
    std::vector<uint8_t> raw(raw_size(blocks));
    const float *from = normal.data();
    uint8_t *next = raw.data();
    for (const Block &block : blocks) {
        next = write_block(from, block, next);
        from += block.count;
    }
    return zip::deflate(raw.data(), raw.size());
}

Buffer<float> unpack(const uint8_t *packed, size_t packed_size, const std::vector<Block> &blocks, const char *what) {
    const std::vector<uint8_t> raw = zip::inflate(packed, packed_size, raw_size(blocks), kBlob);
    Buffer<float> values(count_of(blocks));
    const uint8_t *next = raw.data();
    float *to = values.data();
    for (const Block &block : blocks) {
        next = read_block(next, block, to);
        to += block.count;
    }
    check_values(values, Status::format, what);
    return values;
}

void check_envelope(const void *bytes, size_t size, const char *kind, const char *magic,
                    std::initializer_list<uint32_t> versions, size_t header) {
    ByteReader reader(bytes, size, kind);
    if (std::memcmp(reader.raw(4), magic, 4) != 0)
        fail(Status::format, "%s: does not start with \"%s\"", kind, magic);
    const uint32_t version = reader.u32();
    if (std::find(versions.begin(), versions.end(), version) == versions.end()) {
        std::string known;
        for (const uint32_t one : versions)
            known += (known.empty() ? "" : ", ") + std::to_string(one);
        fail(Status::format, "%s: unsupported version %u (supported: %s)", kind, version, known.c_str());
    }
    const uint64_t stated = reader.u64();
    if (stated != size)
        fail(Status::format, "%s: size = %zu bytes: the header states %llu: truncated, or followed by other data", kind,
             size, static_cast<unsigned long long>(stated));
    if (size < header + kChecksumSize)
        fail(Status::format, "%s: size = %zu bytes: must be at least %zu", kind, size, header + kChecksumSize);
    ByteReader end(static_cast<const uint8_t *>(bytes) + size - kChecksumSize, kChecksumSize, kind);
    if (zip::crc32(bytes, size - kChecksumSize) != end.u32())
        fail(Status::format, "%s: checksum mismatch: the data are damaged", kind);
}

} // namespace toliman::cae
