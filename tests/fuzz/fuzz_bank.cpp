// Banks of networks: a bank that loads has networks in range, and saves to the same bytes (except for the compression,
// so that the second save is compared).
#include <cmath>
// promises: damaged-banks-are-refused, parsers-are-safe

#include <toliman/toliman.hpp>

#include "cae/layout.hpp"
#include "cae/payload.hpp"
#include "fuzz.hpp"

using namespace fuzz;
using namespace toliman;

namespace {

constexpr size_t kHeader = 96, kDate = 24, kNetwork = 72, kAtSize = 8, kAtEncoding = 20, kAtPlaces = 72, kAtDates = 88,
                 kAtPacked = 92;

toliman_bank *load(const Bytes &bytes) {
    toliman_bank *bank = nullptr;
    const toliman_status status = toliman_bank_load(bytes.data(), bytes.size(), nullptr, &bank);
    require(status == TOLIMAN_OK || status == TOLIMAN_E_FORMAT, toliman_last_error());
    require((status == TOLIMAN_OK) == (bank != nullptr), "a result despite an error");
    return bank;
}

// With the encoding that it was loaded with.
Bytes save(const toliman_bank *bank, const Bytes &like) {
    const int32_t encoding = TOLIMAN_CAE_ENCODING_FLOAT32 + like[kAtEncoding];
    size_t size = 0;
    require(toliman_bank_save(bank, encoding, nullptr, 0, &size) == TOLIMAN_E_CAPACITY, toliman_last_error());
    Bytes bytes(size);
    require(toliman_bank_save(bank, encoding, bytes.data(), size, &size) == TOLIMAN_OK, toliman_last_error());
    return bytes;
}

void check_networks(const toliman_bank *bank) {
    auto info = toliman::sized<toliman_bank_info>();
    require(toliman_bank_get_info(bank, &info) == TOLIMAN_OK, toliman_last_error());
    require(info.networks == info.dates * info.places && info.networks <= 1024, "impossible information");
    int64_t trained = 0;
    for (int64_t i = 0; i < info.networks; i++) {
        auto network = toliman::sized<toliman_bank_network>();
        require(toliman_bank_get_network(bank, i, &network) == TOLIMAN_OK, toliman_last_error());
        require(network.cosine >= 0 && network.cosine <= 1, "an impossible cosine");
        require(network.days >= info.first_days && network.days <= info.last_days, "a date outside the bank");
        require(std::fabs(network.x_px) <= 0.5 && std::fabs(network.y_px) <= 0.5, "a place outside the pixel");
        trained += network.trained;
    }
    require(trained == info.trained_networks, "another number of trained networks");
}

// Sizes and checksum consistent with the bytes.
void repair(Bytes &bytes, unsigned seed) {
    if (bytes.size() < kHeader + 4)
        return;
    put(bytes, kAtSize, bytes.size(), 8);
    const size_t places = bytes[kAtPlaces], dates = bytes[kAtDates],
                 known = kHeader + dates * kDate + dates * places * places * kNetwork + 4;
    if (seed % 3 != 0 && known <= bytes.size())
        put(bytes, kAtPacked, bytes.size() - known, 4);
    seal(bytes);
}

} // namespace

// Weights that compress well: one network, four places, or two dates.
std::vector<Bytes> fuzz::seeds() {
    std::vector<Bytes> seeds;
    for (uint32_t kind = 0; kind < 9; kind++) {
        const uint32_t encoding = kind % 3, layout = 1 + kind / 3, places = kind == 1 ? 2 : 1,
                       dates = kind == 2 ? 2 : 1;
        const cae::Layout &of = *cae::find_layout(layout);
        std::vector<cae::Block> blocks;
        Buffer<float> values; // biases 0
        for (uint32_t i = 0; i < dates * places * places; i++)
            for (size_t tensor = 0; tensor <= cae::kLatentBias; tensor++) {
                blocks.push_back({of.tensors[tensor].count(), static_cast<cae::Encoding>(encoding)});
                values.resize(values.size() + blocks.back().count, tensor % 2 == 0 ? 0.015625F : 0);
            }
        const Bytes weights = cae::pack(values, blocks, "seed");
        ByteWriter out;
        out.raw("TLMB", 4);
        out.u32(1);
        out.u64(kHeader + dates * (kDate + places * places * kNetwork) + weights.size() + 4);
        out.u32(layout);
        out.u32(encoding);
        for (const uint64_t value : {cae::layout_hash(of), uint64_t{7}, uint64_t{1}})
            out.u64(value);
        for (const double value : {0.0, 100.0, 0.5})
            out.f64(value);
        for (const uint32_t value : {places, 600u, 256u, 270u, dates, static_cast<uint32_t>(weights.size())})
            out.u32(value);
        for (uint32_t i = 0; i < dates; i++)
            for (const double days : {25.0, 0.0, 50.0})
                out.f64(days);
        for (uint32_t i = 0; i < dates * places * places; i++) {
            for (const double value : {-5.0, 8.0, 15.0, -24.0, 0.75})
                out.f64(value);
            out.u32(0);
            out.u32(7);
            for (const double value : {0.875, 1.0, 1.0})
                out.f64(value);
        }
        out.raw(weights.data(), weights.size());
        out.u32(0);
        seeds.push_back(out.take());
        seal(seeds.back());
    }
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const Bytes bytes(data, data + size);
    toliman_bank *const bank = size > 0 ? load(bytes) : nullptr;
    if (bank == nullptr)
        return 0;
    check_networks(bank);
    fuzz::accepted++;
    if (zip::crc32(data, size) % 4 == 0) { // all of them would take too long
        const Bytes saved = save(bank, bytes);
        toliman_bank *const again = load(saved);
        require(again != nullptr && save(again, bytes) == saved, "saved bytes differ from the loaded ones");
        toliman_bank_destroy(again);
    }
    toliman_bank_destroy(bank);
    return 0;
}

// Mostly in the header, dates and networks, which have most of the meaning.
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed) {
    constexpr size_t kHead = kHeader + kDate + kNetwork;
    Bytes bytes(data, data + size);
    if (seed % 4 != 0 && size > kHead) {
        Bytes head(bytes.begin(), bytes.begin() + kHead);
        mutate(head, kHead);
        head.resize(kHead);
        std::copy(head.begin(), head.end(), bytes.begin());
    } else {
        mutate(bytes, most);
    }
    if (seed / 4 % 8 != 0)
        repair(bytes, seed / 32);
    return give(bytes, data, most);
}
