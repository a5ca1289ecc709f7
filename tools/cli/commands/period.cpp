// toliman period: the period of a time series.
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "common/failure.hpp"
#include "common/json.hpp"
#include "common/npy.hpp"
#include "common/output.hpp"
#include "common/text.hpp"
#include "options/command.hpp"
#include "series/fap.hpp"
#include "series/noise.hpp"
#include "series/period_stream.hpp"
#include "series/reduction.hpp"

namespace cli {

namespace {

struct Options {
    std::string file, power_file, from_state, save_state;
    std::optional<std::string> system; // of measured separations
    ReductionOptions reduction;        // with system
    std::optional<double> f0, df;
    std::optional<int64_t> nf;
    SumOptions sums;
    SampleOptions samples;
    size_t peaks = 1;
    FapOptions fap;
    NoiseOptions noise;
    std::string normalisation = "standard";
    bool as_json = false, follow = false, strict = false;
};

const std::map<std::string, int32_t> kNormalisations = {{"standard", TOLIMAN_PERIOD_POWER_STANDARD},
                                                        {"model", TOLIMAN_PERIOD_POWER_MODEL},
                                                        {"log", TOLIMAN_PERIOD_POWER_LOG},
                                                        {"psd", TOLIMAN_PERIOD_POWER_PSD}};

FrequencyGrid grid_of(const Options &options, const Series &series) {
    if (!options.f0 && !options.df && !options.nf)
        return default_grid(series);
    if (!options.f0 || !options.df || !options.nf)
        throw Failure(kExitUsage, "--f0, --df and --nf: give all three or none");
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

// The peak from the sums alone, without samples to refine it. The model is that of the nearest frequency of the grid.
Periodogram from_sums(toliman::periodogram &&handle) {
    const toliman_period_info info = info_of(handle);
    Periodogram result = {std::move(handle), info.time_offset, {}};
    toliman_period_peak &peak = result.peak;
    peak.struct_size = sizeof peak;
    toliman::check(toliman_period_query_peak(result.handle.get(), &peak));
    auto model = toliman::sized<toliman_period_model>();
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

// A series reduced to the orbit.
struct Reduced {
    Series series;
    Json json; // how
    std::string text;
};

Reduced reduced_of(const Series &series, const Options &options, Progress &progress) {
    const auto sky = options.reduction.observer.predictor(*options.system, 0, progress);
    const Measurements measured =
        reduce(measured_of(series, options.reduction), options.reduction, sky.get(), progress);
    Json json("system", *options.system);
    options.reduction.set(json);
    json.set("unreduced", measured.unreduced);
    return {measured.reduced, json,
            *options.system + " seen from: " + options.reduction.observer.text() +
                formatted("; %zu samples left out", measured.unreduced)};
}

struct Report {
    const Periodogram &periodogram;
    FrequencyGrid grid;
    int64_t samples;
    std::vector<toliman_period_peak> peaks; // the highest first
    const Fap &fap;
    std::string time_scale; // of Modified Julian Days; empty for plain numbers
    const Reduced *reduced; // NULL if the samples are not reduced
    const Noise *noise;     // NULL from sums alone

    double shortest() const { return 1 / (grid.f0 + grid.df * static_cast<double>(grid.nf - 1)); }
    double longest() const { return 1 / grid.f0; } // infinite if the grid begins at 0
};

void print_text(const Report &report) {
    const toliman_period_peak &peak = report.periodogram.peak;
    const bool fitted = !std::isnan(peak.frequency_error); // otherwise from the sums alone
    std::printf("period      %s%s, half width %.3g, FWHM %.3g\n",
                text_with_error(peak.period, peak.period_error).c_str(), fitted ? " (least squares)" : "",
                peak.half_width_period, peak.fwhm_period);
    std::printf("amplitude   %s, offset %.6g\n", text_with_error(peak.amplitude, peak.amplitude_error).c_str(),
                peak.offset);
    std::printf("phase       %.4g rad at t = %.15g%s\n", peak.phase, report.periodogram.time_offset,
                report.time_scale.empty() ? "" : (", Modified Julian Day in " + report.time_scale).c_str());
    std::printf("power       %.6f at frequency %.8g\n", peak.power, peak.frequency);
    const double residual = report.fap.residual_of(peak);
    std::printf("log10 FAP   %s (%s)\n", report.fap.text(residual).c_str(), report.fap.how(residual).c_str());
    if (report.noise != nullptr)
        report.noise->print();
    for (size_t i = 1; i < report.peaks.size(); i++)
        std::printf("peak %-6zu period %.6g, power %.6f, log10 FAP %s%s%s\n", i + 1, report.peaks[i].period,
                    report.peaks[i].power, report.fap.text(report.peaks[i].log10_residual).c_str(),
                    (report.peaks[i].flags & TOLIMAN_PERIOD_ALIAS) != 0 ? ", alias" : "",
                    (report.peaks[i].flags & TOLIMAN_PERIOD_AT_EDGE) != 0 ? ", at the edge of the grid" : "");
    std::printf("samples     %lld, grid %.6g + k %.6g, %lld frequencies\n", static_cast<long long>(report.samples),
                report.grid.f0, report.grid.df, static_cast<long long>(report.grid.nf));
    std::printf("searched    periods from %.6g to %.6g\n", report.shortest(), report.longest());
    if (report.reduced != nullptr)
        std::printf("reduced     %s\n", report.reduced->text.c_str());
    print_stdout("");
}

Json peak_json(const Report &report) {
    const toliman_period_peak &peak = report.periodogram.peak;
    return Json("frequency", peak.frequency, "period", peak.period, "power", peak.power, "log10_residual",
                peak.log10_residual, "fwhm_period", peak.fwhm_period, "half_width_period", peak.half_width_period,
                "frequency_error", peak.frequency_error, "period_error", peak.period_error, "amplitude", peak.amplitude,
                "amplitude_error", peak.amplitude_error, "phase", peak.phase, "time_offset",
                report.periodogram.time_offset, "offset", peak.offset, "log10_fap",
                report.fap.log10(report.fap.residual_of(peak)), "at_edge", report.periodogram.at_edge());
}

std::string json_text(const Report &report) {
    Json json("schema", "toliman-period/2", "n", report.samples, "time_scale", text_or_null(report.time_scale), "peak",
              peak_json(report), "fap_method", report.fap.method(), "grid",
              Json("f0", report.grid.f0, "df", report.grid.df, "nf", report.grid.nf), "searched",
              Json("shortest", report.shortest(), "longest", report.longest()));
    if (report.peaks.size() > 1)
        json.set("peaks", array_of(report.peaks, [&](const toliman_period_peak &peak) {
                     return Json("frequency", peak.frequency, "period", peak.period, "power", peak.power, "log10_fap",
                                 report.fap.log10(peak.log10_residual), "fwhm_period", peak.fwhm_period, "alias",
                                 (peak.flags & TOLIMAN_PERIOD_ALIAS) != 0, "at_edge",
                                 (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
                 }));
    if (report.reduced != nullptr)
        json.set("reduction", report.reduced->json);
    if (report.noise != nullptr && report.noise->known())
        json.set("noise", report.noise->json());
    return json.text();
}

// Writes and prints the results. series: NULL if only the sums are known. reduced: NULL if the series is as given.
void write_results(const Options &options, const Series *series, const Reduced *reduced, const Periodogram &periodogram,
                   Progress &progress) {
    const std::string given = options.samples.time_scale.empty() ? "" : result_scale(options.samples.time_scale);
    const Fap fap(options.fap, periodogram.handle, series, progress);
    const toliman_period_info info = info_of(periodogram.handle);
    std::optional<Noise> noise;
    if (series != nullptr)
        noise.emplace(options.noise, *series, FrequencyGrid{info.f0, info.df, info.nf}, progress);
    progress.clear();
    uint32_t warned = 0;
    warn_of_grid(periodogram.handle, series, periodogram.peak.flags, warned, progress);
    if (noise)
        noise->warn(progress);
    if (!options.power_file.empty()) {
        OutputFile out(options.power_file);
        write_npy(out, power_of(periodogram.handle.get(), info.nf, kNormalisations.at(options.normalisation)));
        out.commit();
    }
    const Report report = {periodogram, {info.f0, info.df, info.nf},
                           info.count,  peaks_of(periodogram, options.peaks),
                           fap,         series != nullptr ? series->time_scale : given,
                           reduced,     noise ? &*noise : nullptr};
    if (options.as_json)
        print_stdout(json_text(report));
    else
        print_text(report);
}

void stream(const Options &options, Progress &progress) {
    if (options.follow && options.save_state == "-")
        throw Failure(kExitUsage, "--save-state -: must be a file with --follow, which prints to standard output");
    StreamOptions how = {options.file, options.samples, options.from_state, options.save_state,
                         {},           options.sums,    options.follow,     options.strict};
    how.samples.of_state = !options.from_state.empty();
    if (options.from_state.empty()) {
        if (!options.f0 || !options.df || !options.nf)
            throw Failure(kExitUsage, "--follow needs --f0, --df and --nf, or --from-state");
        how.grid = {*options.f0, *options.df, *options.nf};
        how.sums.margins = true;
    }
    toliman::periodogram handle = stream_samples(how, progress);
    if (!options.follow)
        write_results(options, nullptr, nullptr, from_sums(std::move(handle)), progress);
}

void period(Options &options, Progress &progress) {
    options.samples.leap_seconds = options.reduction.observer.leap_seconds();
    for (const std::string &output : {options.save_state, options.power_file})
        if (!output.empty())
            check_output(output);
    if (options.follow || !options.from_state.empty())
        return stream(options, progress);
    Series series = read_series(options.file, options.samples);
    if (!series.warning.empty())
        progress.warn(series.warning);
    std::optional<Reduced> reduced;
    if (options.system) {
        reduced = reduced_of(series, options, progress);
        series = reduced->series;
    }
    SumOptions sums = options.sums;
    sums.margins = !options.save_state.empty();
    const Periodogram periodogram = search(series, grid_of(options, series), sums, progress);
    if (!options.save_state.empty())
        save_state(periodogram.handle, options.save_state);
    write_results(options, &series, reduced ? &*reduced : nullptr, periodogram, progress);
}

} // namespace

void add_period(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "period");
    auto options = std::make_shared<Options>();
    CLI::Option *file =
        add_option(command, "FILE", options->file, "",
                   "series t,y or t,y,sigma: text, JSON Lines or .npy; - reads text or JSON Lines from standard input");
    add_option(command, "--columns", options->samples.columns, "NAMES",
               "names of the columns to use: T,Y or T,Y,SIGMA; default t,y and, if present, sigma");
    add_times(*command, options->samples);
    command->add_option("--f0", options->f0, "first frequency in cycles per unit of t, default 1.5/T");
    command->add_option("--df", options->df, "frequency step in cycles per unit of t, default 1/(10 T)");
    command->add_option("--nf", options->nf, "number of frequencies, default up to the frequency 1/(2 median dt)");
    command->add_flag("--fixed-mean", options->sums.fixed_mean,
                      "subtract the weighted mean once instead of fitting an offset at each frequency");
    command->add_option("--value-bound", options->sums.value_bound,
                        "largest distance of a value from the median (with --follow: from the first value); default "
                        "from the samples (with --follow: 2^20)");
    command->add_option("--sigma-floor", options->sums.sigma_floor,
                        "smallest sigma allowed, and the sigma of samples without one; default from the samples");
    command->add_option("--sigma-ceiling", options->sums.sigma_ceiling,
                        "largest sigma allowed; default from the samples");
    command->add_option("--peaks", options->peaks, "number of peaks to list, default 1")->check(CLI::Range(1u, 64u));
    add_option(command, "--save-state", options->save_state, "FILE",
               "write the sums to this file (.tlmp), for --from-state and merge");
    CLI::Option *state =
        add_option(command, "--from-state", options->from_state, "FILE", "continue from the sums in this file");
    for (const char *name :
         {"--f0", "--df", "--nf", "--fixed-mean", "--value-bound", "--sigma-floor", "--sigma-ceiling"})
        state->excludes(command->get_option(name)); // contained in the state
    command->add_flag("--json", options->as_json, "print JSON, schema toliman-period/2");
    add_option(command, "--power", options->power_file, "FILE", "write the power at every frequency to this .npy file");
    add_choice(command, "--normalisation", options->normalisation, kNormalisations,
               "normalisation of --power: standard (default), model, log or psd, as in astropy");
    add_fap(*command, options->fap);
    add_noise(*command, options->noise);
    CLI::Option *noise = command->get_option("--noise")->excludes(state)->excludes(command->get_option("--fixed-mean"));
    CLI::Option *follow = command->add_flag("--follow", options->follow, "print a JSON line after every sample");
    for (const char *name : {"--power", "--normalisation", "--peaks", "--fap", "--resamplings", "--seed"})
        follow->excludes(command->get_option(name)); // of a result at the end
    follow->excludes(noise);
    CLI::Option *system = add_option(command, "--system", options->system, "SYSTEM",
                                     "reduce measured separations to the orbit of this binary: alpha-cen, or a system "
                                     "file");
    system->excludes(follow)->excludes(state); // which have the sums, but not the samples
    options->reduction.add_to(*command, system);
    command->add_flag("--strict", options->strict, "with --follow: exit with code 4 if lines were skipped")
        ->needs(follow);
    set_action(*command, context, options, period, [options, file] {
        if (file->count() == 0 && (options->from_state.empty() || options->follow))
            throw CLI::RequiredError("FILE");
    });
}

} // namespace cli
