// Method: header of 96 bytes, dates, networks, weights of all networks (cae/payload.hpp) and CRC32; little-endian. Of
// each network the encoder is stored: no preprocessing, because the model of the fit has all images, and no decoder.
//
// The file is untrusted input. The reader checks size and CRC32 first, then every number against its range, and only
// then inflates the weights, to exactly the size that the number of networks implies.
#include "bank/weights.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "backend/zip.hpp"
#include "base/bytes.hpp"
#include "base/error.hpp"

namespace toliman::bank {

namespace {

using cae::Block;
using cae::Encoding;
using cae::kChecksumSize;

constexpr char kMagic[] = "TLMB";
constexpr const char *kKind = "bank";
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderSize = 96, kDateSize = 24, kNetworkSize = 72;
constexpr size_t kStored = cae::kLatentBias + 1; // tensors of the encoder
constexpr double kMostPx = kLargestFrame;

// Weights of one network.
constexpr size_t stored_of(const cae::Layout &layout) noexcept {
    return layout.offsets[kStored];
}

std::vector<Block> blocks_of(const cae::Layout &layout, size_t networks, Encoding encoding) {
    std::vector<Block> blocks;
    for (size_t i = 0; i < networks; i++)
        for (size_t tensor = 0; tensor < kStored; tensor++)
            blocks.push_back({layout.tensors[tensor].count(), encoding});
    return blocks;
}

double in_range(const char *name, double value, double least, double most) {
    if (!(value >= least && value <= most))
        fail(Status::format, "%s: {%s} = %g: must be in [%g, %g]", kKind, name, value, least, most);
    return value;
}

uint32_t in_range(const char *name, uint32_t value, size_t least, size_t most) {
    if (value < least || value > most)
        fail(Status::format, "%s: {%s} = %u: must be in [%zu, %zu]", kKind, name, value, least, most);
    return value;
}

struct Header {
    Options options;
    Encoding encoding;
    size_t rows, cols, dates, packed;
    uint64_t fit_digest;
    size_t networks() const noexcept { return dates * options.places * options.places; }
};

Header read_header(ByteReader &reader, size_t size) {
    Header header = {};
    Options &options = header.options;
    reader.raw(16);
    const uint32_t layout = reader.u32(), encoding = reader.u32();
    const uint64_t hash = reader.u64();
    options.layout = cae::find_layout(layout);
    if (options.layout == nullptr || hash != cae::layout_hash(*options.layout))
        fail(Status::format, "%s: {layout} = %u: unknown", kKind, layout);
    header.encoding = static_cast<Encoding>(in_range("encoding", encoding, 0, cae::kEncodings - 1));
    header.fit_digest = reader.u64();
    options.seed = reader.u64();
    options.first_days = in_range("first_days", reader.f64(), -kMostDays, kMostDays);
    options.last_days = in_range("last_days", reader.f64(), options.first_days, kMostDays);
    options.spacing_px = in_range("spacing_px", reader.f64(), kLeastSpacingPx, kMostSpacingPx);
    options.places = in_range("places", reader.u32(), 1, kMostPlaces);
    options.steps = in_range("steps", reader.u32(), 1, kMostSteps);
    header.rows = in_range("rows", reader.u32(), options.layout->side, kLargestFrame);
    header.cols = in_range("cols", reader.u32(), options.layout->side, kLargestFrame);
    header.dates = in_range("dates", reader.u32(), 1, kMostNetworks / (size_t{options.places} * options.places));
    header.packed = reader.u32();
    const size_t known =
        kHeaderSize + header.dates * kDateSize + header.networks() * kNetworkSize + header.packed + kChecksumSize;
    if (size != known)
        fail(Status::format, "%s: size = %zu bytes: must be %zu", kKind, size, known);
    return header;
}

std::vector<Date> read_dates(ByteReader &reader, const Header &header) {
    std::vector<Date> dates;
    const Options &options = header.options;
    for (size_t i = 0; i < header.dates; i++) {
        Date date = {};
        for (double *days : {&date.days, &date.first, &date.last})
            *days = in_range("days", reader.f64(), options.first_days, options.last_days);
        dates.push_back(date);
    }
    return dates;
}

double read_cosine(ByteReader &reader, double least) {
    return in_range("cosine", reader.f64(), least, 1.0);
}

cae::Response read_response(ByteReader &reader) {
    cae::Response response;
    response.gain = in_range("gain", reader.f64(), -cae::kMaxMagnitude, cae::kMaxMagnitude);
    response.share = in_range("efficiency", reader.f64(), 0.0, 1.0);
    if (response.gain == 0)
        fail(Status::format, "%s: {gain} = 0: must not be 0", kKind);
    return response;
}

// What a network is, apart from its weights.
struct Numbers {
    double star_px[2][2], share_b, cosine;
    uint32_t crop_row, crop_col;
    cae::Response response;
};

Numbers read_numbers(ByteReader &reader, const Header &header) {
    Numbers numbers = {};
    for (auto &star : numbers.star_px)
        for (double &coordinate : star)
            coordinate = in_range("place", reader.f64(), -kMostPx, kMostPx);
    numbers.share_b = in_range("share", reader.f64(), 0.0, 1.0);
    numbers.crop_row = in_range("crop_row", reader.u32(), 0, header.rows - header.options.layout->side);
    numbers.crop_col = in_range("crop_col", reader.u32(), 0, header.cols - header.options.layout->side);
    numbers.cosine = read_cosine(reader, 0);
    numbers.response = read_response(reader);
    return numbers;
}

// Of the stored weights of network i.
cae::Encoder encoder_of(const cae::Layout &layout, const float *weights, size_t i) {
    cae::Parameters parameters(layout);
    std::copy_n(weights, stored_of(layout), parameters.values.begin());
    for (size_t stage = 0; stage <= cae::kStages; stage++) {
        const size_t tensor = cae::conv_bias(stage); // conv_bias(kStages) is that of the latent
        if (const float *const biases = parameters[tensor];
            std::any_of(biases, biases + layout.tensors[tensor].count(), [](float value) { return value != 0; }))
            fail(Status::format, "%s: %s of network %zu: must be 0", kKind, layout.tensors[tensor].name, i);
    }
    cae::Encoder encoder(std::move(parameters));
    const Buffer<float> &gradient = encoder.gradient();
    if (std::all_of(gradient.begin(), gradient.end(), [](float value) { return value == 0; }))
        fail(Status::format, "%s: weights of network %zu: the latent does not depend on the image", kKind, i);
    return encoder;
}

} // namespace

size_t weight_bytes(const cae::Layout &layout, Encoding encoding) noexcept {
    return stored_of(layout) * (encoding == Encoding::float32 ? 4 : 2);
}

size_t most_bytes() noexcept {
    return kHeaderSize + kMostNetworks * (kDateSize + kNetworkSize + 2 * weight_bytes(cae::kFlight, Encoding::float32));
}

std::vector<uint8_t> to_bytes(const Bank &bank, Encoding encoding) {
    const Options &options = bank.options();
    const cae::Layout &layout = *options.layout;
    Buffer<float> weights;
    for (const Network &network : bank.networks()) {
        const Buffer<float> &values = network.encoder.weights().values;
        weights.insert(weights.end(), values.begin(), values.begin() + static_cast<std::ptrdiff_t>(stored_of(layout)));
    }
    const std::vector<uint8_t> packed =
        cae::pack(weights, blocks_of(layout, bank.networks().size(), encoding), "weights");
    ByteWriter writer;
    writer.raw(kMagic, 4);
    writer.u32(kVersion);
    writer.u64(kHeaderSize + bank.dates().size() * kDateSize + bank.networks().size() * kNetworkSize + packed.size() +
               kChecksumSize);
    writer.u32(layout.id);
    writer.u32(static_cast<uint32_t>(encoding));
    for (const uint64_t value : {cae::layout_hash(layout), bank.fit_digest(), options.seed})
        writer.u64(value);
    for (const double value : {options.first_days, options.last_days, options.spacing_px})
        writer.f64(value);
    for (const size_t value :
         {size_t{options.places}, size_t{options.steps}, bank.rows(), bank.cols(), bank.dates().size(), packed.size()})
        writer.u32(static_cast<uint32_t>(value));
    for (const Date &date : bank.dates())
        for (const double days : {date.days, date.first, date.last})
            writer.f64(days);
    for (const Network &network : bank.networks()) {
        for (const auto &star : network.star_px)
            for (const double coordinate : star)
                writer.f64(coordinate);
        writer.f64(network.share_b);
        writer.u32(network.crop_row);
        writer.u32(network.crop_col);
        for (const double value : {network.cosine, network.response.gain, network.response.share})
            writer.f64(value);
    }
    writer.raw(packed.data(), packed.size());
    writer.u32(zip::crc32(writer.bytes().data(), writer.bytes().size()));
    return writer.take();
}

std::vector<uint8_t> training_of(const Network &network) {
    ByteWriter writer;
    for (const double value : {network.cosine, network.response.gain, network.response.share})
        writer.f64(value);
    const cae::Layout &layout = network.encoder.layout();
    const float *const values = network.encoder.weights().values.data();
    const std::vector<uint8_t> packed = cae::pack(Buffer<float>(values, values + stored_of(layout)),
                                                  blocks_of(layout, 1, Encoding::float32), "weights");
    writer.raw(packed.data(), packed.size());
    return writer.take();
}

void set_training(const std::vector<uint8_t> &bytes, size_t i, const Options &options, Network &network) {
    ByteReader reader(bytes.data(), bytes.size(), kKind);
    const double cosine = read_cosine(reader, std::numeric_limits<double>::min());
    network.response = read_response(reader);
    const size_t packed = reader.left();
    const Buffer<float> weights =
        cae::unpack(reader.raw(packed), packed, blocks_of(*options.layout, 1, Encoding::float32), "weights");
    network.encoder = encoder_of(*options.layout, weights.data(), i);
    network.cosine = cosine;
}

Bank from_bytes(const void *bytes, size_t size) {
    cae::check_envelope(bytes, size, kKind, kMagic, {kVersion}, kHeaderSize);
    ByteReader reader(bytes, size, kKind);
    const Header header = read_header(reader, size);
    std::vector<Date> dates = read_dates(reader, header);
    std::vector<Numbers> numbers;
    for (size_t i = 0; i < header.networks(); i++)
        numbers.push_back(read_numbers(reader, header));
    const Buffer<float> weights =
        cae::unpack(reader.raw(header.packed), header.packed,
                    blocks_of(*header.options.layout, header.networks(), header.encoding), "weights");
    std::vector<Network> networks;
    for (size_t i = 0; i < header.networks(); i++) {
        const Numbers &known = numbers[i];
        cae::Encoder encoder = encoder_of(*header.options.layout, &weights[i * stored_of(*header.options.layout)], i);
        Network network = new_network(i, header.options, std::move(encoder));
        std::copy_n(&known.star_px[0][0], 4, &network.star_px[0][0]);
        network.share_b = known.share_b;
        network.crop_row = known.crop_row;
        network.crop_col = known.crop_col;
        network.cosine = known.cosine;
        network.response = known.response;
        networks.push_back(std::move(network));
    }
    return Bank(header.options, header.rows, header.cols, header.fit_digest, std::move(dates), std::move(networks));
}

} // namespace toliman::bank
