// toliman merge: saved sums, or state folders, of several shards into one.
#include <fcntl.h>
#include <iterator>
#include <string_view>
#include <unistd.h>

#include "backend/descriptor.hpp"
#include "backend/temporary.hpp"
#include "downlink/setup_options.hpp"
#include "downlink/state_folder.hpp"
#include "options/command.hpp"
#include "scenes/scene_json.hpp"
#include "series/periodogram.hpp"

namespace cli {

namespace {

namespace temporary = toliman::temporary;

struct MergeOptions {
    std::vector<std::string> files;
    std::string out;
    bool salvage = false;
    SetupOptions setup;
};

constexpr uint32_t kMergedGroup = 65536; // records per fsync: nothing is lost with a folder that has no name yet
constexpr char kBounds[] = " (--value-bound, --sigma-floor, --sigma-ceiling of the run that made the first state)";

// Refuses a state that was given before, as the same file or as a copy: its samples would count twice. The same samples
// always have the same bytes, so a hash of the bytes identifies them.
void check_new(const toliman::periodogram &state, const std::string &file, std::map<size_t, std::string> &seen) {
    const std::vector<unsigned char> bytes = state_bytes(state);
    const std::string_view text(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    const auto [other, is_new] = seen.emplace(std::hash<std::string_view>()(text), file);
    if (!is_new && info_of(state).count > 0)
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

constexpr const char kLedger[] = "/ledger.tlml";
constexpr size_t kSaltOffset = 8, kSaltSize = 8, kLineSize = 64; // formats.md, TLML

// Each ledger has a random number, which its copies share.
void check_different(const std::vector<std::string> &folders) {
    std::map<std::string, std::string> seen;
    for (const std::string &folder : folders) {
        InputFile ledger(folder + kLedger);
        std::string salt(kSaltSize, '\0');
        ledger.seek(kSaltOffset);
        if (!ledger.read(salt.data(), salt.size()))
            throw Failure(kExitState, ledger.path() + ": is too short for a ledger");
        const auto [other, is_new] = seen.emplace(salt, folder);
        if (!is_new)
            malformed(folder, "has the same ledger as " + other->second);
    }
}

// A new state folder. It is made under a temporary name, and gets its own when it is complete. Removed again without
// commit(); the next merge into the same folder removes one that a killed process left.
class NewFolder {
  public:
    explicit NewFolder(const std::string &path) : path_(path) {
        if (exists(path_))
            fail("exists: give a new folder to merge into");
        const bool is_clean = temporary::remove_stale(path_, temporary::Kind::folder);
        for (int i = 0; i < temporary::kMost && is_clean && lock_ < 0; i++) {
            temporary_ = temporary::name(path_, i);
            lock_ = temporary::create_folder(temporary_);
            if (lock_ < 0 && errno != EEXIST)
                break;
        }
        if (lock_ < 0)
            fail(std::string("cannot be created: ") + std::strerror(errno));
    }
    ~NewFolder() {
        if (!temporary_.empty())
            remove_state(temporary_);
        ::close(lock_);
    }
    NewFolder(const NewFolder &) = delete;
    NewFolder &operator=(const NewFolder &) = delete;

    const std::string &made() const noexcept { return temporary_; }
    // Its files are on the disk. rename replaces an empty folder only, in which nothing is lost.
    void commit() {
        const toliman::Descriptor above(::open(folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
        if (above.get() < 0 || ::rename(temporary_.c_str(), path_.c_str()) != 0)
            fail(std::string("cannot be created: ") + std::strerror(errno));
        temporary_.clear();
        if (::fsync(above.get()) != 0)
            fail(std::string("was written, but fsync of its folder failed: ") + std::strerror(errno));
    }

  private:
    [[noreturn]] void fail(const std::string &why) const { throw Failure(kExitOutput, path_ + ": " + why); }
    std::string path_, temporary_;
    int lock_ = -1;
};

void merge_folder(const toliman::tracker &tracker, const std::string &folder, bool salvage) {
    int64_t lost = 0;
    const toliman_status status =
        toliman_track_merge(tracker.get(), folder.c_str(), salvage ? TOLIMAN_TRACK_SALVAGE : 0, &lost);
    if (status == TOLIMAN_E_MISMATCH)
        malformed(folder, toliman_last_error());
    const bool is_lost = status == TOLIMAN_E_LOST && toliman_last_error_field() == folder + kLedger;
    if (status == TOLIMAN_E_FORMAT || is_lost)
        throw Failure(kExitState, damage_text(status, folder));
    toliman::check(status);
    if (lost > 0)
        std::fprintf(stderr, "%s: %lld record%s damaged or lost\n", folder.c_str(), static_cast<long long>(lost),
                     lost == 1 ? " is" : "s are");
}

// Into a folder that must not exist yet; nothing is left of it after an error, and after a kill nothing under its name.
void merge_folders(MergeOptions &options, Progress &progress) {
    const std::string out = plain(options.out);
    SetupOptions &setup = options.setup;
    std::vector<std::string> folders;
    std::transform(options.files.begin(), options.files.end(), std::back_inserter(folders), plain);
    int64_t records = 1;
    toliman_track_options how = known_state(folders.front());
    for (const std::string &folder : folders) {
        known_state(folder);
        records += static_cast<int64_t>(InputFile(folder + kLedger).size() / kLineSize);
    }
    if (setup.has_grid() != setup.has_clock())
        throw Failure(kExitUsage, "merge: --clock and --grid or --mission-days: both, or the first folder's");
    const bool has_setup = setup.has_grid();
    if (setup.has_timing() && !has_setup)
        throw Failure(kExitUsage, "merge: --stamp and --exposure: only together with --clock and --grid");
    if (how.grid.nf == 0 && !setup.is_complete())
        throw Failure(kExitState, folders.front() + ": setup.tlms with grid and clock is lost: needs --clock and "
                                                    "--grid or --mission-days, and --stamp, with --exposure if it was "
                                                    "known");
    check_different(folders);
    NewFolder folder(out);
    how.folder = folder.made().c_str();
    how.ledger.capacity = std::min(records, int64_t{1} << 28);
    how.ledger.group = kMergedGroup;
    how.ledger.setup_folder = how.grid.nf > 0 ? folders.front().c_str() : nullptr;
    if (has_setup)
        setup.set(how, progress);
    toliman::tracker tracker = open_tracker(how, progress);
    for (const std::string &from : folders)
        merge_folder(tracker, from, options.salvage);
    toliman::check(toliman_track_save(tracker.get()));
    folder.commit();
    const toliman_track_info info = info_of(tracker);
    if (options.salvage && info.missing > 0)
        std::fprintf(stderr,
                     "%s: %lld frame id%s missing between the first and the last of a session, lost or never received: "
                     "`toliman status %s --missing`\n",
                     out.c_str(), static_cast<long long>(info.missing), info.missing == 1 ? " is" : "s are",
                     out.c_str());
    std::fprintf(stderr, "%s: %lld frames\n", out.c_str(), static_cast<long long>(info.accepted));
}

void merge_states(MergeOptions &options, Progress &progress) {
    for (const std::string &file : options.files)
        if (!exists(file))
            malformed(file, std::strerror(errno));
    const auto folders = std::count_if(options.files.begin(), options.files.end(), is_folder);
    if (folders > 0 && folders < static_cast<std::ptrdiff_t>(options.files.size()))
        throw Failure(kExitUsage, "merge: state folders and files of sums: give only one kind");
    if (options.files.size() < 2 && !options.salvage)
        refuse_single(options.files.front());
    if (folders > 0)
        return merge_folders(options, progress);
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
    std::fprintf(stderr, "%s: %lld samples\n", options.out.c_str(), static_cast<long long>(info_of(sum).count));
}

} // namespace

void add_merge(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "merge");
    auto options = std::make_shared<MergeOptions>();
    add_option(command, "STATES", options->files, "")->required();
    add_option(command, "--out", options->out, "PATH")->required();
    command->add_flag("--salvage", options->salvage);
    options->setup.add_to(*command);
    set_action(*command, context, options, merge_states);
}

} // namespace cli
