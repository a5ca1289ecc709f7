// toliman: the command line of libtoliman.
#include <algorithm>
#include <cstdio>
#include <utility>

#include "common/failure.hpp"
#include "common/fast_blas.hpp"
#include "options/command.hpp"
#include "options/suggest.hpp"

namespace {

using namespace cli;

int complain(int code, const char *text) {
    std::fprintf(stderr, "toliman: %s\n", text);
    return code;
}

// The words of the command line, last first as CLI11 takes them; `help [COMMAND]` is `[COMMAND] --help`.
std::vector<std::string> asked_words(int argc, char **argv) {
    std::vector<std::string> words(argv + 1, argv + argc);
    if (!words.empty() && words[0] == "help") {
        words[0] = "--help";
        if (words.size() > 1)
            std::swap(words[0], words[1]);
    }
    std::reverse(words.begin(), words.end());
    return words;
}

int parse_and_run(int argc, char **argv) {
    Context context;
    CLI::App app;
    add_commands(app, context);
    try {
        app.parse(asked_words(argc, argv));
    } catch (const CLI::Success &success) { // --help, --version
        return app.exit(success);
    } catch (const CLI::ParseError &error) {
        throw Failure(kExitUsage, complaint(error, app, argc, argv));
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
    if (ending.code == kExitOk)
        return code;
    return ending.why.empty() ? static_cast<int>(ending.code) : complain(ending.code, ending.why.c_str());
}
