// Method: header of 104 bytes, 8 more if the crop follows the image, 16 more with the place of the window, payloads of
// weights and planes (cae/payload.hpp), optional training, CRC32; little-endian. The blob contains the preprocessing
// planes, so that frames can be encoded without the scene.
//
// A blob is untrusted input. The reader checks size and CRC32 first, then every header field against its range, and
// only then allocates. A zlib stream must inflate to exactly the length that layout and frame imply, so that a small
// blob cannot claim much memory. A training is accepted only if the library could have produced it: its counters must
// agree.
#include "cae/weights.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "base/error.hpp"
#include "base/text.hpp"
#include "cae/tied.hpp"

namespace toliman::cae {

namespace {

constexpr char kMagic[] = "TLMW";
// Version 3 differs from 2 in the number of nuisance planes alone: 2 has up to 8, and older libraries read it.
constexpr uint32_t kVersion = 2, kManyPlanesVersion = 3;
constexpr size_t kFewPlanes = 8; // of version 2
constexpr uint32_t kTrainedFlag = 1, kInputShift = 1, kInputMask = 3, kTrainingFlag = 8, kFollowFlag = 16,
                   kWindowFlag = 32;
constexpr uint32_t kLargestFrame = 4096; // largest number of rows and of columns
constexpr uint32_t kLastInput = static_cast<uint32_t>(Input::raw);
constexpr size_t kHeaderSize = 104, kFollowSize = 8, kWindowSize = 16, kTrainingHeaderSize = 72;
constexpr int64_t kMostPlace = int64_t{1} << 31;                                   // of a window
enum : size_t { kReferenceHigh, kReferenceLow, kVariance, kTarget, kFixedPlanes }; // then the nuisance planes

// Bytes of the members that some networks have.
size_t optional_size(const Preprocess &preprocess) noexcept {
    return (preprocess.centre == Centre::image ? kFollowSize : 0) + (preprocess.window ? kWindowSize : 0);
}

struct Header {
    const Layout *layout;
    Encoding weights, planes;
    Preprocess preprocess; // without its planes
    uint64_t seed;
    bool trained, with_training;
    double cosine;
    size_t packed_weights, packed_planes;

