// toliman: the command line program of libtoliman.
#include "common/process.hpp"
#include "options/command.hpp"
#include "options/suggest.hpp"

namespace {

using namespace cli;

int print_error(int code, const char *text) {
    std::fprintf(stderr, "toliman: %s\n", text);
    return code;
}

// The words of the command line in reverse order, as CLI11 expects them; `help [COMMAND]` means `[COMMAND] --help`.
std::vector<std::string> command_line_words(int argc, char **argv) {
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
        app.parse(command_line_words(argc, argv));
    } catch (const CLI::Success &success) { // --help, --version
        return app.exit(success);
    } catch (const CLI::ParseError &error) {
        throw Failure(kExitUsage, command_line_error(error, app, argc, argv));
    }
    watch_signals();
    try {
        context.action();
    } catch (const toliman::error &error) {
        if (error.status() == TOLIMAN_E_CANCELLED)
            stop_if_asked(); // with the program's own message
        throw;
    }
    return kExitOk;
}

} // namespace

int main(int argc, char **argv) {
    int code = kExitOk;
    const Ending ending = ending_of([&] {
        prepare_process(argv);
        code = parse_and_run(argc, argv);
    });
    if (ending.code == kExitOk)
        return code;
    return ending.why.empty() ? static_cast<int>(ending.code) : print_error(ending.code, ending.why.c_str());
}
