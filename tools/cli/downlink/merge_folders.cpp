#include "downlink/merge_folders.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <sys/stat.h>
#include <unistd.h>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/output.hpp"
#include "downlink/state_folder.hpp"

namespace cli {

namespace {

constexpr const char kLedger[] = "/ledger.tlml", kSetup[] = "/setup.tlms";
constexpr size_t kSaltOffset = 8, kSaltSize = 8, kLineSize = 64; // formats.md, TLML

std::string salt_of(const std::string &folder) {
    InputFile ledger(folder + kLedger);
    std::string salt(kSaltSize, '\0');
    ledger.seek(kSaltOffset);
    if (!ledger.read(salt.data(), salt.size()))
        throw Failure(kExitState, ledger.path() + ": is too short for a ledger");
    return salt;
}

// Each ledger has a random number, which its copies share.
void check_different(const std::vector<std::string> &folders) {
    std::map<std::string, std::string> seen;
    for (const std::string &folder : folders) {
        const auto [other, is_new] = seen.emplace(salt_of(folder), folder);
        if (!is_new)
            malformed(folder, "has the same ledger as " + other->second);
    }
}

// A new folder, which is removed again unless kept.
class NewFolder {
  public:
    explicit NewFolder(const std::string &path) : path_(path) {
        if (::mkdir(path.c_str(), 0777) != 0)
            throw Failure(kExitOutput,
                          path + (errno == EEXIST ? ": exists: give a new folder to merge into"
                                                  : std::string(": cannot be created: ") + std::strerror(errno)));
    }
    ~NewFolder() {
        if (kept_)
            return;
        remove_state(path_);
    }
    NewFolder(const NewFolder &) = delete;
    NewFolder &operator=(const NewFolder &) = delete;
    void keep() noexcept { kept_ = true; }

  private:
    std::string path_;
    bool kept_ = false;
};

} // namespace

void merge_folders(const std::vector<std::string> &given, const std::string &out, bool salvage, SetupOptions &setup,
                   Progress &progress) {
    std::vector<std::string> folders;
    folders.reserve(given.size());
    for (const std::string &folder : given)
        folders.push_back(plain(folder));
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
    if (how.nf == 0 && !has_setup)
        throw Failure(kExitState, folders.front() + ": setup.tlms with grid and clock is lost: needs --clock and "
                                                    "--grid or --mission-days");
    check_different(folders);
    NewFolder made(out);
    how.folder = out.c_str();
    how.capacity = std::min(records, int64_t{1} << 28);
    if (has_setup) {
        setup.set(how, progress);
    } else { // the ledger comes first, then the grid and clock of the first folder
        open_tracker(how, progress);
        ::unlink((out + kSetup).c_str());
        const std::string text = whole_text(folders.front() + kSetup);
        OutputFile copy(out + kSetup);
        copy.write(text.data(), text.size());
        copy.commit();
        how.nf = 0;
    }
    toliman::tracker tracker = open_tracker(how, progress);
    for (const std::string &folder : folders) {
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
    toliman::check(toliman_track_save(tracker.get()));
    made.keep();
    const toliman_track_info info = info_of(tracker);
    if (salvage && info.missing > 0)
        std::fprintf(stderr,
                     "%s: %lld frame id%s missing between the first and the last of a session, lost or never received: "
                     "`toliman status %s --missing`\n",
                     out.c_str(), static_cast<long long>(info.missing), info.missing == 1 ? " is" : "s are",
                     out.c_str());
    std::fprintf(stderr, "%s: %lld frames\n", out.c_str(), static_cast<long long>(info.accepted));
}

} // namespace cli
