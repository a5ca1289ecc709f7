#include "report/gnuplot.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/failure.hpp"
#include "common/terminal.hpp"

namespace cli {

namespace {

constexpr int kFirstPicture = 3; // descriptors of the child, behind its standard ones

[[noreturn]] void fail(const std::string &why) {
    throw Failure(kExitInternal, "gnuplot: " + why);
}

// A file without a name, above the descriptors that the child gets.
class MemoryFile {
  public:
    explicit MemoryFile(int lowest) {
        const int made = ::memfd_create("toliman", MFD_CLOEXEC);
        if (made < 0)
            fail(std::strerror(errno));
        descriptor_ = ::fcntl(made, F_DUPFD_CLOEXEC, lowest);
        const int reason = errno == EINVAL ? EMFILE : errno; // `lowest` itself is above the limit
        ::close(made);
        if (descriptor_ < 0)
            fail(std::strerror(reason));
    }
    MemoryFile(int lowest, const std::string &bytes) : MemoryFile(lowest) {
        for (size_t done = 0; done < bytes.size();) {
            const ssize_t written = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
            if (written < 0 && errno != EINTR)
                fail(std::strerror(errno));
            done += written > 0 ? static_cast<size_t>(written) : 0;
        }
        ::lseek(descriptor_, 0, SEEK_SET);
    }
    MemoryFile(MemoryFile &&other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
    MemoryFile &operator=(MemoryFile &&) = delete;
    ~MemoryFile() {
        if (descriptor_ >= 0)
            ::close(descriptor_);
    }
    int descriptor() const noexcept { return descriptor_; }

    std::string bytes() const {
        std::string all(static_cast<size_t>(::lseek(descriptor_, 0, SEEK_END)), '\0');
        size_t done = 0;
        while (done < all.size()) {
            const ssize_t got = ::pread(descriptor_, all.data() + done, all.size() - done, static_cast<off_t>(done));
            if (got <= 0)
                fail("its output cannot be read");
            done += static_cast<size_t>(got);
        }
        return all;
    }

  private:
    int descriptor_ = -1;
};

class FileActions {
  public:
    FileActions() { ::posix_spawn_file_actions_init(&actions_); }
    ~FileActions() { ::posix_spawn_file_actions_destroy(&actions_); }
    FileActions(const FileActions &) = delete;
    FileActions &operator=(const FileActions &) = delete;
    void give(const MemoryFile &file, int as) {
        if (::posix_spawn_file_actions_adddup2(&actions_, file.descriptor(), as) != 0)
            fail("no memory");
    }
    const posix_spawn_file_actions_t *get() const noexcept { return &actions_; }

  private:
    posix_spawn_file_actions_t actions_ = {};
};

pid_t spawn(const FileActions &actions) {
    char program[] = "gnuplot", defaults[] = "--default-settings"; // not what the user's own files set
    char *arguments[] = {program, defaults, nullptr};
    pid_t child = 0;
    const int reason = ::posix_spawnp(&child, program, actions.get(), nullptr, arguments, environ);
    if (reason == ENOENT)
        throw Failure(kExitInternal, "gnuplot, which draws the figures, is not installed: apt-get install gnuplot-nox");
    if (reason != 0)
        fail(std::strerror(reason));
    return child;
}

int ended(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            fail(std::strerror(errno));
    stop_if_asked(); // the signal may have met the child too
    return status;
}

// The last line that names a mistake; there may be warnings before and after.
std::string complaint(const std::string &errors) {
    std::string found = "failed";
    for (size_t at = 0, end = 0; at < errors.size(); at = end + 1) {
        end = std::min(errors.find('\n', at), errors.size());
        const std::string line = errors.substr(at, end - at);
        const size_t start = line.find("line ");
        if (start != std::string::npos && line.find("warning") == std::string::npos)
            found = line.substr(start);
    }
    return found;
}

} // namespace

std::string picture_name(size_t i) {
    return "/dev/fd/" + std::to_string(static_cast<size_t>(kFirstPicture) + i);
}

std::string drawn(const std::string &script, const std::vector<std::string> &pictures) {
    const int lowest = kFirstPicture + static_cast<int>(pictures.size());
    const MemoryFile in(lowest, script), out(lowest), errors(lowest);
    std::vector<MemoryFile> files;
    FileActions actions;
    actions.give(in, STDIN_FILENO);
    actions.give(out, STDOUT_FILENO);
    actions.give(errors, STDERR_FILENO);
    for (size_t i = 0; i < pictures.size(); i++) {
        files.emplace_back(lowest, pictures[i]);
        actions.give(files.back(), kFirstPicture + static_cast<int>(i));
    }
    const int status = ended(spawn(actions));
    std::string drawing = out.bytes();
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || drawing.empty())
        fail(complaint(errors.bytes()));
    return drawing;
}

} // namespace cli
