#include "cae/weights.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "base/error.hpp"

namespace toliman::cae {

namespace {

constexpr char kMagic[] = "TLMW";
constexpr const char *kKind = "weights blob";
constexpr uint32_t kVersion = 1;
constexpr uint32_t kTrainedFlag = 1;
constexpr uint32_t kFloat32 = 0;
constexpr uint32_t kLargestFrame = 4096; // rows and columns
constexpr float kLargestValue = 1e30f;
constexpr size_t kHeaderSize = 104, kChecksumSize = 4;
constexpr size_t kFixedPlanes = 4; // reference high and low, variance, target

struct Header {
    Preprocess preprocess; // without its planes
    uint64_t seed;
    bool trained;
    double cosine;
    size_t packed_weights, packed_planes;
};

// Byte k of every float before byte k + 1 of any: exponents stand together and compress.
std::vector<uint8_t> pack(const Buffer<float> &values) {
    std::vector<uint8_t> shuffled(4 * values.size());
    for (size_t i = 0; i < values.size(); i++) {
        uint32_t bits;
        std::memcpy(&bits, &values[i], 4);
        for (size_t k = 0; k < 4; k++)
            shuffled[k * values.size() + i] = static_cast<uint8_t>(bits >> (8 * k));
    }
    return zip::deflate(shuffled.data(), shuffled.size());
}

Buffer<float> unpack(const uint8_t *packed, size_t packed_size, size_t count) {
    std::vector<uint8_t> shuffled(4 * count);
    zip::inflate(packed, packed_size, shuffled.data(), shuffled.size(), kKind);
    Buffer<float> values(count);
    for (size_t i = 0; i < count; i++) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 4; k++)
            bits |= static_cast<uint32_t>(shuffled[k * count + i]) << (8 * k);
        std::memcpy(&values[i], &bits, 4);
    }
    return values;
}

Buffer<float> planes_of(const Preprocess &preprocess) {
    Buffer<float> planes;
    planes.reserve((kFixedPlanes + preprocess.projected) * kPixels);
    const auto append = [&](const Buffer<double> &plane) {
        for (const double value : plane)
            planes.push_back(static_cast<float>(value));
    };
    append(preprocess.reference);
    for (size_t i = 0; i < kPixels; i++)
        planes.push_back(static_cast<float>(preprocess.reference[i] - static_cast<double>(planes[i])));
    append(preprocess.variance);
    append(preprocess.target);
    append(preprocess.units);
    return planes;
}

void check_values(const Buffer<float> &values, const char *what) {
    for (size_t i = 0; i < values.size(); i++)
        if (!(std::fabs(values[i]) <= kLargestValue))
            fail(Status::format, "%s: %s[%zu] = %g: must be finite and at most %g", kKind, what, i,
                 static_cast<double>(values[i]), static_cast<double>(kLargestValue));
}

void set_planes(const Buffer<float> &planes, Preprocess &preprocess) {
    check_values(planes, "planes");
    const auto at = [&](size_t plane) { return planes.begin() + static_cast<std::ptrdiff_t>(plane * kPixels); };
    preprocess.reference.assign(at(0), at(1));
    std::transform(at(1), at(2), preprocess.reference.begin(), preprocess.reference.begin(),
                   [](float low, double high) { return high + static_cast<double>(low); });
    preprocess.variance.assign(at(2), at(3));
    preprocess.target.assign(at(3), at(4));
    preprocess.units.assign(at(4), planes.end());
    for (size_t i = 0; i < kPixels; i++)
        if (!(preprocess.variance[i] > 0))
            fail(Status::format, "%s: variance[%zu] = %g: must be positive", kKind, i, preprocess.variance[i]);
    preprocess.derive();
}

// Everything that can be said before looking inside.
void check_envelope(const void *bytes, size_t size) {
    ByteReader reader(bytes, size, kKind);
    if (std::memcmp(reader.raw(4), kMagic, 4) != 0)
        fail(Status::format, "%s: does not start with \"%s\"", kKind, kMagic);
    const uint32_t version = reader.u32();
    if (version != kVersion)
        fail(Status::format, "%s: version %u: this library reads version %u", kKind, version, kVersion);
    const uint64_t stated = reader.u64();
    if (stated != size)
        fail(Status::format, "%s: %zu bytes long, but its header says %llu: truncated or with something behind it",
             kKind, size, static_cast<unsigned long long>(stated));
    if (size < kHeaderSize + kChecksumSize)
        fail(Status::format, "%s: %zu bytes: shorter than its header", kKind, size);
    const auto *first = static_cast<const uint8_t *>(bytes);
    ByteReader end(first + size - kChecksumSize, kChecksumSize, kKind);
    if (zip::crc32(bytes, size - kChecksumSize) != end.u32())
        fail(Status::format, "%s: the checksum does not fit: the bytes are damaged", kKind);
}

