#include "common/job_journal.hpp"

#include <cerrno>
#include <cstring>
#include <unistd.h>

#include "backend/temporary.hpp"
#include "common/failure.hpp"

namespace cli {

void remove_journal(const std::string &path) {
    const int journal = toliman::temporary::lock(path);
    if (journal < 0 && errno == ENOENT)
        return;
    if (journal < 0 && errno == EEXIST)
        throw Failure(kExitOutput,
                      path + ": another process is writing to it: wait until it ends, or give another --out");
    const int reason = ::unlink(path.c_str()) == 0 ? 0 : errno;
    ::close(journal);
    if (reason != 0)
        throw Failure(kExitOutput, path + ": cannot be removed: " + std::strerror(reason));
}

void refuse_journal(const toliman::error &error) {
    const std::string why = error.what();
    switch (error.status()) {
    case TOLIMAN_E_MISMATCH:
        throw Failure(kExitUsage, why + "; without --resume it is replaced");
    case TOLIMAN_E_FORMAT:
        throw Failure(kExitInput, why);
    case TOLIMAN_E_WRITE:
    case TOLIMAN_E_STATE:
        throw Failure(kExitOutput, why + (error.status() == TOLIMAN_E_WRITE
                                              ? ": once this is possible, the same command with --resume continues"
                                              : ""));
    default:
        throw error;
    }
}

void write_and_remove(const std::string &journal, const std::function<void()> &write) {
    try {
        write();
    } catch (const Failure &failure) {
        throw Failure(failure.code(), failure.what() + (": the same command with --resume continues from " + journal));
    }
    remove_journal(journal);
}

} // namespace cli
