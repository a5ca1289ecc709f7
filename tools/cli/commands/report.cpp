// toliman report: starts the Python module toliman.report on folders of results; writes those of state folders first.
#include <unistd.h>

#include "common/content.hpp"
#include "downlink/ledger_report.hpp"
#include "downlink/planet_job.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

struct ReportOptions {
    std::vector<std::string> folders;
    std::string out;
    bool png = false, pdf = false, force = false;
};

constexpr int64_t kMostSearched = 5000; // frames, in seconds

// Searches the frames of a state folder with a system for planets, and returns the folder of the results; "" if a
// search is not possible.
std::string with_planets(const std::string &folder, const toliman::tracker &tracker, Progress &progress) try {
    if (info_of(tracker).system == nullptr || info_of(tracker).accepted == 0)
        return "";
    if (info_of(tracker).accepted > kMostSearched) {
        progress.warn(folder +
                      ": is not searched for planets, which takes long for so many frames: see `toliman planet`");
        return "";
    }
    PlanetJobOptions options;
    options.file = folder;
    options.out = folder + "/report/planets";
    options.limits = true;
    PlanetJob(options, true, progress).write();
    return options.out;
} catch (const Failure &failure) {
    progress.warn(folder + ": is not searched for planets: " + failure.what());
    return "";
}

bool has_planets(const std::string &folder) {
    return identify(plain(folder) + "/result.json").name == "JSON of schema toliman-planet/1";
}

// The folders whose results are drawn: those of a state folder, with a search for planets unless one is given, or the
// folder itself.
std::vector<std::string> with_results(const std::string &folder, bool searches, Progress &progress) {
    if (exists(folder) && !is_folder(folder))
        malformed(folder, "is not a folder: give one written by run, experiment, track, period --out, planet --out, "
                          "pupil --out or `make bench`" +
                              kind_of(folder));
    if (!exists(folder + "/ledger.tlml"))
        return {folder};
    const toliman::tracker tracker = open_tracker(state_to_read(folder), progress);
    write_results(tracker, settings_of(tracker), PeriodFacts(tracker, Fit::tested, progress), folder + "/report");
    std::vector<std::string> folders = {folder + "/report"};
    if (const std::string planets = searches ? with_planets(folder, tracker, progress) : ""; !planets.empty())
        folders.push_back(planets);
    return folders;
}

// Replaces this process. The module's folder takes the place of the current folder in Python's search path.
[[noreturn]] void start_python(const std::vector<std::string> &words) {
    const std::string modules = installed("lib/python3/dist-packages");
    if (!exists(modules + "/toliman/report/__main__.py"))
        throw Failure(kExitInternal, "report needs the Python package toliman: apt-get install python3-toliman");
    constexpr char python[] = "/usr/bin/python3";
    constexpr char start[] = "import sys; sys.path[0] = sys.argv.pop(1); from toliman.report.__main__ import main; "
                             "sys.exit(main())";
    std::vector<const char *> arguments = {python, "-B", "-c", start, modules.c_str()};
    for (const std::string &word : words)
        arguments.push_back(word.c_str());
    arguments.push_back(nullptr);
    ::execv(python, const_cast<char **>(arguments.data()));
    throw Failure(kExitInternal, std::string(python) + ": " + std::strerror(errno) +
                                     ": report needs the Debian packages python3-matplotlib and python3-jinja2");
}

void report(const ReportOptions &options, Progress &progress) {
    progress.show("report", 0);
    std::vector<std::string> words;
    for (const auto &[name, is_given] :
         {std::pair("--png", options.png), {"--pdf", options.pdf}, {"--force", options.force}})
        if (is_given)
            words.emplace_back(name);
    const std::string first = plain(options.folders[0]);
    words.push_back("--out=" + (options.out.empty() ? first + "/report" : plain(options.out)));
    words.emplace_back("--");
    const bool searches = std::none_of(options.folders.begin(), options.folders.end(), has_planets);
    for (const std::string &folder : options.folders)
        for (const std::string &results : with_results(plain(folder), searches, progress))
            words.push_back(results);
    block_signals();
    progress.clear();
    start_python(words);
}

} // namespace

void add_report(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "report");
    auto options = std::make_shared<ReportOptions>();
    add_option(command, "DIR", options->folders, "")->required();
    add_option(command, "--out", options->out, "FOLDER");
    command->add_flag("--png", options->png);
    command->add_flag("--pdf", options->pdf);
    set_action(*command, context, options, report,
               [command, options] { options->force = command->count("--force") > 0; });
}

} // namespace cli
