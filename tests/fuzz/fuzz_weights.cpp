// Weights blobs: a blob that loads saves to the same bytes (except for the compression, so that the second save is
// compared), gives finite numbers, and encodes a frame to a finite latent or an error.
#include <cmath>
// promises: damaged-weights-are-refused, parsers-are-safe

#include <toliman/toliman.hpp>

#include "cae/layout.hpp"
#include "cae/payload.hpp"
#include "fuzz.hpp"

using namespace fuzz;
using namespace toliman;

namespace {

constexpr size_t kHeader = 104, kAtSize = 8, kAtWeights = 96, kAtPlanes = 100;

toliman_cae *load(const Bytes &bytes) {
    toliman_cae *cae = nullptr;
    const toliman_status status = toliman_cae_load(bytes.data(), bytes.size(), nullptr, &cae);
    require(status == TOLIMAN_OK || status == TOLIMAN_E_FORMAT, toliman_last_error());
    require((status == TOLIMAN_OK) == (cae != nullptr), "a result despite an error");
    return cae;
}

toliman_cae_info info_of(const toliman_cae *cae) {
    auto info = toliman::sized<toliman_cae_info>();
    require(toliman_cae_get_info(cae, nullptr, &info) == TOLIMAN_OK, toliman_last_error());
    return info;
}

// With the encodings that it was loaded with.
Bytes save(const toliman_cae *cae, const Bytes &like) {
    auto options = toliman::sized<toliman_cae_save_options>();
    options.weights_encoding = TOLIMAN_CAE_ENCODING_FLOAT32 + like[68];
    options.planes_encoding = TOLIMAN_CAE_ENCODING_FLOAT32 + like[70];
    options.with_training = (like[20] & 8) != 0;
    size_t size = 0;
    require(toliman_cae_save(cae, &options, nullptr, 0, &size) == TOLIMAN_E_CAPACITY, toliman_last_error());
    Bytes bytes(size);
    require(toliman_cae_save(cae, &options, bytes.data(), size, &size) == TOLIMAN_OK, toliman_last_error());
    return bytes;
}

void save_and_load(const toliman_cae *cae, const Bytes &like) {
    const Bytes saved = save(cae, like);
    toliman_cae *again = load(saved);
    require(again != nullptr && save(again, like) == saved, "saved bytes differ from the loaded ones");
    toliman_cae_destroy(again);
}

void encode(const toliman_cae *cae, const toliman_cae_info &info) {
    static std::vector<double> frame;
    frame.assign(static_cast<size_t>(info.rows * info.cols), 100);
    double latent = 0;
    auto image = toliman::sized<toliman_image>();
    image.pixels = frame.data();
    const toliman_status status = toliman_cae_encode(cae, &image, 1, &latent, nullptr);
    require(status != TOLIMAN_OK || std::isfinite(latent), "a latent that is not finite");
    require(status != TOLIMAN_E_INTERNAL, toliman_last_error());
}

// A number that is small in every encoding, and its bytes as stored in a block.
float small_number(size_t i) {
    return i % 7 == 0 ? 0.015625F : 0;
}

Bytes pack(const std::vector<cae::Block> &blocks, bool positive) {
    size_t count = 0;
    for (const cae::Block &block : blocks)
        count += block.count;
    Buffer<float> values(count);
    for (size_t i = 0; i < count; i++)
        values[i] = positive ? 1 : small_number(i);
    return cae::pack(values, blocks, "seed");
}

// Sizes and checksum consistent with the bytes.
void repair(Bytes &bytes, unsigned seed) {
    if (bytes.size() < kHeader + 4)
        return;
    const uint8_t *at = bytes.data() + kAtWeights;
    const size_t available = bytes.size() - kHeader - 4, weights = take_number(at, 4);
    put(bytes, kAtSize, bytes.size(), 8);
    if (seed % 3 != 0 && weights <= available && (bytes[20] & 8) == 0)
        put(bytes, kAtPlanes, available - weights, 4);
    seal(bytes);
}

} // namespace

// Networks whose numbers compress well: equal weights, and planes without zeros. The first has 9 nuisance planes.
std::vector<Bytes> fuzz::seeds() {
    constexpr uint64_t kOne = 0x3ff0000000000000;
    std::vector<Bytes> seeds;
    for (uint32_t layout = 1; layout <= 3; layout++)
        for (uint16_t encoding = 0; encoding < 3; encoding++) {
            const auto kind = static_cast<cae::Encoding>(encoding);
            const uint32_t projected = layout == 1 && encoding == 0 ? 9 : 0;
            const cae::Layout &of = *cae::find_layout(layout);
            std::vector<cae::Block> tensors, images(4 + projected, {of.pixels(), kind});
            for (const cae::Tensor &tensor : of.tensors)
                tensors.push_back({tensor.count(), kind});
            images[0].encoding = images[1].encoding = cae::Encoding::float32;
            const Bytes weights = pack(tensors, false), planes = pack(images, true);
            ByteWriter out;
            out.raw("TLMW", 4);
            out.u32(projected > 0 ? 3 : 2);
            out.u64(kHeader + weights.size() + planes.size() + 4);
            out.u32(layout);
            out.u32(layout == 2 ? 4 : 0);
            out.u64(cae::layout_hash(of));
            out.u64(7);
            out.u64(8);
            const auto side = static_cast<uint32_t>(of.side);
            for (const uint32_t number : {side, side, 0u, 0u, projected})
                out.u32(number);
            out.u16(encoding);
            out.u16(encoding);
            out.u64(kOne);
            out.u64(kOne);
            out.u64(0);
            out.u32(static_cast<uint32_t>(weights.size()));
            out.u32(static_cast<uint32_t>(planes.size()));
            out.raw(weights.data(), weights.size());
            out.raw(planes.data(), planes.size());
            out.u32(0);
            Bytes bytes = out.take();
            seal(bytes);
            seeds.push_back(bytes);
        }
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const Bytes bytes(data, data + size);
    toliman_cae *cae = size > 0 ? load(bytes) : nullptr;
    if (cae == nullptr)
        return 0;
    fuzz::accepted++;
    const toliman_cae_info info = info_of(cae);
    require(std::isfinite(info.crb_px) && info.cosine >= 0 && info.cosine <= 1, "impossible information");
    const uint32_t chosen = zip::crc32(data, size) % 4; // all of them would take too long
    if (chosen == 0)
        save_and_load(cae, bytes);
    if (chosen == 1 && info.rows * info.cols <= 1 << 17) // larger ones would only be slower
        encode(cae, info);
    toliman_cae_destroy(cae);
    return 0;
}

// Mostly in the header, which has most of the meaning.
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed) {
    Bytes bytes(data, data + size);
    if (seed % 4 != 0 && size > kHeader) {
        Bytes head(bytes.begin(), bytes.begin() + kHeader);
        mutate(head, kHeader);
        head.resize(kHeader);
        std::copy(head.begin(), head.end(), bytes.begin());
    } else {
        mutate(bytes, most);
    }
    if (seed / 4 % 8 != 0)
        repair(bytes, seed / 32);
    return give(bytes, data, most);
}
