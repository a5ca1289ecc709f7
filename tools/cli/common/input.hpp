// Input files that are read through stdio.
#pragma once
#include <cstdio>
#include <memory>
#include <string>
#include <sys/types.h>

namespace cli {

bool exists(const std::string &path);
bool is_folder(const std::string &path);
// The path without trailing slashes.
std::string plain(std::string path);

struct CloseFile { // standard input stays open
    void operator()(std::FILE *file) const noexcept {
        if (file != stdin)
            std::fclose(file);
    }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

// An open regular file with its size (throws Failure if there is none), or standard input, whose size is unknown.
class InputFile {
  public:
    explicit InputFile(const std::string &path);
    static InputFile standard_input() { return InputFile(); }
    const std::string &path() const noexcept { return path_; }
    bool sized() const noexcept { return file_.get() != stdin; }
    size_t size() const noexcept { return size_; } // 0 for standard input
    void seek(size_t offset) noexcept { ::fseeko(file_.get(), static_cast<off_t>(offset), SEEK_SET); }
    bool read(void *data, size_t size); // false: the file has fewer bytes
    bool ended();                       // no bytes are left; blocks on standard input, like read, until a signal

  private:
    InputFile() : path_("standard input"), file_(stdin) {}
    void check_input() const; // throws Failure if reading failed
    std::string path_;        // the file's name in messages
    File file_;
    size_t size_ = 0;
};

// The whole content of a regular file.
std::string whole_text(const std::string &path);

} // namespace cli
