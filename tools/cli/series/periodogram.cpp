// Method: samples are pushed one by one to exact double-limb sums; the highest peak is then refined by least squares on
// the samples. The exact sums have fixed-point units, so their bounds must be known before the first sample: the
// library suggests them from the samples at hand, with margins if the sums are saved, since later samples may exceed
// those.
#include "series/periodogram.hpp"

#include "common/content.hpp"

namespace cli {

namespace {

constexpr double kNsPerDay = 86400e9;
constexpr double kLeastBound = 1e-98; // of a column; 0 would be its default

FrequencyGrid suggested(const std::vector<double> &times, double mission_span) {
    FrequencyGrid grid = {};
    toliman::check(toliman_period_suggest(times.data(), nullptr, nullptr, times.size(), mission_span, &grid.f0,
                                          &grid.df, &grid.nf, nullptr));
    return grid;
}

} // namespace

std::vector<double> frequencies_of(const FrequencyGrid &grid) {
    std::vector<double> frequencies;
    for (int64_t k = 0; k < grid.nf; k++)
        frequencies.push_back(grid.f0 + grid.df * static_cast<double>(k));
    return frequencies;
}

FrequencyGrid grid_of_days(double days) {
    return suggested({}, days);
}

FrequencyGrid default_grid(const std::string &name, const std::vector<double> &times) {
    std::vector<double> different = times;
    std::sort(different.begin(), different.end());
    different.erase(std::unique(different.begin(), different.end()), different.end());
    if (different.size() < 5)
        malformed(name,
                  "has " + std::to_string(different.size()) + " different times: a periodogram needs at least five");
    return suggested(times, 0);
}

toliman_period_options options_for(const double *t, const double *y, const double *sigma, size_t n,
                                   const SumOptions &sums) {
    auto options = toliman::sized<toliman_period_options>();
    const double mission_span = sums.margins ? 1 : 0;
    toliman::check(toliman_period_suggest(t, y, sigma, n, mission_span, nullptr, nullptr, nullptr, &options));
    options.unit_ns = kNsPerDay; // plain numbers are taken as days where days and years are named
    options.flags |= sums.fixed_mean ? TOLIMAN_PERIOD_FIXED_MEAN : 0;
    options.value_bound = sums.value_bound.value_or(options.value_bound);
    options.sigma_floor = sums.sigma_floor.value_or(options.sigma_floor);
    options.sigma_ceiling = sums.sigma_ceiling.value_or(options.sigma_ceiling);
    return options;
}

toliman_period_options options_for(const toliman_measure *series, const SumOptions &sums) {
    const Samples samples(series);
    toliman_period_options options =
        options_for(samples.t.data(), samples.y.data(), samples.sigmas(), samples.count(), sums);
    set_functions(series, options);
    double *bound = options.column_bound;
    for (const Function &column : columns_of(series))
        *bound++ = std::max(column.bound, kLeastBound);
    return options;
}

toliman::periodogram make_periodogram(const FrequencyGrid &grid, const toliman_period_options &options) {
    try {
        return toliman::make<toliman::periodogram>(toliman_period_create, grid.f0, grid.df, grid.nf, &options);
    } catch (const toliman::error &error) {
        if (error.status() != TOLIMAN_E_ARGUMENT)
            throw;
        const std::string &field = error.field();
        const bool bounds =
            field == "options->value_bound" || field == "options->sigma_floor" || field == "options->sigma_ceiling";
        const std::string text = error.what();
        throw Failure(kExitUsage,
                      bounds ? "--value-bound, --sigma-floor, --sigma-ceiling: " + text.substr(text.find('>') + 1)
                             : "--f0, --df, --nf: " + text);
    }
}

std::string refusal(const toliman::periodogram &periodogram, double t, double y, double sigma, bool from_state) {
    std::string why = toliman_last_error();
    const toliman_period_info info = info_of(periodogram);
    const bool outside = info.trend > 0 && (t < info.trend_start || t > info.trend_end);
    const char *option = outside                                               ? "--span"
                         : std::fabs(y - info.value_offset) > info.value_bound ? "--value-bound"
                         : sigma < info.sigma_floor                            ? "--sigma-floor"
                         : sigma > info.sigma_ceiling                          ? "--sigma-ceiling"
                                                                               : nullptr;
    if (option == nullptr)
        return why;
    return why + " (" + option + (from_state ? " of the run that made the state)" : ")");
}

toliman::periodogram sums_of(const toliman_measure *series, const FrequencyGrid &grid,
                             const toliman_period_options &options, Progress &progress) {
    toliman::periodogram periodogram = make_periodogram(grid, options);
    const Samples samples(series);
    const std::vector<double> rows = column_rows(series);
    auto sample = toliman::sized<toliman_period_sample>();
    for (size_t i = 0; i < samples.count(); i++) {
        sample.t = samples.t[i];
        sample.y = samples.y[i];
        sample.sigma = samples.sigma.empty() ? options.sigma_floor : samples.sigma[i];
        // Those without columns are pushed as a stream is, whose messages are the same.
        const toliman_status status =
            rows.empty() ? toliman_period_push(periodogram.get(), sample.t, sample.y, sample.sigma)
                         : toliman_period_push_samples(periodogram.get(), &sample,
                                                       &rows[i * static_cast<size_t>(options.columns)], 1);
        if (status != TOLIMAN_OK)
            malformed(name_of(series), "sample " + std::to_string(i + 1) + ": " +
                                           refusal(periodogram, sample.t, sample.y, sample.sigma, false));
        progress.show("period", static_cast<double>(i + 1) / static_cast<double>(samples.count()));
        stop_if_asked();
    }
    return periodogram;
}

Periodogram find_period(const toliman_measure *series, const FrequencyGrid &grid, const SumOptions &sums,
                        Progress &progress) {
    const toliman_period_options options = options_for(series, sums);
    Periodogram result = {sums_of(series, grid, options, progress), options.time_offset, {}};
    result.peak.struct_size = sizeof result.peak;
    const Samples samples(series);
    toliman::check(toliman_period_query_fit(result.handle.get(), samples.t.data(), samples.y.data(), samples.sigmas(),
                                            column_rows(series).data(), samples.count(), &result.peak));
    stop_if_asked();
    return result;
}

int64_t nearest_index(const toliman_period_info &info, double frequency) {
    return static_cast<int64_t>(std::llround((frequency - info.f0) / info.df));
}

Periodogram from_sums(toliman::periodogram &&handle) {
    const toliman_period_info info = info_of(handle);
    Periodogram result = {std::move(handle), info.time_offset, {}};
    toliman_period_peak &peak = result.peak;
    peak.struct_size = sizeof peak;
    toliman::check(toliman_period_query_peak(result.handle.get(), &peak));
    auto model = toliman::sized<toliman_period_model>();
    toliman::check(toliman_period_query_model(result.handle.get(), nearest_index(info, peak.frequency), &model));
    peak.amplitude = model.amplitude;
    peak.amplitude_error = model.amplitude_error;
    peak.phase = model.phase;
    peak.offset = model.offset;
    return result;
}

std::vector<toliman_period_peak> peaks_of(const Periodogram &periodogram, size_t most) {
    std::vector<toliman_period_peak> peaks(most);
    for (toliman_period_peak &peak : peaks)
        peak.struct_size = sizeof peak;
    size_t count = 0;
    toliman::check(toliman_period_query_peaks(periodogram.handle.get(), peaks.data(), most, &count));
    peaks.resize(count);
    return peaks;
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
    OutputFile out(path);
    out.write(state_bytes(periodogram));
    out.commit();
}

toliman_period_info info_of(const toliman::periodogram &periodogram) {
    return toliman::result<toliman_period_info>(toliman_period_get_info, periodogram.get());
}

std::vector<double> power_of(const toliman_period *periodogram, int64_t nf, int32_t normalisation) {
    std::vector<double> power(static_cast<size_t>(nf));
    toliman::check(toliman_period_query_power(periodogram, normalisation, 0, power.size(), power.data()));
    return power;
}

void warn_of_grid(const toliman::periodogram &periodogram, const toliman_measure *series, bool is_default,
                  uint32_t peak_flags, uint32_t &warned, Progress &progress) {
    if ((~warned & (TOLIMAN_PERIOD_COARSE | TOLIMAN_PERIOD_INACCURATE)) == 0)
        return;
    auto sampling = toliman::sized<toliman_period_sampling>();
    const std::vector<double> times = series != nullptr ? values_of(series, "t") : std::vector<double>();
    toliman::check(toliman_period_query_sampling(periodogram.get(), series != nullptr ? times.data() : nullptr,
                                                 times.size(), &sampling));
    const toliman_period_info info = info_of(periodogram);
    const uint32_t fresh = (sampling.flags | peak_flags) & ~warned;
    if ((fresh & TOLIMAN_PERIOD_AT_EDGE) != 0)
        progress.warn("the peak is at the edge of the frequency grid; the period may lie beyond: give another grid "
                      "(--f0, --df, --nf)");
    if ((fresh & TOLIMAN_PERIOD_COARSE) != 0) {
        const Apart step = apart(info.df, sampling.coarsest_df, 6);
        progress.warn("--df " + step.value + " is above 1/(5 T) = " + step.limit +
                      ", so peaks between two frequencies may be missed");
    }
    if ((fresh & TOLIMAN_PERIOD_INACCURATE) != 0)
        progress.warn(std::string("the power may be wrong by more than 0.001 at some frequencies, where the samples "
                                  "cover too small a part of a cycle: ") +
                      ((info.flags & TOLIMAN_PERIOD_DOUBLE_LIMB) != 0
                           ? "give another first frequency (--f0)"
                           : "the sums of the state lack TOLIMAN_PERIOD_DOUBLE_LIMB"));
    if (series != nullptr && (fresh & TOLIMAN_PERIOD_ABOVE_NYQUIST) != 0)
        progress.warn(
            formatted("the grid exceeds %g, the last frequency that the times resolve: above, the samples repeat lower "
                      "frequencies",
                      sampling.nyquist));
    if (is_default && info.f0 + info.df * static_cast<double>(info.nf) < sampling.nyquist)
        progress.warn(formatted("periods below %.6g are not searched, to limit the time of the default grid; the times "
                                "resolve periods from %.6g on (--f0, --df, --nf)",
                                1 / (info.f0 + info.df * static_cast<double>(info.nf - 1)), 1 / sampling.nyquist));
    warned |= fresh;
}

} // namespace cli
