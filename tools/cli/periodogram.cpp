#include "periodogram.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "failure.hpp"
#include "output.hpp"

namespace cli {

namespace {

constexpr double kMostFrequencies = 2e6; // 270 MB; a grid that is given may have more

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace

FrequencyGrid default_grid(const Series &series) {
    std::vector<double> sorted = series.t, steps;
    std::sort(sorted.begin(), sorted.end());
    for (size_t i = 1; i < sorted.size(); i++)
        if (sorted[i] > sorted[i - 1])
            steps.push_back(sorted[i] - sorted[i - 1]);
    if (steps.size() < 4)
        malformed(series.name, "a periodogram needs at least five different times, there are " +
                                   std::to_string(sorted.empty() ? 0 : steps.size() + 1));
    const double step = median(steps), span = sorted.back() - sorted.front() + step;
    const double f0 = 1.5 / span, df = 0.1 / span;
    const double count = std::fmax(1, std::floor((0.5 / step - f0) / df * (1 + 1e-12)) + 1);
    if (!(count <= kMostFrequencies) || !(df > 0)) {
        char text[256];
        std::snprintf(text, sizeof text,
                      "the default grid would have more than %.0f frequencies: the median time step is %g, the time "
                      "span %g; `toliman period` takes --f0, --df and --nf",
                      kMostFrequencies, step, span);
        throw Failure(kExitUsage, series.name + ": " + text);
    }
    return {f0, df, static_cast<int64_t>(count)};
}

Periodogram find_period(const Series &series, const FrequencyGrid &grid, bool fixed_mean, Progress &progress) {
    using namespace toliman;
    toliman_period_options options;
    toliman_period_options_init(&options);
    const auto [least, greatest] = std::minmax_element(series.y.begin(), series.y.end());
    const double spread = *greatest - *least;
    options.flags = TOLIMAN_PERIOD_WIDE | (fixed_mean ? TOLIMAN_PERIOD_FIXED_MEAN : 0); // no frequency loses digits
    options.time_offset = *std::min_element(series.t.begin(), series.t.end());
    options.value_offset = median(series.y);
    options.value_bound = std::clamp(std::exp2(std::ceil(std::log2(spread > 0 ? spread : 1.0))), 1e-99, 1e99);
    const double *sigma = nullptr;
    if (!series.sigma.empty()) {
        const auto [finest, coarsest] = std::minmax_element(series.sigma.begin(), series.sigma.end());
        options.sigma_floor = *finest;
        options.sigma_ceiling = *coarsest;
        sigma = series.sigma.data();
    }
    Periodogram result = {
        make<periodogram>(toliman_period_create, grid.f0, grid.df, grid.nf, &options), options.time_offset, {}};
    for (size_t i = 0; i < series.t.size(); i++) {
        check(toliman_period_push(result.handle.get(), series.t[i], series.y[i],
                                  sigma != nullptr ? sigma[i] : options.sigma_floor));
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
    return toliman::make<toliman::periodogram>(toliman_period_load_file, path.c_str());
}

void save_state(const toliman::periodogram &periodogram, const std::string &path) {
    size_t size = 0;
    toliman::check(toliman_period_save(periodogram.get(), nullptr, 0, &size));
    std::vector<unsigned char> bytes(size);
    toliman::check(toliman_period_save(periodogram.get(), bytes.data(), size, &size));
    OutputFile out(path);
    out.write(bytes.data(), size);
    out.commit();
}

std::vector<double> power_of(const toliman::periodogram &periodogram, int64_t nf, uint32_t normalisation) {
    std::vector<double> power(static_cast<size_t>(nf));
    toliman::check(toliman_period_query_power(periodogram.get(), normalisation, 0, power.size(), power.data()));
    return power;
}

} // namespace cli
