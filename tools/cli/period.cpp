// toliman period: the period of a series.
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "command.hpp"
#include "failure.hpp"
#include "fap.hpp"
#include "json.hpp"
#include "npy.hpp"
#include "output.hpp"
#include "period_stream.hpp"

namespace cli {

namespace {

struct Options {
    std::string file, power_file, columns, from_state, save_state;
    std::optional<double> f0, df, value_bound, sigma_floor, sigma_ceiling;
    std::optional<int64_t> nf;
    size_t peaks = 1;
    FapOptions fap;
    std::string normalisation = "standard";
    bool fixed_mean = false, as_json = false, follow = false;
};

constexpr char kDescription[] = R"(Period of a series: CSV with columns t,y or t,y,sigma, JSON Lines, or a .npy table.

Examples:
  toliman period examples/data/nu_oph_rv.csv
  toliman period rv.csv --f0 1e-4 --df 2e-5 --nf 2500 --peaks 5 --json --power power.npy
  toliman period rv.csv --fap bootstrap --resamplings 10000
  toliman period chapter.run/series.csv --columns t,template
  receiver | toliman period - --follow --f0 1e-3 --df 1e-4 --nf 5000 --save-state now.tlmp
  toliman period tonight.csv --from-state now.tlmp

A first line of names tells which columns are t, y and sigma; others are passed over. Without one they stand in this
order. --columns takes columns of other names.

Frequencies are f0 + k df, k = 0 ... nf - 1, in cycles per unit of t. By default f0 = 1.5/T, df = 1/(10 T), up to
1/(2 median dt), with T the time span plus one median step; where these are more than 2e6 they must be given. The FAP
depends on the grid, so it stands in the result. Remarks tell of a peak at the edge of the grid, beyond which the period
may lie, of a grid coarser than 1/(5 T), and of one that goes beyond 1/(2 median dt).

--fap: baluev, the chance that noise peaks so high somewhere on the grid (an upper bound, nearly reached); naive, the same
were there f T independent frequencies, too small by some 3 at 0.01; single, at a frequency known beforehand; bootstrap,
counted among resamplings of the samples, whatever the noise is like; sequential, somewhere on the grid at any number of
samples, for those who look again and again and stop when they like.

--peaks lists more peaks, highest first; those that the sampling could make of a higher one are marked as aliases.

--follow prints a line of JSON after every sample, and needs a grid or a state. Act on its log10_fap_sequential: of
streams of noise one in three has a log10_fap (baluev) of -2 at some time, one in a hundred a log10_fap_sequential. --save-state keeps the exact sums;
--from-state goes on from them, with or without more samples, to the same bits as all samples at once (`toliman merge`
adds up such files). The first sample then sets the offsets of time and value, and others may have sigmas from 1/8 to 4
times its own and values within 2^20 of it: --sigma-floor, --sigma-ceiling and --value-bound say otherwise. From sums
alone the peak is refined by a parabola, without standard errors.

The fit is y = offset + amplitude sin(2 pi frequency (t - time_offset) + phase); time_offset is the first time.
An error that the samples cannot tell, as of a frequency at which cosine and sine coincide, is inf, in JSON null.)";

const std::map<std::string, uint32_t> kNormalisations = {{"standard", TOLIMAN_POWER_STANDARD},
                                                         {"model", TOLIMAN_POWER_MODEL},
                                                         {"log", TOLIMAN_POWER_LOG},
                                                         {"psd", TOLIMAN_POWER_PSD}};

std::vector<std::string> columns_of(const Options &options) {
    std::vector<std::string> columns = options.columns.empty() ? std::vector<std::string>() : names_of(options.columns);
    if (columns.size() == 1 || columns.size() > 3)
        throw Failure(kExitUsage, "--columns " + options.columns + ": must be T,Y or T,Y,SIGMA");
    return columns;
}

FrequencyGrid grid_of(const Options &options, const Series &series) {
    if (!options.f0 && !options.df && !options.nf)
        return default_grid(series);
    if (!options.f0 || !options.df || !options.nf)
        throw Failure(kExitUsage, "--f0, --df and --nf go together: give all three or none");
    return {*options.f0, *options.df, *options.nf};
}

// What the library complains about is the grid, which the options give, or the series.
Periodogram search(const Series &series, const FrequencyGrid &grid, bool fixed_mean, Progress &progress) {
    try {
        return find_period(series, grid, fixed_mean, progress);
    } catch (const toliman::error &error) {
        if (error.status() == TOLIMAN_E_ARGUMENT)
            throw Failure(kExitUsage, std::string("--f0, --df, --nf: ") + error.what());
        if (error.status() == TOLIMAN_E_STATE || error.status() == TOLIMAN_E_RANGE)
            malformed(series.name, error.what());
        throw;
    }
}

void print_peaks(const std::vector<toliman_period_peak> &peaks, const Fap &fap) {
    for (size_t i = 1; i < peaks.size(); i++)
        std::printf("peak %-6zu period %.6g, power %.6f, log10 FAP %.2f%s%s\n", i + 1, peaks[i].period, peaks[i].power,
                    fap.log10(peaks[i].log10_residual), (peaks[i].flags & TOLIMAN_PERIOD_ALIAS) != 0 ? ", alias" : "",
                    (peaks[i].flags & TOLIMAN_PERIOD_AT_EDGE) != 0 ? ", at the grid's edge" : "");
}

void print_summary(int64_t samples, const FrequencyGrid &grid, const Periodogram &periodogram,
                   const std::vector<toliman_period_peak> &peaks, const Fap &fap) {
    const toliman_period_peak &peak = periodogram.peak;
    if (std::isnan(peak.amplitude)) { // from the sums alone
        std::printf("period      %.6g, half width %.3g, FWHM %.3g\n", peak.period, peak.half_width_error,
                    peak.fwhm_error);
    } else {
        std::printf("period      %.6g +- %.2g (least squares), half width %.3g, FWHM %.3g\n", peak.period,
                    peak.frequency_error * peak.period * peak.period, peak.half_width_error, peak.fwhm_error);
        std::printf("amplitude   %.6g +- %.2g, offset %.6g\n", peak.amplitude, peak.amplitude_error, peak.offset);
        std::printf("phase       %.4g rad at t = %.15g\n", peak.phase, periodogram.time_offset);
    }
    std::printf("power       %.6f at frequency %.8g\n", peak.power, peak.frequency);
    std::printf("log10 FAP   %.2f (%s)\n", fap.log10(peak.log10_residual), fap.method().c_str());
    print_peaks(peaks, fap);
    std::printf("samples     %lld, grid %.6g + k %.6g, %lld frequencies\n", static_cast<long long>(samples), grid.f0,
                grid.df, static_cast<long long>(grid.nf));
    print_stdout("");
}

JsonTree peaks_json(const std::vector<toliman_period_peak> &peaks, const Fap &fap) {
    JsonTree list(cJSON_CreateArray());
    for (const toliman_period_peak &peak : peaks) {
        Json one;
        one.set("frequency", peak.frequency).set("period", peak.period).set("power", peak.power);
        one.set("log10_fap", fap.log10(peak.log10_residual)).set("fwhm_error", peak.fwhm_error);
        one.set_flag("alias", (peak.flags & TOLIMAN_PERIOD_ALIAS) != 0);
        one.set_flag("at_edge", (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
        cJSON_AddItemToArray(list.get(), one.release().release());
    }
    return list;
}

std::string as_json(int64_t samples, const FrequencyGrid &grid, const Periodogram &periodogram,
                    const std::vector<toliman_period_peak> &peaks, const Fap &fap) {
    const toliman_period_peak &peak = periodogram.peak;
    Json json, at, on;
    at.set("frequency", peak.frequency).set("period", peak.period).set("power", peak.power);
    at.set("log10_residual", peak.log10_residual).set("fwhm_error", peak.fwhm_error);
    at.set("half_width_error", peak.half_width_error).set("frequency_error", peak.frequency_error);
    at.set("amplitude", peak.amplitude).set("amplitude_error", peak.amplitude_error);
    at.set("phase", peak.phase).set("time_offset", periodogram.time_offset).set("offset", peak.offset);
    at.set_flag("at_edge", periodogram.at_edge());
    on.set("f0", grid.f0).set("df", grid.df).set("nf", static_cast<double>(grid.nf));
    json.set("schema", "toliman-period/1").set("n", static_cast<double>(samples));
    json.set("peak", std::move(at)).set("log10_fap", fap.log10(peak.log10_residual)).set("fap_method", fap.method());
    json.set("grid", std::move(on));
    if (peaks.size() > 1)
        json.set("peaks", peaks_json(peaks, fap));
    return json.text();
}

// What the sums tell: no samples to refine the peak against.
Periodogram from_sums(toliman::periodogram &&handle, toliman_period_info &info) {
    info.struct_size = sizeof info;
    toliman::check(toliman_period_get_info(handle.get(), &info));
    Periodogram result = {std::move(handle), info.time_offset, {}};
    result.peak.struct_size = sizeof result.peak;
    toliman::check(toliman_period_query_peak(result.handle.get(), &result.peak));
    return result;
}

std::vector<toliman_period_peak> peaks_of(const Periodogram &periodogram, size_t most) {
    std::vector<toliman_period_peak> peaks(most);
    for (toliman_period_peak &peak : peaks)
        peak.struct_size = sizeof peak;
    size_t count = 0;
    toliman::check(toliman_period_query_peaks(periodogram.handle.get(), most, peaks.data(), &count));
    peaks.resize(count);
    return peaks;
}

void write_power(const std::string &path, const std::vector<double> &power) {
    OutputFile out(path);
    write_npy_header(out, {power.size()});
    out.write(power.data(), power.size() * sizeof power[0]);
    out.commit();
}

// series: NULL where the sums are all there is; then the median time step is not known.
void remark(const Periodogram &periodogram, const Series *series, const FrequencyGrid &grid, Progress &progress) {
    if (periodogram.at_edge())
        progress.warn(kEdgeRemark);
    toliman_period_sampling sampling = {};
    sampling.struct_size = sizeof sampling;
    toliman::check(toliman_period_query_sampling(periodogram.handle.get(),
                                                 series != nullptr ? series->t.data() : nullptr,
                                                 series != nullptr ? series->t.size() : 0, &sampling));
    char text[200];
    if ((sampling.flags & TOLIMAN_PERIOD_COARSE) != 0) {
        std::snprintf(text, sizeof text, "--df %g is above 1/(5 T) = %g: peaks may pass between two frequencies unseen",
                      grid.df, sampling.coarsest_df);
        progress.warn(text);
    }
    if (series != nullptr && (sampling.flags & TOLIMAN_PERIOD_PAST_CEILING) != 0) {
        std::snprintf(text, sizeof text,
                      "the grid goes beyond 1/(2 median dt) = %g, where even samples repeat what is below",
                      sampling.ceiling);
        progress.warn(text);
    }
}

// series: NULL where the sums are all there is.
void deliver(const Options &options, const Series *series, int64_t samples, const FrequencyGrid &grid,
             const Periodogram &periodogram, Progress &progress) {
    const Fap fap(options.fap, periodogram.handle, series, progress);
    progress.clear();
    remark(periodogram, series, grid, progress);
    if (!options.power_file.empty())
        write_power(options.power_file,
                    power_of(periodogram.handle, grid.nf, kNormalisations.at(options.normalisation)));
    const std::vector<toliman_period_peak> peaks = peaks_of(periodogram, options.peaks);
    if (options.as_json)
        print_stdout(as_json(samples, grid, periodogram, peaks, fap));
    else
        print_summary(samples, grid, periodogram, peaks, fap);
}

void stream(const Options &options, Progress &progress) {
    StreamOptions how = {options.file,        columns_of(options), options.from_state,    {},
                         options.value_bound, options.sigma_floor, options.sigma_ceiling, options.fixed_mean,
                         options.follow};
    if (options.from_state.empty()) {
        if (!options.f0 || !options.df || !options.nf)
            throw Failure(kExitUsage, "--follow needs --f0, --df and --nf, or --from-state");
        how.grid = {*options.f0, *options.df, *options.nf};
    }
    toliman::periodogram handle = stream_samples(how, progress);
    if (!options.save_state.empty())
        save_state(handle, options.save_state);
    if (options.follow)
        return;
    toliman_period_info info = {};
    const Periodogram periodogram = from_sums(std::move(handle), info);
    deliver(options, nullptr, info.count, {info.f0, info.df, info.nf}, periodogram, progress);
}

void period(const Options &options, Progress &progress) {
    if (options.follow || !options.from_state.empty())
        return stream(options, progress);
    const Series series = read_series(options.file, columns_of(options));
    const FrequencyGrid grid = grid_of(options, series);
    const Periodogram periodogram = search(series, grid, options.fixed_mean, progress);
    if (!options.save_state.empty())
        save_state(periodogram.handle, options.save_state);
    deliver(options, &series, static_cast<int64_t>(series.t.size()), grid, periodogram, progress);
}

} // namespace

void add_period(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("period", kDescription);
    auto options = std::make_shared<Options>();
    CLI::Option *file =
        command->add_option("FILE", options->file, "CSV, JSON Lines or .npy: t, y[, sigma]; - reads standard input");
    command->add_option("--columns", options->columns, "names of the columns: T,Y or T,Y,SIGMA, default t,y,sigma");
    command->add_option("--f0", options->f0, "first frequency");
    command->add_option("--df", options->df, "frequency step");
    command->add_option("--nf", options->nf, "number of frequencies");
    command->add_flag("--fixed-mean", options->fixed_mean, "subtract the weighted mean once instead of fitting it");
    command->add_option("--peaks", options->peaks, "list so many peaks, 1 to 64")->check(CLI::Range(1u, 64u));
    command->add_flag("--follow", options->follow, "a line of JSON after every sample");
    command->add_option("--save-state", options->save_state, "keep the sums in this file (.tlmp)");
    CLI::Option *state = command->add_option("--from-state", options->from_state, "go on from the sums in this file");
    for (const char *name : {"--f0", "--df", "--nf", "--fixed-mean"})
        state->excludes(command->get_option(name));
    command->add_option("--value-bound", options->value_bound, "largest distance from the first value, with --follow");
    command->add_option("--sigma-floor", options->sigma_floor, "smallest sigma to come, with --follow");
    command->add_option("--sigma-ceiling", options->sigma_ceiling, "largest sigma to come, with --follow");
    command->add_flag("--json", options->as_json, "result as JSON on stdout");
    command->add_option("--power", options->power_file, "write the power of every frequency as .npy");
    command->add_option("--normalisation", options->normalisation, "of --power: standard (default), model, log or psd")
        ->check(CLI::IsMember(kNormalisations));
    add_fap(*command, options->fap);
    command->callback([&context, options, file] {
        if (file->count() == 0 && options->from_state.empty())
            throw CLI::RequiredError("FILE");
        context.action = [&context, options] {
            Progress progress(context.style());
            period(*options, progress);
        };
    });
}

} // namespace cli
