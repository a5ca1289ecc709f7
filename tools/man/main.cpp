// toliman_manual TAILS SHARE: man pages and bash completion of the program into the folder SHARE.
#include <cstdio>
#include <fstream>
#include <sstream>

#include "completion.hpp"
#include "option.hpp"
#include "page.hpp"

namespace {

// The hand-written end of a page; most have none.
std::string tail_of(const std::string &folder, const std::string &page) {
    std::ifstream file(folder + "/" + page + ".tail");
    std::ostringstream text;
    if (file)
        text << file.rdbuf();
    return text.str();
}

void write(const std::string &path, const std::string &text) {
    std::ofstream file(path);
    if (!(file << text).flush())
        throw std::runtime_error(path + ": cannot be written");
}

void write_page(const CLI::App &command, const std::string &tails, const std::string &share) {
    const std::string name = manual::page_name(command);
    write(share + "/man/man1/" + name + ".1", manual::page(command, tail_of(tails, name)));
}

void write_all(const std::string &tails, const std::string &share) {
    cli::Context context;
    CLI::App app;
    cli::add_commands(app, context);
    write_page(app, tails, share);
    for (const CLI::App *command : manual::commands_of(app))
        write_page(*command, tails, share);
    write(share + "/bash-completion/completions/toliman", manual::completion(app));
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 3) {
        std::fputs("usage: toliman_manual TAILS SHARE\n", stderr);
        return 2;
    }
    const cli::Ending ending = cli::ending_of([&] { write_all(argv[1], argv[2]); });
    if (ending.code != cli::kExitOk)
        std::fprintf(stderr, "toliman_manual: %s\n", ending.why.c_str());
    return ending.code;
}
