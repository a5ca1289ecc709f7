// Method: samples are pushed one by one to exact double-limb sums; the highest peak is then refined by least squares on
// the samples. The exact sums have fixed-point units, so their bounds must be known before the first sample: the time
// reference is the first time, the value reference the median, and the value bound the spread rounded up to a power of
// two. If the sums are saved, later samples may exceed those at hand: the value bound is multiplied by 2^20, and sigmas
// may be from 1/8 of the smallest to 4 times the largest, as far as the library's ratio of 1e8 allows.
#include "series/periodogram.hpp"

#include <algorithm>
#include <cmath>

#include "common/content.hpp"
#include "common/failure.hpp"
#include "common/library.hpp"
#include "common/output.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

constexpr double kFiner = 8, kCoarser = 4; // later sigmas: 1/kFiner of the smallest to kCoarser times the largest
constexpr double kFurther = 0x1p20;        // later values: within kFurther times the spread
constexpr double kMostRatio = 0.9e8;       // of sigma_ceiling over sigma_floor, below the library's limit of 1e8
constexpr double kLeastBound = 1e-99, kMostBound = 1e99;

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

FrequencyGrid suggested(const std::vector<double> &times, double mission_span) {
    FrequencyGrid grid = {};
    const toliman_status status = toliman_period_suggest(times.data(), nullptr, nullptr, times.size(), mission_span,
                                                         &grid.f0, &grid.df, &grid.nf, nullptr);
    if (status == TOLIMAN_E_RANGE)
        throw Failure(kExitUsage, std::string(toliman_last_error()) +
                                      "; `toliman period` accepts another grid by --f0, --df and --nf");
    toliman::check(status);
    return grid;
}

} // namespace

FrequencyGrid grid_of_days(double days) {
    return suggested({}, days);
}

FrequencyGrid default_grid(const Series &series) {
    std::vector<double> different = series.t;
    std::sort(different.begin(), different.end());
    different.erase(std::unique(different.begin(), different.end()), different.end());
    if (different.size() < 5)
        malformed(series.name,
                  "has " + std::to_string(different.size()) + " different times: a periodogram needs at least five");
    try {
        return suggested(different, 0);
    } catch (const Failure &failure) {
        throw Failure(failure.code(), series.name + ": " + failure.what());
    }
}

uint32_t flags_of(const SumOptions &sums) {
    return TOLIMAN_PERIOD_DOUBLE_LIMB | (sums.fixed_mean ? TOLIMAN_PERIOD_FIXED_MEAN : 0);
}

void set_unweighted(const SumOptions &sums, toliman_period_options &options) {
    options.sigma_floor = sums.sigma_floor.value_or(options.sigma_floor);
    options.sigma_ceiling = sums.sigma_ceiling.value_or(options.sigma_ceiling);
}

void set_sigmas(const SumOptions &sums, double least, double largest, toliman_period_options &options) {
    double floor = least, ceiling = largest;
    if (sums.margins) {
        floor = std::min(least, std::max(least / kFiner, largest / kMostRatio));
        ceiling = std::max(largest, std::min(largest * kCoarser, floor * kMostRatio));
    }
    options.sigma_floor = sums.sigma_floor.value_or(floor);
    options.sigma_ceiling = sums.sigma_ceiling.value_or(ceiling);
}

toliman::periodogram make_periodogram(const FrequencyGrid &grid, const toliman_period_options &options) {
    try {
        return toliman::make<toliman::periodogram>(toliman_period_create, grid.f0, grid.df, grid.nf, &options);
    } catch (const toliman::error &error) {
        if (error.status() != TOLIMAN_E_ARGUMENT)
            throw;
        const std::string &field = error.field();
        const bool bounds = field == "value_bound" || field == "sigma_floor" || field == "sigma_ceiling";
        throw Failure(kExitUsage, (bounds ? "--value-bound, --sigma-floor, --sigma-ceiling: " : "--f0, --df, --nf: ") +
                                      std::string(error.what()));
    }
}

std::string refusal(const toliman::periodogram &periodogram, double y, double sigma, bool from_state) {
    std::string why = toliman_last_error();
    const toliman_period_info info = info_of(periodogram);
    const char *option = std::fabs(y - info.value_offset) > info.value_bound ? "--value-bound"
                         : sigma < info.sigma_floor                          ? "--sigma-floor"
                         : sigma > info.sigma_ceiling                        ? "--sigma-ceiling"
                                                                             : nullptr;
    if (option == nullptr)
        return why;
    return why + " (" + option + (from_state ? " of the run that made the state)" : ")");
}

