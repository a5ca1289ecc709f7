// toliman period: the period of a series.
#include <cmath>
#include <cstdio>

#include "command.hpp"
#include "failure.hpp"
#include "json.hpp"
#include "npy.hpp"
#include "output.hpp"
#include "periodogram.hpp"

namespace cli {

namespace {

struct Options {
    std::string file, power_file;
    double f0 = NAN, df = NAN;
    int64_t nf = 0;
    bool fixed_mean = false, as_json = false;
};

constexpr char kDescription[] = R"(Period of a series in CSV: t,y or t,y,sigma.

Examples:
  toliman period examples/data/nu_oph_rv.csv
  toliman period rv.csv --f0 1e-4 --df 2e-5 --nf 2500 --json --power power.npy
  cut -d, -f1,5 chapter.run/series.csv | toliman period -

Frequencies are f0 + k df, k = 0 ... nf - 1, in cycles per unit of t. By default f0 = 1.5/T, df = 1/(10 T), up to
1/(2 median dt), with T the time span plus one median step; the FAP depends on the grid, so it stands in the result.
An error that the samples cannot tell, as of a frequency at which cosine and sine coincide, is inf, in JSON null.)";

FrequencyGrid grid_of(const Options &options, const Series &series) {
    const bool any = std::isfinite(options.f0) || std::isfinite(options.df) || options.nf != 0;
    if (!any)
        return default_grid(series.t);
    if (!std::isfinite(options.f0) || !std::isfinite(options.df) || options.nf == 0)
        throw Failure(kExitUsage, "--f0, --df and --nf go together: give all three or none");
    return {options.f0, options.df, options.nf};
}

void print_summary(const Series &series, const FrequencyGrid &grid, const toliman_period_peak &peak) {
    std::printf("period      %.6g +- %.2g (least squares), half width %.3g, FWHM %.3g\n", peak.period,
                peak.frequency_error * peak.period * peak.period, peak.half_width_error, peak.fwhm_error);
    std::printf("amplitude   %.6g +- %.2g, offset %.6g\n", peak.amplitude, peak.amplitude_error, peak.offset);
    std::printf("power       %.6f at frequency %.8g\n", peak.power, peak.frequency);
    std::printf("log10 FAP   %.2f (Baluev)\n", peak.log10_fap);
    std::printf("samples     %zu, grid %.6g + k %.6g, %lld frequencies\n", series.t.size(), grid.f0, grid.df,
                static_cast<long long>(grid.nf));
    print_stdout("");
}

std::string as_json(const Series &series, const FrequencyGrid &grid, const toliman_period_peak &peak) {
    Json json, at, on;
    at.set("frequency", peak.frequency).set("period", peak.period).set("power", peak.power);
    at.set("log10_residual", peak.log10_residual).set("fwhm_error", peak.fwhm_error);
    at.set("half_width_error", peak.half_width_error).set("frequency_error", peak.frequency_error);
    at.set("amplitude", peak.amplitude).set("amplitude_error", peak.amplitude_error);
    at.set("phase", peak.phase).set("offset", peak.offset);
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
    const Series series = read_series(options.file);
    const FrequencyGrid grid = grid_of(options, series);
    const Periodogram periodogram = find_period(series, grid, options.fixed_mean, progress);
    progress.clear();
    if (!options.power_file.empty())
        write_power(options.power_file, power_of(periodogram, grid.nf));
    if (options.as_json)
        print_stdout(as_json(series, grid, periodogram.peak));
    else
        print_summary(series, grid, periodogram.peak);
}

} // namespace

void add_period(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("period", kDescription);
    auto options = std::make_shared<Options>();
    command->add_option("FILE", options->file, "CSV with columns t,y[,sigma]; - reads standard input")->required();
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
