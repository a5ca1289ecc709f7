// toliman report: results of other commands as an HTML page with figures.
#include <cerrno>
#include <cstring>
#include <unistd.h>

#include "common/content.hpp"
#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/output.hpp"
#include "options/command.hpp"
#include "report/page.hpp"
#include "report/sections.hpp"

namespace cli {

namespace {

constexpr char kDescription[] = R"(Write an HTML page with figures from results of run, experiment, track or make bench.

Examples:
  # the page chapter.run/report/report.html
  toliman report chapter.run
  # two folders on one page
  toliman report chapter.run table --out paper
  # a state folder of track, also while track writes to it
  toliman report mission

Input: the type of a folder is recognised by its files.
  result.json                       a folder of toliman run
  experiment.json                   a folder of toliman experiment
  ledger.tlml                       a state folder of toliman track
  *.json of toliman-bench/1         a folder of make bench

Output: report.html, which needs no other file and no network, and each figure as figures/NAME.svg and
figures/NAME.png. They replace the page and the figures of an earlier report in the same folder. The path of the page
is printed.

Images are computed from the scene and the weights in the folder of `toliman run`; frames are those of the run.
Figures are drawn by gnuplot (Debian package gnuplot-nox).

Exit codes: 1 if gnuplot is missing or fails; the others are listed in `toliman --help`.)";

struct Options {
    std::vector<std::string> folders;
    std::string out;
};

using Section = void (*)(const std::string &folder, Page &page, Progress &progress);

Section section_of(const std::string &folder) {
    if (!exists(folder))
        malformed(folder, errno == ENOENT ? "No such folder" : std::strerror(errno));
    if (!is_folder(folder))
        malformed(folder,
                  "is not a folder: give one written by run, experiment, track or `make bench`" + kind_of(folder));
    if (::access(folder.c_str(), R_OK | X_OK) != 0)
        malformed(folder, std::strerror(errno));
    if (exists(folder + "/result.json"))
        return add_run_section;
    if (exists(folder + "/experiment.json"))
        return add_experiment_section;
    if (exists(folder + "/ledger.tlml"))
        return add_state_section;
    if (!bench_files(folder).empty())
        return add_bench_section;
    malformed(folder,
              "contains neither result.json (of toliman run), nor experiment.json (experiment), nor ledger.tlml "
              "(track), nor a *.json of schema toliman-bench/1 (make bench)" +
                  kind_of(folder));
}

void report(Options &options, Progress &progress) {
    std::vector<Section> sections;
    for (std::string &folder : options.folders) {
        folder = plain(folder);
        sections.push_back(section_of(folder));
    }
    Page page(options.out.empty() ? options.folders[0] + "/report" : plain(options.out));
    for (size_t i = 0; i < sections.size(); i++) {
        page.set_prefix(i > 0 ? std::to_string(i + 1) + "-" : "");
        sections[i](options.folders[i], page, progress);
        stop_if_asked();
    }
    const std::string path = page.write();
    progress.clear();
    print_stdout(path + "\n");
}

} // namespace

void add_report(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("report", kDescription);
    auto options = std::make_shared<Options>();
    command->add_option("DIR", options->folders, "folders of results, shown on one page in this order")
        ->type_name("")
        ->required();
    command
        ->add_option("--out", options->out, "folder for the page and its figures, default DIR/report of the first DIR")
        ->type_name("FOLDER");
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            report(*options, progress);
        };
    });
}

} // namespace cli