Periodogram find_period(const Series &series, const FrequencyGrid &grid, const SumOptions &sums, Progress &progress) {
    using namespace toliman;
    toliman_period_options options;
    toliman_period_options_init(&options, sizeof options);
    const auto [least, greatest] = std::minmax_element(series.y.begin(), series.y.end());
    const double spread = *greatest - *least;
    options.flags = flags_of(sums);
    options.time_offset = *std::min_element(series.t.begin(), series.t.end());
    options.value_offset = median(series.y);
    const double bound = std::exp2(std::ceil(std::log2(spread > 0 ? spread : 1.0))) * (sums.margins ? kFurther : 1);
    options.value_bound = sums.value_bound.value_or(std::clamp(bound, kLeastBound, kMostBound));
    const double *sigma = nullptr;
    if (series.sigma.empty()) {
        set_unweighted(sums, options);
    } else {
        const auto [finest, coarsest] = std::minmax_element(series.sigma.begin(), series.sigma.end());
        set_sigmas(sums, *finest, *coarsest, options);
        sigma = series.sigma.data();
    }
    Periodogram result = {make_periodogram(grid, options), options.time_offset, {}};
    for (size_t i = 0; i < series.t.size(); i++) {
        const double s = sigma != nullptr ? sigma[i] : options.sigma_floor;
        if (toliman_period_push(result.handle.get(), series.t[i], series.y[i], s) != TOLIMAN_OK)
            malformed(series.name,
                      "sample " + std::to_string(i + 1) + ": " + refusal(result.handle, series.y[i], s, false));
        progress.show("period", static_cast<double>(i + 1) / static_cast<double>(series.t.size()));
        stop_if_asked();
    }
    result.peak.struct_size = sizeof result.peak;
    check(toliman_period_query_fit(result.handle.get(), series.t.data(), series.y.data(), sigma, series.t.size(),
                                   &result.peak));
    stop_if_asked();
    return result;
}

toliman::periodogram load_state(const std::string &path) {
    need(path, "a saved state of toliman period", {Content::sums});
    return toliman::make<toliman::periodogram>(toliman_period_load_file, path.c_str(), nullptr);
}

std::vector<unsigned char> state_bytes(const toliman::periodogram &periodogram) {
    return bytes_of([&](unsigned char *data, size_t capacity, size_t *size) {
        return toliman_period_save(periodogram.get(), data, capacity, size);
    });
}

void save_state(const toliman::periodogram &periodogram, const std::string &path) {
    const std::vector<unsigned char> bytes = state_bytes(periodogram);
    OutputFile out(path);
    out.write(bytes.data(), bytes.size());
    out.commit();
}

toliman_period_info info_of(const toliman::periodogram &periodogram) {
    return info_from<toliman_period_info>(toliman_period_get_info, periodogram.get());
}

std::vector<double> power_of(const toliman_period *periodogram, int64_t nf, int32_t normalisation) {
    std::vector<double> power(static_cast<size_t>(nf));
    toliman::check(toliman_period_query_power(periodogram, normalisation, 0, power.size(), power.data()));
    return power;
}

namespace {

toliman_period_sampling sampling_of(const toliman::periodogram &periodogram, const Series *series) {
    auto sampling = toliman::sized<toliman_period_sampling>();
    toliman::check(toliman_period_query_sampling(periodogram.get(), series != nullptr ? series->t.data() : nullptr,
                                                 series != nullptr ? series->t.size() : 0, &sampling));
    return sampling;
}

void warn_coarse(const toliman::periodogram &periodogram, const toliman_period_sampling &sampling, Progress &progress) {
    progress.warn(formatted("--df %g is above 1/(5 T) = %g, so peaks between two frequencies may be missed",
                            info_of(periodogram).df, sampling.coarsest_df));
}

void warn_inaccurate(const toliman::periodogram &periodogram, Progress &progress) {
    const bool wide = (info_of(periodogram).flags & TOLIMAN_PERIOD_DOUBLE_LIMB) != 0;
    progress.warn(
        std::string("the power may be wrong by more than 0.001 at some frequencies, where the samples cover "
                    "too small a part of a cycle: ") +
        (wide ? "give another first frequency (--f0)" : "the sums of the state lack TOLIMAN_PERIOD_DOUBLE_LIMB"));
}

} // namespace

void warn_while_following(const toliman::periodogram &periodogram, uint32_t &warned, Progress &progress) {
    constexpr uint32_t all = TOLIMAN_PERIOD_COARSE | TOLIMAN_PERIOD_INACCURATE;
    if ((warned & all) == all)
        return;
    const toliman_period_sampling sampling = sampling_of(periodogram, nullptr);
    const uint32_t fresh = sampling.flags & all & ~warned;
    if ((fresh & TOLIMAN_PERIOD_COARSE) != 0)
        warn_coarse(periodogram, sampling, progress);
    if ((fresh & TOLIMAN_PERIOD_INACCURATE) != 0)
        warn_inaccurate(periodogram, progress);
    warned |= fresh;
}

void warn_of_grid(const Periodogram &periodogram, const Series *series, Progress &progress) {
    if (periodogram.at_edge())
        progress.warn(
            "the peak is at the edge of the frequency grid; the period may lie beyond: give another grid (--f0, --df, "
            "--nf)");
    const toliman_period_sampling sampling = sampling_of(periodogram.handle, series);
    if ((sampling.flags & TOLIMAN_PERIOD_COARSE) != 0)
        warn_coarse(periodogram.handle, sampling, progress);
    if (((sampling.flags | periodogram.peak.flags) & TOLIMAN_PERIOD_INACCURATE) != 0)
        warn_inaccurate(periodogram.handle, progress);
    if (series != nullptr && (sampling.flags & TOLIMAN_PERIOD_ABOVE_NYQUIST) != 0)
        progress.warn(
            formatted("the grid exceeds 1/(2 median dt) = %g: evenly spaced samples repeat lower frequencies there",
                      sampling.nyquist));
}

} // namespace cli
