// toliman experiment: detection methods over a range of signal amplitudes, with controls.
#include <algorithm>
#include <charconv>
#include <cstring>

#include "common/failure.hpp"
#include "common/output.hpp"
#include "experiment/experiment_report.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

constexpr char kBeforeMethods[] = R"(Compare detection methods over a range of signal amplitudes, with controls.

Examples:
  # a first impression: four minutes
  toliman experiment chapter.json --quick --out quick
  # all methods and tables: about an hour on two cores
  toliman experiment chapter.json --out table
  # two methods at three amplitudes with 50 seeds each
  toliman experiment scene.json --tables real --amplitudes 1e-5,3e-6,1e-6 --methods cae,template --seeds 50 --out fine

The scene's signal is given each amplitude in turn. For each amplitude and seed a series of frames is simulated with
fresh noise that no training has seen, and every method gets the same frames. The results per method are the period,
its relative error, log10 FAP, the slope of the values over the true displacement, and the efficiency: the Cramer-Rao
bound divided by the scatter about that line.

Methods:
)";
constexpr char kAfterMethods[] = R"(
Tables:
  real    the scene as it is
  equal   the scene with both stars equally bright
  robust  frames with jitter of pointing and fluxes, with and without projecting it out; and frames of
          scenes that differ from the one the methods were made for, as they are and relative to
          their own mean; with the scene's own amplitude and at most 10 seeds

Controls: --blind series without signal per table, on which the FAP should be uniformly distributed, and the results
expected in theory of a method that reaches the Cramer-Rao bound.

Methods that learn from the series itself (pca, pca-white, pca-blocks, dictionary, cae-unsupervised) and
untrained-paper are in the tables `real` and `equal` only. Those that learn from the series have no series without
signal. cae-unsupervised takes about a minute per series, so it has only seed 1 and amplitudes of at least 1e-4 px.
Methods that learn from the series, except pca-blocks, hold the frames of one series in memory, 4 bytes per pixel.

Output: the tables on standard output, and a folder with these files.
  experiment.json  all results (schema toliman-experiment/1)
  experiment.csv   one row per method and series
  experiment.md    the tables
  journal.jsonl    every result as soon as it is known
If the experiment is stopped, the same command resumes from the journal. Other arguments need another folder.

Exit codes are listed in `toliman --help`.)";

constexpr const char *kTables[] = {"real", "equal", "robust"};
constexpr uint64_t kMostSeeds = 100000, kMostBlind = 10000000;
constexpr double kMostAmplitude = 0.1; // px, range of the expansion in the displacement

std::string description() {
    std::string methods;
    for (const MethodKind &kind : method_kinds())
        methods += "  " + std::string(kind.name).append(18 - std::strlen(kind.name), ' ') + kind.what + "\n";
    return kBeforeMethods + methods + kAfterMethods;
}

struct Options {
    std::string scene, folder;
    CampaignOptions campaign = {{1e-2, 1e-3, 1e-4, 1e-5, 1e-6}, {}, {std::begin(kTables), std::end(kTables)}, 20, 200};
    bool as_json = false;
};

std::vector<double> amplitudes_of(const std::vector<std::string> &words) {
    std::vector<double> amplitudes;
    for (const std::string &word : words) {
        double value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        const bool number = error == std::errc() && end == word.data() + word.size();
        if (!number || !(value > 0 && value <= kMostAmplitude))
            throw CLI::ValidationError("--amplitudes", word + ": must be in (0, 0.1] px");
        if (std::count(amplitudes.begin(), amplitudes.end(), value) != 0)
            throw CLI::ValidationError("--amplitudes", word + ": must be given once");
        amplitudes.push_back(value);
    }
    return amplitudes;
}

void remove_slow(std::vector<std::string> &methods) {
    const auto slow = [](const std::string &name) { return method_kind(name).slow; };
    methods.erase(std::remove_if(methods.begin(), methods.end(), slow), methods.end());
}

void check_names(const char *option, const std::vector<std::string> &names) {
    for (const std::string &name : names)
        if (std::count(names.begin(), names.end(), name) != 1)
            throw CLI::ValidationError(option, name + ": must be given once");
}

void write(OutputFile &out, const std::string &text) {
    out.write(text.data(), text.size());
}

