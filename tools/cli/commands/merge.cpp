// toliman merge: saved sums, or state folders, of several shards into one.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <string_view>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/output.hpp"
#include "downlink/merge_folders.hpp"
#include "downlink/state_folder.hpp"
#include "options/command.hpp"
#include "series/periodogram.hpp"

namespace cli {

namespace {

struct Options {
    std::vector<std::string> files;
    std::string out;
    bool salvage = false;
    SetupOptions setup;
};

constexpr char kBounds[] = " (--value-bound, --sigma-floor, --sigma-ceiling of the run that made the first state)";

// Refuses a state that was given before, as the same file or as a copy: its samples would count twice. The same samples
// always have the same bytes, so a hash of the bytes identifies them.
void check_new(const toliman::periodogram &state, const std::string &file, std::map<size_t, std::string> &seen) {
    const std::vector<unsigned char> bytes = state_bytes(state);
    const std::string_view text(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    const auto [other, is_new] = seen.emplace(std::hash<std::string_view>()(text), file);
    if (!is_new && toliman_period_count(state.get()) > 0)
        malformed(file, "has the same samples as " + other->second + ": give each once; nothing was written");
}

// Refuses to mix samples with and without sigma: those without would have the weight of the smallest sigma.
void check_weights(const toliman_period_info &before, const toliman_period_info &more, const std::string &file) {
    if (before.count > 0 && more.count > 0 && before.weighted != more.weighted)
        malformed(file, std::string("its samples have ") + (more.weighted != 0 ? "a" : "no") +
                            " sigma, those of the files before have " + (more.weighted != 0 ? "none" : "one"));
}

[[noreturn]] void refuse_single(const std::string &file) {
    is_folder(file) ? static_cast<void>(known_state(plain(file))) : static_cast<void>(load_state(file));
    throw Failure(kExitUsage, "merge: only one state: give two or more" +
                                  std::string(is_folder(file) ? ", or --salvage for a damaged folder" : ""));
}

void merge(Options &options, Progress &progress) {
    for (const std::string &file : options.files)
        if (!exists(file))
            malformed(file, std::strerror(errno));
    const auto folders = std::count_if(options.files.begin(), options.files.end(), is_folder);
    if (folders > 0 && folders < static_cast<std::ptrdiff_t>(options.files.size()))
        throw Failure(kExitUsage, "merge: state folders and files of sums: give only one kind");
    if (options.files.size() < 2 && !options.salvage)
        refuse_single(options.files.front());
    if (folders > 0)
        return merge_folders(options.files, options.out, options.salvage, options.setup, progress);
    if (options.salvage || options.setup.has_grid() || options.setup.has_clock() || options.setup.has_timing())
        throw Failure(kExitUsage, "merge: --salvage, --grid, --mission-days and --clock are for state folders only");
    check_output(options.out);
    const toliman::periodogram sum = load_state(options.files.front());
    std::map<size_t, std::string> seen; // files by a hash of their content
    check_new(sum, options.files.front(), seen);
    for (size_t i = 1; i < options.files.size(); i++) {
        const std::string &file = options.files[i];
        const toliman::periodogram more = load_state(file);
        check_new(more, file, seen);
        check_weights(info_of(sum), info_of(more), file);
        const toliman_status status = toliman_period_merge(sum.get(), more.get());
        if (status != TOLIMAN_OK)
            malformed(file, toliman_last_error() + std::string(status == TOLIMAN_E_RANGE ? kBounds : ""));
    }
    save_state(sum, options.out);
    std::fprintf(stderr, "%s: %lld samples\n", options.out.c_str(),
                 static_cast<long long>(toliman_period_count(sum.get())));
}

} // namespace

void add_merge(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "merge");
    auto options = std::make_shared<Options>();
    add_option(command, "STATES", options->files, "", "files of `toliman period --save-state`, or state folders")
        ->required();
    add_option(command, "--out", options->out, "PATH",
               "file to write (.tlmp; - writes to standard output), or folder to create")
        ->required();
    command->add_flag("--salvage", options->salvage, "skip damaged records of a folder's ledger, and report them");
    options->setup.add_to(*command);
    set_action(*command, context, options, merge);
}

} // namespace cli
