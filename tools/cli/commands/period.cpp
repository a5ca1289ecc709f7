// toliman period: the period of a series.
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "common/failure.hpp"
#include "common/npy.hpp"
#include "common/output.hpp"
#include "options/command.hpp"
#include "series/columns.hpp"
#include "series/fap.hpp"
#include "series/grid_remarks.hpp"
#include "series/period_report.hpp"
#include "series/period_stream.hpp"

namespace cli {

namespace {

struct Options {
    std::string file, power_file, columns, from_state, save_state;
    std::optional<double> f0, df;
    std::optional<int64_t> nf;
    SumOptions sums;
    size_t peaks = 1;
    FapOptions fap;
    std::string normalisation = "standard";
    bool as_json = false, follow = false, strict = false;
};

constexpr char kDescription[] = R"(Period of a series: text with columns t,y or t,y,sigma, JSON Lines, or a .npy table.

Examples:
  toliman period velocities.csv
  toliman period rv.csv --f0 1e-4 --df 2e-5 --nf 2500 --peaks 5 --json --power power.npy
  toliman period rv.csv --fap bootstrap --resamplings 10000
  toliman period chapter.run/series.csv --columns t,template
  receiver | toliman period - --follow --f0 1e-3 --df 1e-4 --nf 5000 --save-state now.tlmp
  toliman period tonight.csv --from-state now.tlmp

Columns of text are separated by semicolons if the first line has one, else by commas if it has one, else by white space.
Numbers have a decimal point. Empty lines and lines that begin with # are passed over. A first line of names tells which
columns are t, y and sigma; others are passed over. Without one they stand in this order. --columns takes columns of other
names.

Frequencies are f0 + k df, k = 0 ... nf - 1, in cycles per unit of t. By default f0 = 1.5/T, df = 1/(10 T), up to
1/(2 median dt), with T the time span plus one median step; where these are more than 2e6 they must be given. The FAP
depends on the grid, so it stands in the result. Remarks tell of a peak at the edge of the grid, beyond which the period
may lie, of a grid coarser than 1/(5 T), of one that goes beyond 1/(2 median dt), and of powers that may be wrong by more than
0.001, at frequencies of which the samples cover too small a part of a cycle.

--fap: baluev, the chance that noise peaks so high somewhere on the grid (an upper bound, nearly reached); naive, the same
were there f T independent frequencies, too small by some 3 at 0.01; single, at a frequency known beforehand; bootstrap,
counted among resamplings of the samples, whatever the noise is like; sequential, somewhere on the grid at any number of
samples, for those who look again and again and stop when they like.

--peaks lists more peaks, highest first; those that the sampling could make of a higher one are marked as aliases.

--follow prints a line of JSON after every sample from the fifth on, once values differ, and needs a grid or a state. Act
on its log10_fap_sequential: of streams of noise one in three has a log10_fap (baluev) of -2 at some time, one in a
hundred a log10_fap_sequential. Lines that are no samples or beyond the bounds, and a last one without newline, which may
be cut, are told with their number, passed over and counted; with --strict the exit code is then 4 in the end.

--save-state keeps the exact sums; with --follow every minute and whatever ends it, an error or a signal as well.
--from-state goes on from them, with or without more samples, to the same bits as all samples at once (`toliman merge`
adds up such files). The first samples set limits for all later ones. Sigmas: from 1/8 of the least to 4 times the
largest. Values with --follow: within 2^20 of the first. Otherwise: from the median by up to 2^20 times their spread.
--sigma-floor, --sigma-ceiling and --value-bound set other limits. Samples with and without sigma do not mix. From sums
alone the peak is refined by a parabola, without an error of its own; amplitude, phase and offset are those of the
grid's frequency nearest to it.

The fit is y = offset + amplitude sin(2 pi frequency (t - time_offset) + phase); time_offset is the first time. A
signal that is no sinusoid, as of an eccentric orbit, may have its peak some standard errors from its period.
An error that the samples cannot tell, as of a frequency at which cosine and sine coincide, is inf, in JSON null.)";

const std::map<std::string, int32_t> kNormalisations = {{"standard", TOLIMAN_PERIOD_POWER_STANDARD},
                                                        {"model", TOLIMAN_PERIOD_POWER_MODEL},
                                                        {"log", TOLIMAN_PERIOD_POWER_LOG},
                                                        {"psd", TOLIMAN_PERIOD_POWER_PSD}};

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

Periodogram search(const Series &series, const FrequencyGrid &grid, const SumOptions &sums, Progress &progress) {
    try {
        return find_period(series, grid, sums, progress);
    } catch (const toliman::error &error) {
        if (error.status() == TOLIMAN_E_STATE || error.status() == TOLIMAN_E_RANGE)
            malformed(series.name, error.what());
        throw;
    }
}

// What the sums tell: no samples to refine the peak against. The model is that of the grid's nearest frequency.
Periodogram from_sums(toliman::periodogram &&handle) {
    const toliman_period_info info = info_of(handle);
    Periodogram result = {std::move(handle), info.time_offset, {}};
    toliman_period_peak &peak = result.peak;
    peak.struct_size = sizeof peak;
    toliman::check(toliman_period_query_peak(result.handle.get(), &peak));
    toliman_period_model model = {};
    model.struct_size = sizeof model;
    const auto nearest = static_cast<int64_t>(std::lround((peak.frequency - info.f0) / info.df));
    toliman::check(toliman_period_query_model(result.handle.get(), nearest, &model));
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

// series: NULL where the sums are all there is.
void deliver(const Options &options, const Series *series, const Periodogram &periodogram, Progress &progress) {
    const Fap fap(options.fap, periodogram.handle, series, progress);
    progress.clear();
    remark(periodogram, series, progress);
    const toliman_period_info info = info_of(periodogram.handle);
    if (!options.power_file.empty())
        write_power(options.power_file,
                    power_of(periodogram.handle, info.nf, kNormalisations.at(options.normalisation)));
    const PeriodReport report = {
        periodogram, {info.f0, info.df, info.nf}, info.count, peaks_of(periodogram, options.peaks), fap};
    if (options.as_json)
        print_stdout(report.json());
    else
        report.print();
}

void stream(const Options &options, Progress &progress) {
    if (options.follow && options.save_state == "-")
        throw Failure(kExitUsage, "--save-state -: standard output has the stream's lines, the state needs a file");
    StreamOptions how = {options.file, columns_of(options), options.from_state, options.save_state,
                         {},           options.sums,        options.follow,     options.strict};
    if (options.from_state.empty()) {
        if (!options.f0 || !options.df || !options.nf)
            throw Failure(kExitUsage, "--follow needs --f0, --df and --nf, or --from-state");
        how.grid = {*options.f0, *options.df, *options.nf};
        how.sums.margins = true;
    }
    toliman::periodogram handle = stream_samples(how, progress);
    if (!options.follow)
        deliver(options, nullptr, from_sums(std::move(handle)), progress);
}

void period(const Options &options, Progress &progress) {
    for (const std::string &output : {options.save_state, options.power_file})
        if (!output.empty())
            check_output(output);
    if (options.follow || !options.from_state.empty())
        return stream(options, progress);
    const Series series = read_series(options.file, columns_of(options));
    if (!series.remark.empty())
        progress.warn(series.remark);
    SumOptions sums = options.sums;
    sums.margins = !options.save_state.empty();
    const Periodogram periodogram = search(series, grid_of(options, series), sums, progress);
    if (!options.save_state.empty())
        save_state(periodogram.handle, options.save_state);
    deliver(options, &series, periodogram, progress);
}

} // namespace

void add_period(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("period", kDescription);
    auto options = std::make_shared<Options>();
    CLI::Option *file =
        command->add_option("FILE", options->file, "text, JSON Lines or .npy: t, y[, sigma]; - reads standard input");
    command->add_option("--columns", options->columns, "names of the columns: T,Y or T,Y,SIGMA, default t,y,sigma");
    command->add_option("--f0", options->f0, "first frequency, cycles per unit of t, default 1.5/T");
    command->add_option("--df", options->df, "frequency step, likewise, default 1/(10 T)");
    command->add_option("--nf", options->nf, "number of frequencies, default up to 1/(2 median dt)");
    command->add_flag("--fixed-mean", options->sums.fixed_mean,
                      "subtract the weighted mean once instead of fitting it at each frequency");
    command->add_option("--value-bound", options->sums.value_bound,
                        "largest distance from the first or median value, default by the samples");
    command->add_option("--sigma-floor", options->sums.sigma_floor,
                        "smallest sigma to come, that of samples without; default by the samples");
    command->add_option("--sigma-ceiling", options->sums.sigma_ceiling,
                        "largest sigma to come, default by the samples");
    command->add_option("--peaks", options->peaks, "list so many peaks, default 1")->check(CLI::Range(1u, 64u));
    command->add_option("--save-state", options->save_state,
                        "keep the sums in this file (.tlmp), for --from-state and merge");
    CLI::Option *state = command->add_option("--from-state", options->from_state, "go on from the sums in this file");
    for (const char *name :
         {"--f0", "--df", "--nf", "--fixed-mean", "--value-bound", "--sigma-floor", "--sigma-ceiling"})
        state->excludes(command->get_option(name)); // the state has them
    command->add_flag("--json", options->as_json, "result as JSON on stdout");
    command->add_option("--power", options->power_file, "write the power of every frequency to this file, as .npy");
    command->add_option("--normalisation", options->normalisation, "of --power: standard (default), model, log or psd")
        ->check(CLI::IsMember(kNormalisations));
    add_fap(*command, options->fap);
    CLI::Option *follow = command->add_flag("--follow", options->follow, "a line of JSON after every sample");
    for (const char *name : {"--power", "--normalisation", "--peaks", "--fap", "--resamplings", "--seed"})
        follow->excludes(command->get_option(name)); // of a result at the end
    command->add_flag("--strict", options->strict, "with --follow: exit code 4 if lines were skipped")->needs(follow);
    command->callback([&context, options, file] {
        if (file->count() == 0 && (options->from_state.empty() || options->follow))
            throw CLI::RequiredError("FILE");
        context.action = [&context, options] {
            Progress progress(context.style());
            period(*options, progress);
        };
    });
}

} // namespace cli
