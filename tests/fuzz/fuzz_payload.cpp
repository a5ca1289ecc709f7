// Payloads of a weights blob with a few small blocks: what unpacks is within its bounds, packs again, and then gives
// the same numbers and bytes. The input is the block sizes as u16, followed by the raw numbers of the payload or, if
// the first byte is even, by the compressed stream.
#include <cmath>
// promises: damaged-weights-are-refused, parsers-are-safe

#include "base/error.hpp"
#include "cae/payload.hpp"
#include "fuzz.hpp"

using namespace fuzz;
using namespace toliman;

namespace {

constexpr size_t kBlocks = 3, kMostNumbers = 64;

std::vector<cae::Block> blocks_of(Source &source) {
    std::vector<cae::Block> blocks;
    for (size_t i = 0; i < kBlocks; i++) {
        const uint64_t word = source.number(2);
        cae::Block block = {word % kMostNumbers + 1, static_cast<cae::Encoding>(word / kMostNumbers % cae::kEncodings)};
        block.positive = (word & 0x8000) != 0;
        blocks.push_back(block);
    }
    return blocks;
}

size_t size_of(const std::vector<cae::Block> &blocks) {
    size_t size = 0;
    for (const cae::Block &block : blocks)
        size += block.encoding == cae::Encoding::float32 ? 4 * block.count : 2 * block.count;
    for (const cae::Block &block : blocks)
        size += block.encoding == cae::Encoding::fp16 ? 2 : 0;
    return size;
}

// As ensured by the reader of variances.
bool are_positive(const Buffer<float> &values, const std::vector<cae::Block> &blocks) {
    auto next = values.begin();
    for (const cae::Block &block : blocks)
        for (size_t i = 0; i < block.count; i++)
            if (!(*next++ > 0) && block.positive)
                return false;
    return true;
}

void check(const Buffer<float> &values, const std::vector<cae::Block> &blocks) {
    for (const float value : values)
        require(std::isfinite(value) && (value == 0 || std::fpclassify(value) == FP_NORMAL), "a number out of bounds");
    if (!are_positive(values, blocks))
        return;
    const Bytes packed = cae::pack(values, blocks, "values");
    const Buffer<float> again = cae::unpack(packed.data(), packed.size(), blocks, "values");
    require(cae::pack(again, blocks, "values") == packed, "packed bytes differ from the unpacked ones");
    require(again == values, "numbers differ after packing");
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    Bytes numbers = {1, 0x83, 0x00, 0x47, 0x00, 0x8a, 0x00}; // float32, bf16 and fp16
    for (int i = 0; i < 64; i++)
        numbers.push_back(static_cast<uint8_t>(i < 32 ? 7 * i : 0x3f));
    const std::vector<uint8_t> packed = zip::deflate(numbers.data(), 24);
    Bytes stream = {0, 1, 0, 1, 0, 1, 0};
    stream.insert(stream.end(), packed.begin(), packed.end());
    Bytes zeros = {1, 0x03, 0x00, 0x43, 0x00, 0x83, 0x00}; // the same encodings, of four zeros each
    zeros.resize(numbers.size());
    return {numbers, stream, zeros};
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    Source source(data, size);
    const bool compressed = source.number(1) % 2 == 0;
    const std::vector<cae::Block> blocks = blocks_of(source);
    Bytes stream = source.rest();
    if (!compressed) {
        stream.resize(size_of(blocks));
        stream = zip::deflate(stream.data(), stream.size());
    }
    Buffer<float> values;
    try {
        values = cae::unpack(stream.data(), stream.size(), blocks, "values");
    } catch (const Error &error) {
        require(error.status() == Status::format, error.what());
        return 0;
    }
    check(values, blocks);
    fuzz::accepted++;
    return 0;
}