// The rest of the header; sizes are checked against what layout and frame imply before anything is allocated.
Header read_header(ByteReader &reader, size_t size) {
    Header header = {};
    Preprocess &preprocess = header.preprocess;
    reader.raw(16);
    const uint32_t id = reader.u32(), flags = reader.u32();
    const uint64_t hash = reader.u64();
    if (id != kFlight.id || hash != layout_hash(kFlight))
        fail(Status::format, "%s: layout %u with hash %016llx: this library knows %u (%s) with hash %016llx", kKind, id,
             static_cast<unsigned long long>(hash), kFlight.id, kFlight.name,
             static_cast<unsigned long long>(layout_hash(kFlight)));
    if ((flags & ~kTrainedFlag) != 0)
        fail(Status::format, "%s: flags = 0x%x: only bit 0 has a meaning", kKind, flags);
    header.trained = flags != 0;
    preprocess.scene_digest = reader.u64();
    header.seed = reader.u64();
    preprocess.rows = reader.u32();
    preprocess.cols = reader.u32();
    preprocess.crop_row = reader.u32();
    preprocess.crop_col = reader.u32();
    for (const size_t side : {preprocess.rows, preprocess.cols})
        if (side < kSide || side > kLargestFrame)
            fail(Status::format, "%s: frames of %zu x %zu: must be in [%zu, %u]", kKind, preprocess.rows,
                 preprocess.cols, kSide, kLargestFrame);
    if (preprocess.crop_row > preprocess.rows - kSide || preprocess.crop_col > preprocess.cols - kSide)
        fail(Status::format, "%s: crop at %zu, %zu: must lie in a frame of %zu x %zu", kKind, preprocess.crop_row,
             preprocess.crop_col, preprocess.rows, preprocess.cols);
    preprocess.projected = reader.u32();
    if (preprocess.projected > kMaxProjected)
        fail(Status::format, "%s: %zu nuisance planes: at most %zu", kKind, preprocess.projected, kMaxProjected);
    const uint32_t encoding = reader.u32();
    if (encoding != kFloat32)
        fail(Status::format, "%s: payload encoding %u: only %u (float32) is known", kKind, encoding, kFloat32);
    preprocess.input_scale = reader.f64();
    preprocess.crb_px = reader.f64();
    header.cosine = reader.f64();
    if (!(preprocess.input_scale > 0 && preprocess.input_scale <= kLargestValue))
        fail(Status::format, "%s: input scale %g: must be positive", kKind, preprocess.input_scale);
    if (!(preprocess.crb_px >= 0) || !(header.cosine >= 0 && header.cosine <= 1))
        fail(Status::format, "%s: bound of %g px and cosine %g: must be at least 0 and within [0, 1]", kKind,
             preprocess.crb_px, header.cosine);
    header.packed_weights = reader.u32();
    header.packed_planes = reader.u32();
    if (kHeaderSize + header.packed_weights + header.packed_planes + kChecksumSize != size)
        fail(Status::format, "%s: payloads of %zu and %zu bytes do not fill its %zu bytes", kKind,
             header.packed_weights, header.packed_planes, size);
    return header;
}

} // namespace

std::vector<uint8_t> to_blob(const Network &network) {
    const Preprocess &preprocess = network.preprocess();
    const std::vector<uint8_t> weights = pack(network.parameters().values), planes = pack(planes_of(preprocess));
    ByteWriter writer;
    writer.raw(kMagic, 4);
    writer.u32(kVersion);
    writer.u64(kHeaderSize + weights.size() + planes.size() + kChecksumSize);
    writer.u32(kFlight.id);
    writer.u32(network.trained() ? kTrainedFlag : 0);
    writer.u64(layout_hash(kFlight));
    writer.u64(preprocess.scene_digest);
    writer.u64(network.seed());
    for (const size_t value :
         {preprocess.rows, preprocess.cols, preprocess.crop_row, preprocess.crop_col, preprocess.projected})
        writer.u32(static_cast<uint32_t>(value));
    writer.u32(kFloat32);
    writer.f64(preprocess.input_scale);
    writer.f64(preprocess.crb_px);
    writer.f64(network.cosine());
    writer.u32(static_cast<uint32_t>(weights.size()));
    writer.u32(static_cast<uint32_t>(planes.size()));
    writer.raw(weights.data(), weights.size());
    writer.raw(planes.data(), planes.size());
    writer.u32(zip::crc32(writer.bytes().data(), writer.bytes().size()));
    return writer.take();
}

Network from_blob(const void *bytes, size_t size) {
    check_envelope(bytes, size);
    ByteReader reader(bytes, size, kKind);
    Header header = read_header(reader, size);
    Parameters parameters;
    parameters.values = unpack(reader.raw(header.packed_weights), header.packed_weights, kParameters);
    check_values(parameters.values, "weights");
    const size_t planes = (kFixedPlanes + header.preprocess.projected) * kPixels;
    set_planes(unpack(reader.raw(header.packed_planes), header.packed_planes, planes), header.preprocess);
    return Network(kFlight, std::move(header.preprocess), std::move(parameters), header.seed, header.trained,
                   header.cosine);
}

} // namespace toliman::cae
