// toliman experiment: detection methods over a range of signal amplitudes, with controls.
#include <algorithm>
#include <charconv>

#include "common/failure.hpp"
#include "common/output.hpp"
#include "common/stop.hpp"
#include "common/text.hpp"
#include "experiment/experiment_report.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

constexpr uint64_t kMostSeeds = 100000, kMostBlind = 10000000;
constexpr double kMostAmplitude = 0.1; // px, range of the expansion in the displacement

// The help text, with the list of methods.
std::string description() {
    std::string methods, text = help_text("experiment");
    for (const MethodKind &kind : method_kinds())
        methods += formatted("  %-16s  %s\n", kind.name, kind.what);
    const std::string place = "{methods}";
    return text.replace(text.find(place), place.size(), methods);
}

struct Options {
    std::string scene, folder;
    CampaignOptions campaign = {{1e-2, 1e-3, 1e-4, 1e-5, 1e-6}, {}, {"real", "equal", "robust"}, 20, 200};
    bool as_json = false, quick = false;
};

std::vector<double> amplitudes_of(const std::vector<std::string> &words) {
    std::vector<double> amplitudes;
    for (const std::string &word : words) {
        double value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        const bool number = error == std::errc() && end == word.data() + word.size();
        if (!number || !(value > 0 && value <= kMostAmplitude))
            throw CLI::ValidationError("--amplitudes", word + ": must be in (0, 0.1] px");
        amplitudes.push_back(value);
    }
    return amplitudes;
}

template <class Value> void check_once(const CLI::Option *option, const std::vector<Value> &values) {
    for (size_t i = 0; i < values.size(); i++)
        if (std::count(values.begin(), values.end(), values[i]) != 1)
            throw CLI::ValidationError(option->get_name(), option->results()[i] + ": must be given once");
}

void remove_slow(std::vector<std::string> &methods) {
    const auto slow = [](const std::string &name) { return method_kind(name).slow; };
    methods.erase(std::remove_if(methods.begin(), methods.end(), slow), methods.end());
}

ExperimentReport run_campaign(const std::shared_ptr<const Scene> &scene, const CampaignOptions &options,
                              const std::string &journal_path, Progress &progress) {
    constexpr char stopped[] = "stopped by a signal; the same command resumes the experiment";
    try {
        const StopLimit limit(stopped);
        const Campaign campaign(scene, options);
        Journal journal(journal_path, campaign.arguments());
        campaign.run(journal, progress);
        return report_of(campaign, journal);
    } catch (...) {
        if (stop_signal() != 0) {
            progress.clear();
            throw Failure(stop_code(), stopped);
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
    const ExperimentReport report = run_campaign(scene, options.campaign, folder.file("journal.jsonl"), progress);
    folder.open("experiment.csv").write(report.csv);
    folder.open("experiment.md").write(report.markdown);
    folder.open("experiment.json").write(report.json);
    folder.commit("experiment.json"); // its existence implies that all other files are complete
    progress.clear();
    print_stdout(options.as_json ? report.json : report.markdown);
}

} // namespace

void add_experiment(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("experiment", description());
    auto options = std::make_shared<Options>();
    CampaignOptions &asked = options->campaign;
    std::vector<std::string> names;
    for (const MethodKind &kind : method_kinds()) {
        names.emplace_back(kind.name);
        if (!kind.on_request)
            asked.methods.emplace_back(kind.name);
    }
    const auto list = [](CLI::Option *option, const std::string &type) {
        return option->delimiter(',')->allow_extra_args(false)->type_name(type);
    };
    add_scene(*command, options->scene);
    add_option(command, "--out", options->folder, "FOLDER", "folder for the results")->required();
    CLI::Option *amplitudes =
        list(command->add_option_function<std::vector<std::string>>(
                 "--amplitudes", [&asked](const auto &words) { asked.amplitudes = amplitudes_of(words); },
                 "signal amplitudes in px, default 1e-2,1e-3,1e-4,1e-5,1e-6"),
             "PX,...");
    CLI::Option *methods = list(
        command->add_option("--methods", asked.methods, "methods to compare, default all but bank and untrained-bank"),
        "NAME,...:{" + joined(names, ",") + "}");
    CLI::Option *tables =
        list(command->add_option("--tables", asked.tables, "tables to make, default real,equal,robust"), "NAME,...")
            ->check(CLI::IsMember(asked.tables));
    CLI::Option *seeds = command->add_option("--seeds", asked.seeds, "N: seeds 1 to N of weights and noise, default 20")
                             ->check(CLI::Range(uint64_t{1}, kMostSeeds));
    CLI::Option *blind = command->add_option("--blind", asked.blind, "series without signal per table, default 200")
                             ->check(CLI::Range(uint64_t{0}, kMostBlind));
    command->add_flag("--quick", options->quick,
                      "change the defaults: 3 seeds, 30 series without signal, table real, no cae-unsupervised");
    add_controls(
        *command, asked.controls,
        "none: no series without signal; quick: a tenth of them, at least one per seed; full, the default: all");
    command->add_flag("--json", options->as_json, "print experiment.json instead of the tables");
    set_action(*command, context, options, experiment, [options, amplitudes, methods, tables, seeds, blind] {
        CampaignOptions &campaign = options->campaign;
        check_once(amplitudes, campaign.amplitudes);
        check_once(methods, campaign.methods);
        check_once(tables, campaign.tables);
        if (options->quick && methods->count() == 0)
            remove_slow(campaign.methods);
        if (options->quick && tables->count() == 0)
            campaign.tables = {"real"};
        if (options->quick && seeds->count() == 0)
            campaign.seeds = 3;
        if (options->quick && blind->count() == 0)
            campaign.blind = 30;
        if (campaign.controls == Controls::none)
            campaign.blind = 0;
        if (campaign.controls == Controls::quick)
            campaign.blind = std::min(campaign.blind, std::max(campaign.blind / 10, campaign.seeds));
    });
}

} // namespace cli
