// toliman period: the period of a series.
#include <cmath>
#include <cstdio>
#include <optional>

#include "command.hpp"
#include "failure.hpp"
#include "json.hpp"
#include "npy.hpp"
#include "output.hpp"
#include "periodogram.hpp"

namespace cli {

namespace {

struct Options {
    std::string file, power_file, columns;
    std::optional<double> f0, df;
    std::optional<int64_t> nf;
    bool fixed_mean = false, as_json = false;
};

constexpr char kDescription[] = R"(Period of a series in CSV: columns t,y or t,y,sigma.

Examples:
  toliman period examples/data/nu_oph_rv.csv
  toliman period rv.csv --f0 1e-4 --df 2e-5 --nf 2500 --json --power power.npy
  toliman period chapter.run/series.csv --columns t,template

A first line of names tells which columns are t, y and sigma; others are passed over. Without one they stand in this
order. --columns takes columns of other names.

Frequencies are f0 + k df, k = 0 ... nf - 1, in cycles per unit of t. By default f0 = 1.5/T, df = 1/(10 T), up to
1/(2 median dt), with T the time span plus one median step; where these are more than 2e6 they must be given. The FAP
depends on the grid, so it stands in the result. A peak at the edge of the grid is remarked upon: the period may lie
beyond.

The fit is y = offset + amplitude sin(2 pi frequency (t - time_offset) + phase); time_offset is the first time.
An error that the samples cannot tell, as of a frequency at which cosine and sine coincide, is inf, in JSON null.)";

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

void print_summary(const Series &series, const FrequencyGrid &grid, const Periodogram &periodogram) {
    const toliman_period_peak &peak = periodogram.peak;
    std::printf("period      %.6g +- %.2g (least squares), half width %.3g, FWHM %.3g\n", peak.period,
                peak.frequency_error * peak.period * peak.period, peak.half_width_error, peak.fwhm_error);
    std::printf("amplitude   %.6g +- %.2g, offset %.6g\n", peak.amplitude, peak.amplitude_error, peak.offset);
    std::printf("phase       %.4g rad at t = %.15g\n", peak.phase, periodogram.time_offset);
    std::printf("power       %.6f at frequency %.8g\n", peak.power, peak.frequency);
    std::printf("log10 FAP   %.2f (Baluev)\n", peak.log10_fap);
    std::printf("samples     %zu, grid %.6g + k %.6g, %lld frequencies\n", series.t.size(), grid.f0, grid.df,
                static_cast<long long>(grid.nf));
    print_stdout("");
}

std::string as_json(const Series &series, const FrequencyGrid &grid, const Periodogram &periodogram) {
    const toliman_period_peak &peak = periodogram.peak;
    Json json, at, on;
    at.set("frequency", peak.frequency).set("period", peak.period).set("power", peak.power);
    at.set("log10_residual", peak.log10_residual).set("fwhm_error", peak.fwhm_error);
    at.set("half_width_error", peak.half_width_error).set("frequency_error", peak.frequency_error);
    at.set("amplitude", peak.amplitude).set("amplitude_error", peak.amplitude_error);
    at.set("phase", peak.phase).set("time_offset", periodogram.time_offset).set("offset", peak.offset);
    at.set_flag("at_edge", periodogram.at_edge());
    on.set("f0", grid.f0).set("df", grid.df).set("nf", static_cast<double>(grid.nf));
    json.set("schema", "toliman-period/1").set("n", static_cast<double>(series.t.size()));
    json.set("peak", std::move(at)).set("log10_fap", peak.log10_fap).set("grid", std::move(on));
    return json.text();
}

void write_power(const std::string &path, const std::vector<double> &power) {
    OutputFile out(path);
    write_npy_header(out, {power.size()});
    out.write(power.data(), power.size() * sizeof power[0]);
    out.commit();
}

void period(const Options &options, Progress &progress) {
    const Series series = read_series(options.file, columns_of(options));
    const FrequencyGrid grid = grid_of(options, series);
    const Periodogram periodogram = search(series, grid, options.fixed_mean, progress);
    progress.clear();
    if (periodogram.at_edge())
        progress.warn(kEdgeRemark);
    if (!options.power_file.empty())
        write_power(options.power_file, power_of(periodogram, grid.nf));
    if (options.as_json)
        print_stdout(as_json(series, grid, periodogram));
    else
        print_summary(series, grid, periodogram);
}

} // namespace

void add_period(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("period", kDescription);
    auto options = std::make_shared<Options>();
    command->add_option("FILE", options->file, "CSV with columns t,y[,sigma]; - reads standard input")->required();
    command->add_option("--columns", options->columns, "names of the columns: T,Y or T,Y,SIGMA, default t,y,sigma");
    command->add_option("--f0", options->f0, "first frequency");
    command->add_option("--df", options->df, "frequency step");
    command->add_option("--nf", options->nf, "number of frequencies");
    command->add_flag("--fixed-mean", options->fixed_mean, "subtract the weighted mean once instead of fitting it");
    command->add_flag("--json", options->as_json, "result as JSON on stdout");
    command->add_option("--power", options->power_file, "write the power of every frequency as .npy");
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            period(*options, progress);
        };
    });
}

} // namespace cli
