// toliman report: what other commands left in folders, as a page with figures.
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

constexpr char kDescription[] = R"(A page with figures and tables of what run, experiment, track or `make bench` left.

Examples:
  toliman report chapter.run
  toliman report chapter.run table --out paper      both on one page
  toliman report mission                            a state folder of track, also while it is written

Writes report.html, which needs no other file and no network, and each figure as figures/NAME.svg and figures/NAME.png
into a folder, in place of the page and the figures that another report left there, then prints the path of the page. What
a folder is it is told by: result.json (run), experiment.json (experiment), ledger.tlml (track), *.json of schema
toliman-bench/1 (make bench). Images are computed anew from the scene and the weights that `toliman run` leaves; frames are
those of the run. Figures are drawn by gnuplot (Debian: gnuplot-nox).)";

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
                  "is no folder: give the one that run, experiment, track or `make bench` wrote" + kind_remark(folder));
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
    malformed(folder, "holds neither result.json (of toliman run), nor experiment.json (experiment), nor ledger.tlml "
                      "(track), nor a *.json of schema toliman-bench/1 (make bench)" +
                          kind_remark(folder));
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
    command->add_option("DIR", options->folders, "folders of results, on one page in this order")->required();
    command->add_option("--out", options->out, "folder for the page and its figures, default report in the first DIR");
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            report(*options, progress);
        };
    });
}

} // namespace cli
