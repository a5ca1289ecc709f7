#include "period_stream.hpp"

#include <cstdio>

#include "failure.hpp"
#include "output.hpp"

namespace cli {

namespace {

using toliman::check;

constexpr int64_t kFewest = 5;             // samples of a peak
constexpr double kFiner = 8, kCoarser = 4; // than the first sigma others may be

// References from the first sample, bounds from the options.
toliman::periodogram begin(const StreamOptions &options, const Sample &first) {
    toliman_period_options how;
    toliman_period_options_init(&how);
    how.flags = options.fixed_mean ? TOLIMAN_PERIOD_FIXED_MEAN : 0;
    how.time_offset = first.t;
    how.value_offset = first.y;
    how.value_bound = options.value_bound.value_or(how.value_bound);
    how.sigma_floor = options.sigma_floor.value_or(first.sigma / kFiner);
    how.sigma_ceiling = options.sigma_ceiling.value_or(first.sigma * kCoarser);
    return toliman::make<toliman::periodogram>(toliman_period_create, options.grid->f0, options.grid->df,
                                               options.grid->nf, &how);
}

void print_update(const toliman::periodogram &periodogram, const Sample &sample) {
    toliman_period_peak peak = {};
    peak.struct_size = sizeof peak;
    const toliman_status status = toliman_period_query_peak(periodogram.get(), &peak);
    if (status == TOLIMAN_E_STATE) // constant values so far
        return;
    check(status);
    double sequential = 0;
    check(toliman_period_query_fap(periodogram.get(), TOLIMAN_FAP_SEQUENTIAL, peak.log10_residual, &sequential));
    char line[400];
    std::snprintf(line, sizeof line,
                  "{\"schema\":\"toliman-period-update/1\",\"n\":%lld,\"t\":%.17g,\"period\":%.10g,"
                  "\"frequency\":%.10g,\"power\":%.10g,\"log10_fap\":%.6g,\"log10_fap_sequential\":%.6g,"
                  "\"at_edge\":%s}\n",
                  static_cast<long long>(toliman_period_count(periodogram.get())), sample.t, peak.period,
                  peak.frequency, peak.power, peak.log10_fap, sequential,
                  (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0 ? "true" : "false");
    print_stdout(line);
}

} // namespace

toliman::periodogram stream_samples(const StreamOptions &options, Progress &progress) {
    toliman::periodogram periodogram;
    if (!options.from_state.empty())
        periodogram = load_state(options.from_state);
    if (options.file.empty())
        return periodogram;
    SampleReader reader(options.file, options.columns);
    toliman_period_info info = {};
    info.struct_size = sizeof info;
    for (Sample sample = {}; reader.next(sample); stop_if_asked()) {
        if (!periodogram)
            periodogram = begin(options, sample);
        if (info.nf == 0)
            check(toliman_period_get_info(periodogram.get(), &info));
        const double sigma = reader.weighted() ? sample.sigma : info.sigma_floor;
        if (toliman_period_push(periodogram.get(), sample.t, sample.y, sigma) != TOLIMAN_OK)
            malformed(reader.name(), "sample " + std::to_string(toliman_period_count(periodogram.get()) + 1) + ": " +
                                         toliman_last_error());
        if (options.follow && toliman_period_count(periodogram.get()) >= kFewest)
            print_update(periodogram, sample);
    }
    progress.clear();
    if (!periodogram)
        malformed(reader.name(), reader.empty() ? "is empty" : "holds no samples");
    return periodogram;
}

} // namespace cli