    // Bytes of the blob but for the training.
    size_t known() const noexcept {
        return kHeaderSize + optional_size(preprocess) + packed_weights + packed_planes + kChecksumSize;
    }
};

// Returns the layout with this id, checked against the hash.
const Layout &layout_of(uint32_t id, uint64_t hash) {
    const Layout *layout = find_layout(id);
    if (layout != nullptr && hash == layout_hash(*layout))
        return *layout;
    std::string known;
    for (const Layout *one : kLayouts) {
        char text[64];
        print_text(text, sizeof text, "%s%u (%s), %016llx", known.empty() ? "" : " or ", one->id, one->name,
                   static_cast<unsigned long long>(layout_hash(*one)));
        known += text;
    }
    fail(Status::format, "%s: layout = %u, hash = %016llx: must be %s", kBlob, id,
         static_cast<unsigned long long>(hash), known.c_str());
}

std::vector<Block> weight_blocks(const Layout &layout, Encoding encoding) {
    std::vector<Block> blocks;
    for (const Tensor &tensor : layout.tensors)
        blocks.push_back({tensor.count(), encoding});
    return blocks;
}

// The reference is always the sum of two float32 planes, because its rounding error would shift every latent.
std::vector<Block> plane_blocks(const Preprocess &preprocess, Encoding encoding) {
    std::vector<Block> blocks(kFixedPlanes + preprocess.projected, {preprocess.pixels(), encoding});
    blocks[kReferenceHigh].encoding = blocks[kReferenceLow].encoding = Encoding::float32;
    blocks[kVariance].positive = true;
    return blocks;
}

Buffer<float> planes_of(const Preprocess &preprocess) {
    Buffer<float> planes;
    planes.reserve((kFixedPlanes + preprocess.projected) * preprocess.pixels());
    const auto append = [&](const Buffer<double> &plane) {
        for (const double value : plane)
            planes.push_back(static_cast<float>(value));
    };
    append(preprocess.reference);
    for (size_t i = 0; i < preprocess.pixels(); i++)
        planes.push_back(static_cast<float>(preprocess.reference[i] - static_cast<double>(planes[i])));
    for (const double variance : preprocess.variance)
        planes.push_back(std::isfinite(variance) ? static_cast<float>(variance) : 0);
    append(preprocess.target);
    append(preprocess.nuisance_basis);
    return planes;
}

void set_planes(const Buffer<float> &planes, Preprocess &preprocess) {
    const size_t pixels = preprocess.pixels();
    const auto at = [&](size_t plane) { return planes.begin() + static_cast<std::ptrdiff_t>(plane * pixels); };
    preprocess.reference.assign(at(kReferenceHigh), at(kReferenceLow));
    std::transform(at(kReferenceLow), at(kVariance), preprocess.reference.begin(), preprocess.reference.begin(),
                   [](float low, double high) { return high + static_cast<double>(low); });
    preprocess.variance.assign(at(kVariance), at(kTarget));
    preprocess.target.assign(at(kTarget), at(kFixedPlanes));
    preprocess.nuisance_basis.assign(at(kFixedPlanes), planes.end());
    for (size_t i = 0; i < pixels; i++)
        if (!(preprocess.variance[i] >= 0))
            fail(Status::format, "%s: {variance[%zu]} = %g: must be positive, or 0 for a bad pixel", kBlob, i,
                 preprocess.variance[i]);
        else if (preprocess.variance[i] == 0)
            preprocess.variance[i] = std::numeric_limits<double>::infinity();
    preprocess.derive();
    if (preprocess.noise.used <= preprocess.projected + 1)
        fail(Status::format, "%s: {variance}: only %zu pixels are not bad", kBlob, preprocess.noise.used);
}

Encoding read_encoding(ByteReader &reader, const char *what) {
    const uint16_t code = reader.u16();
    if (code >= kEncodings)
        fail(Status::format, "%s: encoding of the %s = %u: must be 0 (float32), 1 (bf16) or 2 (fp16)", kBlob, what,
             code);
    return static_cast<Encoding>(code);
}

// Each number of nuisance planes has one version, so that a blob that was loaded saves to the same bytes.
void check_projected(uint32_t version, size_t projected) {
    const bool many = version == kManyPlanesVersion;
    const size_t fewest = many ? kFewPlanes + 1 : 0, most = many ? kMaxProjected : kFewPlanes;
    if (projected < fewest || projected > most)
        fail(Status::format, "%s: number of nuisance planes = %zu: must be in [%zu, %zu] in version %u", kBlob,
             projected, fewest, most, version);
}

// What a crop needs to follow the image.
void read_background(ByteReader &reader, Preprocess &preprocess) {
    preprocess.background = reader.f64();
    if (!(std::fabs(preprocess.background) <= kMaxMagnitude))
        fail(Status::format, "%s: background = %g counts: must be in [%.3g, %.3g]", kBlob, preprocess.background,
             -kMaxMagnitude, kMaxMagnitude);
    const size_t side = preprocess.side;
    if (preprocess.rows == side && preprocess.cols == side)
        fail(Status::format, "%s: {flags}: a crop that follows the image needs frames above %zu x %zu px", kBlob, side,
             side);
}

void read_window(ByteReader &reader, DetectorWindow &window) {
    for (int64_t *place : {&window.row, &window.col}) {
        *place = static_cast<int64_t>(reader.u64());
        if (*place < 0 || *place > kMostPlace)
            fail(Status::format, "%s: window = %lld: must be in [0, 2^31]", kBlob, static_cast<long long>(*place));
    }
}

// Reads the remainder of the header. Sizes are checked before anything is allocated.
Header read_header(ByteReader &reader, size_t size) {
    Header header = {};
    Preprocess &preprocess = header.preprocess;
    reader.raw(4);
    const uint32_t version = reader.u32();
    reader.raw(8);
    const uint32_t id = reader.u32(), flags = reader.u32();
    const uint64_t hash = reader.u64();
    header.layout = &layout_of(id, hash);
    preprocess.side = header.layout->side;
    const uint32_t input = flags >> kInputShift & kInputMask;
    if ((flags & ~(kTrainedFlag | kInputMask << kInputShift | kTrainingFlag | kFollowFlag | kWindowFlag)) != 0 ||
        input > kLastInput)
        fail(Status::format, "%s: {flags} = 0x%x: must set bits 0 to 5 only, with bits 1 and 2 in [0, 2]", kBlob,
             flags);
    header.trained = (flags & kTrainedFlag) != 0;
    header.with_training = (flags & kTrainingFlag) != 0;
    preprocess.input = static_cast<Input>(input);
    preprocess.centre = (flags & kFollowFlag) != 0 ? Centre::image : Centre::scene;
    preprocess.scene_digest = reader.u64();
    header.seed = reader.u64();
    preprocess.rows = reader.u32();
    preprocess.cols = reader.u32();
    preprocess.crop_row = reader.u32();
    preprocess.crop_col = reader.u32();
    const size_t side = preprocess.side;
    for (const size_t extent : {preprocess.rows, preprocess.cols})
        if (extent < side || extent > kLargestFrame)
            fail(Status::format, "%s: frame shape = [%zu, %zu]: must be in [%zu, %u] px", kBlob, preprocess.rows,
                 preprocess.cols, side, kLargestFrame);
    if (preprocess.crop_row > preprocess.rows - side || preprocess.crop_col > preprocess.cols - side)
        fail(Status::format, "%s: crop = [%zu, %zu]: must lie in a frame of %zu x %zu px", kBlob, preprocess.crop_row,
             preprocess.crop_col, preprocess.rows, preprocess.cols);
    preprocess.projected = reader.u32();
    if (preprocess.projected > 0 && preprocess.input != Input::whitened)
        fail(Status::format, "%s: number of nuisance planes = %zu: must be 0 for %s input", kBlob, preprocess.projected,
             name_of(preprocess.input));
    check_projected(version, preprocess.projected);
    header.weights = read_encoding(reader, "weights");
    header.planes = read_encoding(reader, "planes");
    preprocess.input_scale = reader.f64();
    preprocess.crb_px = reader.f64();
    header.cosine = reader.f64();
    if (!(preprocess.input_scale >= kMinMagnitude && preprocess.input_scale <= kMaxMagnitude))
        fail(Status::format, "%s: input scale = %g: must be in [%.3g, %.3g]", kBlob, preprocess.input_scale,
             kMinMagnitude, kMaxMagnitude);
    if (!(preprocess.crb_px >= 0 && preprocess.crb_px <= kMaxMagnitude) || !(header.cosine >= 0 && header.cosine <= 1))
        fail(Status::format, "%s: bound = %g px, cosine = %g: must be in [0, %.3g] px and [0, 1]", kBlob,
             preprocess.crb_px, header.cosine, kMaxMagnitude);
    header.packed_weights = reader.u32();
    header.packed_planes = reader.u32();
    if ((flags & kWindowFlag) != 0)
        preprocess.window.emplace();
    if (preprocess.centre == Centre::image)
        read_background(reader, preprocess);
    if (preprocess.window)
        read_window(reader, *preprocess.window);
    if (header.with_training ? size < header.known() + kTrainingHeaderSize : size != header.known())
        fail(Status::format, "%s: payload sizes = %zu and %zu bytes: do not match the blob's %zu bytes", kBlob,
             header.packed_weights, header.packed_planes, size);
    return header;
}

// Blocks of a training: weights and both optimiser moments.
std::vector<Block> training_blocks(const Layout &layout) {
    std::vector<Block> blocks;
    for (int i = 0; i < 3; i++)
        for (const Tensor &tensor : layout.tensors)
            blocks.push_back({tensor.count(), Encoding::float32});
    return blocks;
}

void write_training(const Training &training, const std::vector<uint8_t> &packed, ByteWriter &writer) {
    writer.u32(static_cast<uint32_t>(training.course.mode));
    writer.u32(training.done);
    for (const uint64_t value :
         {training.steps, training.course.total, training.course.frames, training.course.validation})
        writer.u64(value);
    writer.u32(training.course.batch);
    writer.u32(static_cast<uint32_t>(packed.size()));
    for (const double value : {training.course.learning_rate, training.loss, training.validation_loss})
        writer.f64(value);
    writer.raw(packed.data(), packed.size());
}

std::vector<uint8_t> pack_training(const Training &training) {
    Buffer<float> values;
    for (const Parameters *part : {&training.weights, &training.first, &training.second})
        values.insert(values.end(), part->values.begin(), part->values.end());
    return pack(values, training_blocks(*training.weights.layout), "training");
}

void check_range(const char *name, uint64_t value, uint64_t least, uint64_t most) {
    if (value < least || value > most)
        fail(Status::format, "%s: training: {%s} = %llu: must be in [%llu, %llu]", kBlob, name,
             static_cast<unsigned long long>(value), static_cast<unsigned long long>(least),
             static_cast<unsigned long long>(most));
}

// Accepts only states that a training can reach: counters must agree with each other.
void check_training(const Training &training, const Header &header) {
    const Course &course = training.course;
    const bool tied = course.mode == Mode::tied;
    check_range("mode", static_cast<uint32_t>(course.mode),
                can_be_tied(*header.layout, header.preprocess.input) ? 0 : 1, 1);
    check_range("steps in all", course.total, tied ? 1 : 0, tied ? UINT32_MAX : 0);
    check_range("frames", course.frames, tied ? 0 : 2, tied ? 0 : kMostFrames);
    check_range("validation", course.validation, tied ? 0 : 1, tied ? 0 : course.frames - 1);
    check_range("batch", course.batch, tied ? 0 : 1, tied ? 0 : kLargestBatch);
    check_range("done", training.done, 1, tied ? course.total : UINT32_MAX);
    const uint64_t frames = course.frames - course.validation;
    const uint64_t steps = training.done * (tied ? 1 : (frames + course.batch - 1) / course.batch);
    check_range("steps of the optimiser", training.steps, steps, steps);
    if (!(course.learning_rate > 0 && course.learning_rate <= 1))
        fail(Status::format, "%s: training: learning rate = %g: must be in (0, 1]", kBlob, course.learning_rate);
    for (const double loss : {training.loss, training.validation_loss})
        if (!(loss >= 0 && loss <= kMaxMagnitude))
            fail(Status::format, "%s: training: loss = %g: must be in [0, %.3g]", kBlob, loss, kMaxMagnitude);
}

Training read_training(ByteReader &reader, size_t size, const Header &header) {
    Training training(*header.layout);
    training.course.mode = static_cast<Mode>(reader.u32());
    training.done = reader.u32();
    for (uint64_t *value :
         {&training.steps, &training.course.total, &training.course.frames, &training.course.validation})
        *value = reader.u64();
    training.course.batch = reader.u32();
    const uint32_t packed = reader.u32();
    if (packed != size - kTrainingHeaderSize)
        fail(Status::format, "%s: training: payload size = %u bytes: must be %zu", kBlob, packed,
             size - kTrainingHeaderSize);
    for (double *value : {&training.course.learning_rate, &training.loss, &training.validation_loss})
        *value = reader.f64();
    check_training(training, header);
    const Buffer<float> values = unpack(reader.raw(packed), packed, training_blocks(*header.layout), "training");
    auto from = values.begin();
    for (Parameters *part : {&training.weights, &training.first, &training.second}) {
        std::copy_n(from, part->values.size(), part->values.begin());
        from += static_cast<std::ptrdiff_t>(part->values.size());
    }
    return training;
}

} // namespace

std::vector<uint8_t> to_blob(const Network &network, const Encodings &encodings, const Training *training) {
    const Preprocess &preprocess = network.preprocess();
    const std::vector<uint8_t> weights =
        pack(network.parameters().values, weight_blocks(network.layout(), encodings.weights), "weights");
    const std::vector<uint8_t> planes =
        pack(planes_of(preprocess), plane_blocks(preprocess, encodings.planes), "planes");
    const std::vector<uint8_t> state = training != nullptr ? pack_training(*training) : std::vector<uint8_t>();
    const bool follows = preprocess.centre == Centre::image;
    ByteWriter writer;
    writer.raw(kMagic, 4);
    writer.u32(preprocess.projected > kFewPlanes ? kManyPlanesVersion : kVersion);
    writer.u64(kHeaderSize + optional_size(preprocess) + weights.size() + planes.size() +
               (training != nullptr ? kTrainingHeaderSize + state.size() : 0) + kChecksumSize);
    writer.u32(network.layout().id);
    writer.u32((network.trained() ? kTrainedFlag : 0) | static_cast<uint32_t>(preprocess.input) << kInputShift |
               (training != nullptr ? kTrainingFlag : 0) | (follows ? kFollowFlag : 0) |
               (preprocess.window ? kWindowFlag : 0));
    writer.u64(layout_hash(network.layout()));
    writer.u64(preprocess.scene_digest);
    writer.u64(network.seed());
    for (const size_t value :
         {preprocess.rows, preprocess.cols, preprocess.crop_row, preprocess.crop_col, preprocess.projected})
        writer.u32(static_cast<uint32_t>(value));
    writer.u16(static_cast<uint16_t>(encodings.weights));
    writer.u16(static_cast<uint16_t>(encodings.planes));
    writer.f64(preprocess.input_scale);
    writer.f64(preprocess.crb_px);
    writer.f64(network.cosine());
    writer.u32(static_cast<uint32_t>(weights.size()));
    writer.u32(static_cast<uint32_t>(planes.size()));
    if (follows)
        writer.f64(preprocess.background);
    if (preprocess.window)
        for (const int64_t place : {preprocess.window->row, preprocess.window->col})
            writer.u64(static_cast<uint64_t>(place));
    writer.raw(weights.data(), weights.size());
    writer.raw(planes.data(), planes.size());
    if (training != nullptr)
        write_training(*training, state, writer);
    writer.u32(zip::crc32(writer.bytes().data(), writer.bytes().size()));
    return writer.take();
}

Blob from_blob(const void *bytes, size_t size) {
    check_envelope(bytes, size, kBlob, kMagic, {kVersion, kManyPlanesVersion}, kHeaderSize);
    ByteReader reader(bytes, size, kBlob);
    Header header = read_header(reader, size);
    Parameters parameters(*header.layout);
    parameters.values = unpack(reader.raw(header.packed_weights), header.packed_weights,
                               weight_blocks(*header.layout, header.weights), "weights");
    set_planes(unpack(reader.raw(header.packed_planes), header.packed_planes,
                      plane_blocks(header.preprocess, header.planes), "planes"),
               header.preprocess);
    std::optional<Training> training;
    if (header.with_training)
        training = read_training(reader, size - header.known(), header);
    return {Network(std::move(header.preprocess), std::move(parameters), header.seed, header.trained, header.cosine),
            std::move(training)};
}

} // namespace toliman::cae