void write_results(const std::string &csv, const std::string &markdown, const std::string &json,
                   const OutputFolder &folder) {
    OutputFile rows(folder.file("experiment.csv")), tables(folder.file("experiment.md"));
    OutputFile result(folder.file("experiment.json"));
    write(rows, csv);
    write(tables, markdown);
    write(result, json);
    rows.commit();
    tables.commit();
    result.commit(); // last: an experiment.json implies that all other files are complete
}

void run_campaign(const Campaign &campaign, Journal &journal, Progress &progress) {
    try {
        campaign.run(journal, progress);
    } catch (...) {
        if (stop_signal() != 0) {
            progress.clear();
            throw Failure(stop_code(), "stopped by a signal; the same command resumes the experiment");
        }
        throw;
    }
}

void experiment(const Options &options, Progress &progress) {
    for (const std::string &name : options.campaign.methods)
        method_kind(name);
    const auto scene = std::make_shared<const Scene>(options.scene, progress);
    check_cadence(*scene, "experiment");
    OutputFolder folder(options.folder);
    for (const char *name : {"experiment.csv", "experiment.md", "experiment.json"})
        check_output(folder.file(name)); // before the computation: an unwritable file fails at once
    const Campaign campaign(scene, options.campaign);
    Journal journal(folder.file("journal.jsonl"), campaign.arguments());
    run_campaign(campaign, journal, progress);
    const std::vector<TableSummary> summaries = summarise(campaign, journal);
    const std::string json = report_json(campaign, summaries), markdown = report_markdown(campaign, summaries);
    write_results(report_csv(campaign, journal), markdown, json, folder);
    folder.keep();
    progress.clear();
    print_stdout(options.as_json ? json : markdown);
}

} // namespace

void add_experiment(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("experiment", description());
    auto options = std::make_shared<Options>();
    CampaignOptions &asked = options->campaign;
    for (const MethodKind &kind : method_kinds())
        asked.methods.emplace_back(kind.name);
    auto amplitudes = std::make_shared<std::vector<std::string>>();
    auto quick = std::make_shared<bool>(false);
    add_scene(*command, options->scene);
    add_option(command, "--out", options->folder, "FOLDER", "folder for the results")->required();
    CLI::Option *ladder =
        command->add_option("--amplitudes", *amplitudes, "signal amplitudes in px, default 1e-2,1e-3,1e-4,1e-5,1e-6")
            ->delimiter(',')
            ->allow_extra_args(false)
            ->type_name("PX,...");
    CLI::Option *methods = command->add_option("--methods", asked.methods, "methods to compare, default all")
                               ->delimiter(',')
                               ->allow_extra_args(false)
                               ->type_name("NAME,...:{" + CLI::detail::join(asked.methods, ",") + "}");
    CLI::Option *tables = command->add_option("--tables", asked.tables, "tables to make, default real,equal,robust")
                              ->delimiter(',')
                              ->allow_extra_args(false)
                              ->type_name("NAME,...")
                              ->check(CLI::IsMember(std::vector<std::string>(std::begin(kTables), std::end(kTables))));
    CLI::Option *seeds = command->add_option("--seeds", asked.seeds, "N: seeds 1 to N of weights and noise, default 20")
                             ->check(CLI::Range(uint64_t{1}, kMostSeeds));
    CLI::Option *blind = command->add_option("--blind", asked.blind, "series without signal per table, default 200")
                             ->check(CLI::Range(uint64_t{0}, kMostBlind));
    command->add_flag("--quick", *quick,
                      "change the defaults: 3 seeds, 30 series without signal, table real, no cae-unsupervised");
    command->add_flag("--json", options->as_json, "print experiment.json instead of the tables");
    set_action(*command, context, options, experiment,
               [options, amplitudes, quick, ladder, methods, tables, seeds, blind] {
                   CampaignOptions &campaign = options->campaign;
                   if (ladder->count() > 0)
                       campaign.amplitudes = amplitudes_of(*amplitudes);
                   check_names("--methods", campaign.methods);
                   check_names("--tables", campaign.tables);
                   if (*quick && methods->count() == 0)
                       remove_slow(campaign.methods);
                   if (*quick && tables->count() == 0)
                       campaign.tables = {"real"};
                   if (*quick && seeds->count() == 0)
                       campaign.seeds = 3;
                   if (*quick && blind->count() == 0)
                       campaign.blind = 30;
               });
}

} // namespace cli
