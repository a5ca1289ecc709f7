// toliman: the command line of libtoliman.
#include <algorithm>
#include <cstdio>

#include "command.hpp"
#include "failure.hpp"
#include "fast_blas.hpp"
#include "help.hpp"
#include "suggest.hpp"

namespace {

using namespace cli;

constexpr char kDescription[] = R"(Period of a planet from frames of the TOLIMAN space telescope.

Examples:
  toliman run chapter.json                    simulate, train, encode fresh noise, find the period
  toliman experiment chapter.json --out table  which method finds which amplitude
  toliman period rv.csv                       period of a series t,y[,sigma]
  toliman track --weights w.tlmw --state mission --mission-days 1095 --dtype u16le --follow downlink/
  toliman status mission                      frames and period of a state folder
  toliman merge a.tlmp b.tlmp --out c.tlmp    sums of several periodograms, or state folders, in one
  toliman psf chapter.json --out psf.npy      the expected image
  toliman train chapter.json --out w.tlmw     weights for `encode`
  toliman simulate chapter.json --frames 0:100 --out frames.npy
  toliman encode --weights w.tlmw frames.npy  one separation in pixels a frame, as CSV
  toliman convert mask.fits mask.npy          FITS to .npy and back
  toliman plan scene.json                     what a scene needs and what it costs
  toliman pupil chapter.json --out better.json  search a mask that tells more
  toliman doctor                              what this machine offers

Data goes to stdout, everything else to stderr. Exit codes: 0 ok, 1 internal, 2 options or scene content,
3 an input file missing or malformed, 4 finished but samples or frames skipped (--strict), 5 state folder damaged,
6 output cannot be written or another process writes to the folder, 129/130/143 stopped by SIGHUP, SIGINT, SIGTERM.)";

int complain(int code, const char *text) {
    std::fprintf(stderr, "toliman: %s\n", text);
    return code;
}

// The words of the command line, last first as CLI11 takes them; `help [COMMAND]` is `[COMMAND] --help`.
std::vector<std::string> asked_words(int argc, char **argv) {
    std::vector<std::string> words(argv + 1, argv + argc);
    if (!words.empty() && words[0] == "help") {
        words.erase(words.begin());
        words.insert(words.begin() + (words.empty() ? 0 : 1), "--help");
    }
    std::reverse(words.begin(), words.end());
    return words;
}

int parse_and_run(int argc, char **argv) {
    Context context;
    CLI::App app(kDescription, "toliman");
    app.set_version_flag("--version", std::string("toliman ") + toliman_version());
    app.add_option("--progress", context.progress, "bar on a terminal (auto), JSON lines (json) or nothing (none)")
        ->check(CLI::IsMember({"auto", "json", "none"}));
    app.require_subcommand(1);
    app.formatter(std::make_shared<HelpFormatter>());
    app.fallthrough();
    add_run(app, context);
    add_experiment(app, context);
    add_psf(app, context);
    add_simulate(app, context);
    add_train(app, context);
    add_encode(app, context);
    add_convert(app, context);
    add_period(app, context);
    add_merge(app, context);
    add_track(app, context);
    add_status(app, context);
    add_rebuild(app, context);
    add_plan(app, context);
    add_pupil(app, context);
    add_doctor(app, context);
    try {
        app.parse(asked_words(argc, argv));
    } catch (const CLI::Success &success) { // --help, --version
        return app.exit(success);
    } catch (const CLI::ParseError &error) {
        const std::string unknown = unknown_word(app, argc, argv);
        return complain(kExitUsage, unknown.empty() ? error.what() : unknown.c_str());
    }
    watch_signals();
    try {
        context.action();
    } catch (const toliman::error &error) {
        if (error.status() == TOLIMAN_E_CANCELLED)
            stop_if_asked(); // in the words of the program
        throw;
    }
    return kExitOk;
}

} // namespace

int main(int argc, char **argv) {
    int code = kExitOk;
    const Ending ending = ending_of([&] {
        restart_with_fast_blas(argv);
        code = parse_and_run(argc, argv);
    });
    return ending.code == kExitOk ? code : complain(ending.code, ending.why.c_str());
}
