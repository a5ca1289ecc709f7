// toliman period: the period of a time series.
#include "common/npy.hpp"
#include "options/command.hpp"
#include "series/fap.hpp"
#include "series/goodness.hpp"
#include "series/period_report.hpp"
#include "series/period_stream.hpp"
#include "series/series_options.hpp"

namespace cli {

namespace {

struct PeriodOptions : SeriesOptions {
    std::string power_file, from_state, save_state, out;
    std::optional<double> f0, df;
    std::optional<int64_t> nf;
    SumOptions sums;
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

FrequencyGrid grid_of(const PeriodOptions &options, const toliman_measure *series) {
    if (!options.f0 && !options.df && !options.nf)
        return default_grid(name_of(series), values_of(series, "t"));
    if (!options.f0 || !options.df || !options.nf)
        throw Failure(kExitUsage, "--f0, --df and --nf: give all three or none");
    return {*options.f0, *options.df, *options.nf};
}

Periodogram search(const toliman_measure *series, const FrequencyGrid &grid, const SumOptions &sums,
                   Progress &progress) {
    try {
        return find_period(series, grid, sums, progress);
    } catch (const toliman::error &error) {
        if (error.status() == TOLIMAN_E_STATE || error.status() == TOLIMAN_E_RANGE)
            malformed(name_of(series), error.what());
        throw;
    }
}

// Coefficients at the peak, or at the nearest frequency of the grid if only the sums are known.
std::optional<Coefficients> fitted_of(const PeriodOptions &options, const toliman_measure *series,
                                      const Periodogram &periodogram, Progress &progress) {
    const toliman_period_info info = info_of(periodogram.handle);
    const double frequency = periodogram.peak.frequency;
    if (info.trend + info.columns == 0)
        return std::nullopt;
    const std::vector<Function> columns = series != nullptr ? columns_of(series) : std::vector<Function>();
    if (series == nullptr || !(frequency > 0))
        return coefficients_at(periodogram.handle.get(), nearest_index(info, frequency), columns);
    const toliman::periodogram at_peak =
        sums_of(series, {frequency, info.df, 1}, options_for(series, options.sums), progress);
    return coefficients_at(at_peak.get(), 0, columns);
}

// Sums of the series without the sinusoid that was found.
toliman::periodogram residual_of(const PeriodOptions &options, const toliman_measure *series,
                                 const PeriodReport &report, Progress &progress) {
    const toliman::measurements rest = without(report.sinusoid(), series);
    SumOptions sums = options.sums;
    sums.value_bound.reset(); // of the series; where the fit is poor, the rest may exceed it
    return sums_of(rest.get(), report.grid, options_for(rest.get(), sums), progress);
}

void write_power(const PeriodOptions &options, const Periodogram &periodogram) {
    if (options.power_file.empty())
        return;
    OutputFile out(options.power_file);
    write_npy(out, power_of(periodogram.handle.get(), info_of(periodogram.handle).nf,
                            kNormalisations.at(options.normalisation)));
    out.commit();
}

void warn_of_results(const Periodogram &periodogram, const toliman_measure *series, bool is_default,
                     const std::optional<Noise> &noise, Progress &progress) {
    uint32_t warned = 0;
    warn_of_grid(periodogram.handle, series, is_default, periodogram.peak.flags, warned, progress);
    const bool has_trend = info_of(periodogram.handle).functions > 1;
    warn_of_peak(periodogram.peak.flags, has_trend ? "" : ": --trend",
                 series == nullptr || info_of(series).time_scale != 0, progress);
    warn_of_fit(periodogram.peak, progress);
    warn_of_outliers(periodogram.peak.outliers, "", progress);
    if (noise)
        noise->warn(progress);
}

// Writes and prints the results. series: NULL if only the sums are known. reduced: NULL if the series is as given.
// folder: NULL without --out.
void write_results(const PeriodOptions &options, const toliman_measure *series, const ReductionNote *reduced,
                   const Instruments &instruments, const Periodogram &periodogram, OutputFolder *folder,
                   Progress &progress) {
    const std::string given = options.samples.time_scale.empty() ? "" : result_scale(options.samples.time_scale);
    const Fap fap(options.fap, periodogram.handle, series, progress);
    const toliman_period_info info = info_of(periodogram.handle);
    std::optional<Noise> noise;
    if (series != nullptr)
        noise.emplace(options.noise, options.fap, series, FrequencyGrid{info.f0, info.df, info.nf},
                      periodogram.peak.frequency, progress);
    std::optional<Coefficients> fitted = fitted_of(options, series, periodogram, progress);
    if (fitted && noise && noise->is_ar1())
        noise->set(fitted->all);
    const PeriodReport report = {periodogram, {info.f0, info.df, info.nf},
                                 info.count,  peaks_of(periodogram, options.peaks),
                                 fap,         series != nullptr ? name_of_scale(info_of(series).time_scale) : given,
                                 reduced,     noise ? &*noise : nullptr,
                                 fitted,      aliases_of(periodogram.handle.get(), periodogram.peak.frequency),
                                 instruments};
    progress.clear();
    warn_of_results(periodogram, series, !options.f0, noise, progress);
    warn_of_aliases(report.aliases, info.functions > 1 ? "" : ": --trend", progress);
    write_power(options, periodogram);
    if (folder != nullptr)
        write(*folder, report, series, residual_of(options, series, report, progress));
    if (options.as_json)
        print_stdout(report.json().text());
    else
        report.print();
}

void stream(const PeriodOptions &options, Progress &progress) {
    if (options.follow && options.save_state == "-")
        throw Failure(kExitUsage, "--save-state -: must be a file with --follow, which prints to standard output");
    PeriodStreamOptions how = {options.file, options.samples,  options.from_state, options.save_state, {},
                               options.sums, options.nuisance, options.follow,     options.strict};
    how.samples.of_state = !options.from_state.empty();
    if (options.from_state.empty()) {
        if (!options.f0 || !options.df || !options.nf)
            throw Failure(kExitUsage, "--follow needs --f0, --df and --nf, or --from-state");
        options.nuisance.need_span(options.nuisance.trend.value_or(0), "--follow");
        how.grid = {*options.f0, *options.df, *options.nf};
        how.sums.margins = true;
    }
    toliman::periodogram handle = stream_samples(how, progress);
    if (!options.follow)
        write_results(options, nullptr, nullptr, {}, from_sums(std::move(handle)), nullptr, progress);
}

void period(PeriodOptions &options, Progress &progress) {
    options.samples.leap_seconds = options.reduction.observer.leap_seconds();
    options.nuisance.check();
    for (const std::string &output : {options.save_state, options.power_file})
        if (!output.empty())
            check_output(output);
    if (options.follow || !options.from_state.empty())
        return stream(options, progress);
    std::optional<OutputFolder> folder;
    if (!options.out.empty()) {
        check_not_input(options.out + "/series.csv", {options.file, options.nuisance.file});
        folder.emplace(options.out, kPeriodFiles);
    }
    toliman::measurements given = read_series(options, progress);
    const std::optional<ReductionNote> reduced = add_functions(
        options, !options.sums.fixed_mean, options.save_state.empty() ? "" : "--save-state", given, progress);
    SumOptions sums = options.sums;
    sums.margins = !options.save_state.empty();
    const FrequencyGrid grid = grid_of(options, given.get());
    Instruments instruments = instruments_of(given.get());
    toliman::measurements series = with_jitters(given.get(), instruments);
    Periodogram periodogram = search(series.get(), grid, sums, progress);
    if (!instruments.empty()) { // the jitters without the signal contain it
        instruments = instruments_of(given.get(), periodogram.peak.frequency);
        series = with_jitters(given.get(), instruments);
        periodogram = search(series.get(), grid, sums, progress);
    }
    if (!options.save_state.empty())
        save_state(periodogram.handle, options.save_state);
    write_results(options, series.get(), reduced ? &*reduced : nullptr, instruments, periodogram,
                  folder ? &*folder : nullptr, progress);
}

} // namespace

void add_period(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "period");
    auto options = std::make_shared<PeriodOptions>();
    CLI::Option *file = add_option(command, "FILE", options->file, "");
    options->samples.add_to(*command, true);
    command->add_option("--f0", options->f0);
    command->add_option("--df", options->df);
    command->add_option("--nf", options->nf);
    command->add_flag("--fixed-mean", options->sums.fixed_mean);
    options->nuisance.add_to(*command);
    for (const char *name : kNuisanceOptions)
        command->get_option(name)->excludes(command->get_option("--fixed-mean"));
    command->add_option("--value-bound", options->sums.value_bound);
    command->add_option("--sigma-floor", options->sums.sigma_floor);
    command->add_option("--sigma-ceiling", options->sums.sigma_ceiling);
    command->add_option("--peaks", options->peaks)->check(CLI::Range(1u, 64u));
    add_option(command, "--save-state", options->save_state, "FILE");
    CLI::Option *state = add_option(command, "--from-state", options->from_state, "FILE");
    for (const char *name : {"--f0", "--df", "--nf", "--fixed-mean", "--trend", "--span", "--nuisance-file", "--prior",
                             "--value-bound", "--sigma-floor", "--sigma-ceiling", "--instrument"})
        state->excludes(command->get_option(name)); // contained in the state
    command->add_flag("--json", options->as_json);
    add_option(command, "--power", options->power_file, "FILE");
    CLI::Option *out = add_option(command, "--out", options->out, "DIR");
    out->excludes(state);
    add_choice(command, "--normalisation", options->normalisation, kNormalisations);
    add_fap(*command, options->fap);
    add_noise(*command, options->noise);
    CLI::Option *noise = command->get_option("--noise")->excludes(state)->excludes(command->get_option("--fixed-mean"));
    CLI::Option *follow = command->add_flag("--follow", options->follow);
    for (const char *name : {"--power", "--normalisation", "--peaks", "--fap", "--resamplings", "--seed"})
        follow->excludes(command->get_option(name)); // of a result at the end
    follow->excludes(noise)->excludes(out);
    for (const char *name : {"--nuisance-file", "--prior", "--instrument"}) // of a whole series
        follow->excludes(command->get_option(name));
    CLI::Option *system = add_system_options(*command, *options);
    system->excludes(follow)->excludes(state); // which have the sums, but not the samples
    command->add_flag("--strict", options->strict)->needs(follow);
    set_action(*command, context, options, period, [options, file] {
        if (file->count() == 0 && (options->from_state.empty() || options->follow))
            throw CLI::RequiredError("FILE");
    });
}

} // namespace cli
