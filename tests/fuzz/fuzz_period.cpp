// States of a periodogram: a state that loads answers every query, gives finite numbers, and saves to the same bytes.
#include <cmath>
// promises: damaged-states-are-refused, parsers-are-safe

#include <toliman/toliman.hpp>

#include "fuzz.hpp"
#include "period/stream/stream.hpp"

using namespace fuzz;

namespace {

constexpr uint32_t kNuisance = 1u << 31; // of seeds only
constexpr size_t kHeader = toliman::period::Stream::kHeaderSize, kMostFrequencies = 64;

Bytes saved(const toliman_period *period) {
    size_t size = 0;
    require(toliman_period_save(period, nullptr, 0, &size) == TOLIMAN_E_CAPACITY, "no size of the state");
    Bytes bytes(size);
    require(toliman_period_save(period, bytes.data(), size, &size) == TOLIMAN_OK, "the state cannot be saved");
    return bytes;
}

void check_power(const toliman_period *period, size_t count) {
    double power[kMostFrequencies];
    for (int32_t normalisation = TOLIMAN_PERIOD_POWER_STANDARD; normalisation <= TOLIMAN_PERIOD_POWER_PSD;
         normalisation++) {
        if (toliman_period_query_power(period, normalisation, 0, count, power) != TOLIMAN_OK)
            continue;
        for (size_t k = 0; k < count; k++)
            require(power[k] >= 0 && (normalisation != TOLIMAN_PERIOD_POWER_STANDARD || power[k] <= 1),
                    "impossible power");
    }
}

void check_peak(const toliman_period *period) {
    auto peak = toliman::sized<toliman_period_peak>();
    auto model = toliman::sized<toliman_period_model>();
    auto sampling = toliman::sized<toliman_period_sampling>();
    double fap = 0;
    if (toliman_period_query_peak(period, &peak) == TOLIMAN_OK)
        require(peak.power >= 0 && peak.power <= 1 && peak.log10_fap <= 0 && std::isfinite(peak.frequency),
                "impossible peak");
    if (toliman_period_query_model(period, 0, &model) == TOLIMAN_OK)
        require(model.power >= 0 && model.power <= 1 && !std::isnan(model.amplitude), "impossible model");
    if (toliman_period_query_sampling(period, nullptr, 0, &sampling) == TOLIMAN_OK)
        require(!std::isnan(sampling.baseline), "impossible sampling");
    for (int32_t method = TOLIMAN_PERIOD_FAP_BALUEV; method <= TOLIMAN_PERIOD_FAP_SEQUENTIAL; method++)
        if (toliman_period_query_fap(period, method, -3, &fap) == TOLIMAN_OK)
            require(std::isfinite(fap) && fap <= 0, "impossible false alarm probability");
}

// A sample that is pushed and retracted leaves the same bytes.
void check_push(toliman_period *period, const Bytes &before) {
    auto info = toliman::sized<toliman_period_info>();
    require(toliman_period_get_info(period, &info) == TOLIMAN_OK, "no information");
    auto sample = toliman::sized<toliman_period_sample>();
    sample.t = info.trend > 0 ? info.trend_start : info.time_offset + 1;
    sample.y = info.value_offset;
    sample.sigma = info.sigma_floor;
    const double row[8] = {};
    if (toliman_period_push_samples(period, &sample, row, 1) != TOLIMAN_OK)
        return;
    require(toliman_period_retract_samples(period, &sample, row, 1) == TOLIMAN_OK, "a sample cannot be retracted");
    require(saved(period) == before, "a retracted sample changed the state");
}

// Completes a state to its full size with correct digest and checksum, as far as its header is meaningful.
void repair(Bytes &bytes) {
    namespace period = toliman::period;
    if (bytes.size() < kHeader)
        return seal(bytes);
    Bytes head(bytes.begin(), bytes.begin() + kHeader);
    period::Grid grid;
    toliman::ByteReader in(head.data(), head.size(), "");
    in.raw(4);
    const uint32_t version = in.u32(), flags = in.u32(), numbers = in.u32();
    grid.fixed_mean = (flags & 1) != 0;
    grid.double_limb_sums = (flags & 2) != 0;
    grid.nf = in.i64();
    for (double *value : {&grid.f0, &grid.df, &grid.time_offset, &grid.value_offset, &grid.value_bound,
                          &grid.sigma_floor, &grid.sigma_ceiling})
        *value = in.f64();
    grid.time_offset_ns = in.i64();
    grid.unit_ns = in.f64();
    if (version == 4 && numbers < 0x900) { // with nuisance functions
        grid.basis.trend = static_cast<int32_t>(numbers & 0xff);
        grid.basis.columns = static_cast<int32_t>(numbers >> 8);
        const bool few = grid.basis.functions() <= period::kMaxFunctions;
        if (few && bytes.size() >= kHeader + grid.basis.saved_size()) {
            toliman::ByteReader rest(bytes.data() + kHeader, grid.basis.saved_size(), "");
            grid.basis.load(rest);
        } else {
            grid.basis = {};
        }
    }
    put(bytes, kHeader - 8, grid.digest(), 8);
    try {
        const size_t size = period::Stream::saved_size(bytes.data(), kHeader);
        if (grid.nf <= static_cast<int64_t>(kMostFrequencies))
            bytes.resize(size);
    } catch (const toliman::Error &) {
    }
    seal(bytes);
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    std::vector<Bytes> seeds;
    for (const uint32_t flags : {0u, TOLIMAN_PERIOD_FIXED_MEAN, TOLIMAN_PERIOD_DOUBLE_LIMB, kNuisance}) {
        auto options = toliman::sized<toliman_period_options>();
        options.flags = flags & ~kNuisance;
        if (flags == kNuisance) {
            options.trend = 2;
            options.trend_end = 20;
            options.columns = 1;
            options.prior_precision[3] = 1;
        }
        toliman_period *period = nullptr;
        require(toliman_period_create(0.01, 0.02, 5, &options, &period) == TOLIMAN_OK, toliman_last_error());
        seeds.push_back(saved(period));
        for (int i = 0; i < 9; i++) {
            auto sample = toliman::sized<toliman_period_sample>();
            sample.t = i;
            sample.y = std::sin(i);
            sample.sigma = 1 + i % 3;
            const double row = std::cos(3 * i);
            require(toliman_period_push_samples(period, &sample, &row, 1) == TOLIMAN_OK, toliman_last_error());
        }
        seeds.push_back(saved(period));
        toliman_period_destroy(period);
    }
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    toliman_period *period = nullptr;
    const toliman_status status = toliman_period_load(data, size, nullptr, &period);
    require(status == TOLIMAN_OK || status == TOLIMAN_E_FORMAT, "unexpected error: not a format error");
    if (period == nullptr)
        return 0;
    fuzz::accepted++;
    const Bytes before = saved(period);
    require(before == Bytes(data, data + size), "saved bytes differ from the loaded ones");
    auto info = toliman::sized<toliman_period_info>();
    require(toliman_period_get_info(period, &info) == TOLIMAN_OK, "no information");
    check_power(period,
                info.nf < static_cast<int64_t>(kMostFrequencies) ? static_cast<size_t>(info.nf) : kMostFrequencies);
    check_peak(period);
    check_push(period, before);
    toliman_period *copy = nullptr;
    require(toliman_period_copy(period, &copy) == TOLIMAN_OK, "cannot be copied");
    const int64_t count = info.count;
    if (toliman_period_merge(period, copy) == TOLIMAN_OK)
        require(toliman_period_get_info(period, &info) == TOLIMAN_OK && info.count == 2 * count,
                "merging lost samples");
    toliman_period_destroy(copy);
    toliman_period_destroy(period);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed) {
    Bytes bytes(data, data + size);
    mutate(bytes, most);
    if (seed % 8 != 0)
        repair(bytes);
    return give(bytes, data, most);
}
