// toliman merge: the sums of shards, or their state folders, into one.
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

constexpr char kDescription[] = R"(Add up the saved sums of periodograms, or state folders of `toliman track`.

Examples:
  toliman period monday.csv --f0 1e-3 --df 1e-4 --nf 5000 --follow --save-state monday.tlmp
  toliman period tuesday.csv --from-state monday.tlmp --save-state both.tlmp
  toliman merge here.tlmp there.tlmp --out all.tlmp
  toliman period --from-state all.tlmp
  toliman merge shard_1 shard_2 shard_3 --out mission

The first file's grid and references stay. With equal ones the result has the bits that all samples in one periodogram
would give, in any shards and order; others of the same frequencies are turned to the first's. No file may be given
twice, as itself or as a copy, and sigmas stand in all files or in none.

Of state folders grid and clock are the first's, unless both are given, and counts are those of all together. A folder
that is refused because its ledger is damaged can be brought into a new one, with --salvage, less the lines that are lost:
  toliman merge mission --salvage --out mission_saved)";

// The same samples make the same bytes: a state given twice would count them twice.
class Once {
  public:
    void check(const toliman::periodogram &state, const std::string &file) {
        const std::vector<unsigned char> bytes = state_bytes(state);
        const std::string_view text(reinterpret_cast<const char *>(bytes.data()), bytes.size());
        const auto [other, is_new] = seen_.emplace(std::hash<std::string_view>()(text), file);
        if (!is_new && toliman_period_count(state.get()) > 0)
            malformed(file, "holds the same samples as " + other->second + ": give each once; nothing was written");
    }

  private:
    std::map<size_t, std::string> seen_; // files by a hash of their content
};

// Samples without sigma would weigh as much as those of the smallest one.
void check_weights(const toliman_period_info &before, const toliman_period_info &more, const std::string &file) {
    if (before.count > 0 && more.count > 0 && before.weighted != more.weighted)
        malformed(file, std::string("its samples have ") + (more.weighted != 0 ? "a" : "no") +
                            " sigma, those before have " + (more.weighted != 0 ? "none" : "one"));
}

[[noreturn]] void refuse_single(const std::string &file) {
    is_folder(file) ? static_cast<void>(known_state(plain(file))) : static_cast<void>(load_state(file));
    throw Failure(kExitUsage, "merge: one state alone: give two or more" +
                                  std::string(is_folder(file) ? ", or --salvage for a damaged folder" : ""));
}

void merge(Options &options, Progress &progress) {
    for (const std::string &file : options.files)
        if (!exists(file))
            malformed(file, std::strerror(errno));
    const auto folders = std::count_if(options.files.begin(), options.files.end(), is_folder);
    if (folders > 0 && folders < static_cast<std::ptrdiff_t>(options.files.size()))
        throw Failure(kExitUsage, "merge: folders and files of sums together: give one kind");
    if (options.files.size() < 2 && !options.salvage)
        refuse_single(options.files.front());
    if (folders > 0)
        return merge_folders(options.files, options.out, options.salvage, options.setup, progress);
    if (options.salvage || options.setup.has_grid() || options.setup.has_clock())
        throw Failure(kExitUsage, "merge: --salvage, grid and clock are for state folders");
    check_output(options.out);
    const toliman::periodogram sum = load_state(options.files.front());
    Once once;
    once.check(sum, options.files.front());
    for (size_t i = 1; i < options.files.size(); i++) {
        const std::string &file = options.files[i];
        const toliman::periodogram more = load_state(file);
        once.check(more, file);
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
    CLI::App *command = app.add_subcommand("merge", kDescription);
    auto options = std::make_shared<Options>();
    command->add_option("STATES", options->files, "files of `toliman period --save-state`, or state folders")
        ->required();
    command->add_option("--out", options->out, "the file (.tlmp; - is standard output) or new folder")->required();
    command->add_flag("--salvage", options->salvage, "leave out what is damaged in a folder's ledger, and tell it");
    options->setup.add_to(*command);
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            merge(*options, progress);
        };
    });
}

} // namespace cli
