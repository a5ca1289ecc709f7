// A file in memory with a name, for functions that read files by name.
#pragma once
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

namespace fuzz {

class MemoryFile {
  public:
    // The name is a symbolic link in a temporary folder, valid as long as the program runs.
    explicit MemoryFile(const std::string &name = "") : file_(::memfd_create("fuzz", 0)) {
        path_ = "/proc/self/fd/" + std::to_string(file_);
        if (name.empty())
            return;
        link_ = folder() + "/" + name;
        std::filesystem::create_symlink(path_, link_);
        path_ = link_;
    }
    ~MemoryFile() {
        ::close(file_);
        if (!link_.empty())
            std::filesystem::remove(link_);
    }
    MemoryFile(const MemoryFile &) = delete;
    MemoryFile &operator=(const MemoryFile &) = delete;

    const std::string &path() const noexcept { return path_; }
    void set(const void *data, size_t size) {
        resize(0);
        if (::pwrite(file_, data, size, 0) != static_cast<ssize_t>(size))
            std::abort();
    }
    // Fills the file with zeros.
    void resize(size_t size) {
        if (::ftruncate(file_, static_cast<off_t>(size)) != 0)
            std::abort();
    }

  private:
    struct Folder {
        Folder() : path((std::filesystem::temp_directory_path() / "fuzz-XXXXXX").string()) {
            if (::mkdtemp(path.data()) == nullptr)
                std::abort();
        }
        ~Folder() { std::filesystem::remove_all(path); }
        std::string path;
    };
    static const std::string &folder() {
        static const Folder made;
        return made.path;
    }
    int file_;
    std::string path_, link_;
};

// The path of a file with this text, until the next call.
inline const std::string &path_of(const std::string &text) {
    static MemoryFile file;
    file.set(text.data(), text.size());
    return file.path();
}

} // namespace fuzz
