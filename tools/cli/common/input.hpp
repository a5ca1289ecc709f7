// Input files that are read through stdio.
#pragma once
#include <cstdint>
#include <cstdio>
#include <string>
#include <sys/types.h>

namespace cli {

bool exists(const std::string &path);
bool is_folder(const std::string &path);
// Without slashes at its end.
std::string plain(std::string path);

// What tells whether a file of the same name is the same, and whether it grew.
struct FileStamp {
    FileStamp() = default;
    explicit FileStamp(const std::string &path); // a Failure if there is no such file
    bool operator==(const FileStamp &other) const noexcept {
        return inode == other.inode && size == other.size && changed_ns == other.changed_ns;
    }
    uint64_t inode = 0; // 0: none yet
    size_t size = 0;
    int64_t changed_ns = 0;
};
// By another file, or by other bytes: what only grew was not.
bool was_replaced(const FileStamp &before, const FileStamp &now) noexcept;

// An open regular file and its size; a Failure if there is none. Or standard input, whose size nobody knows.
class InputFile {
  public:
    explicit InputFile(const std::string &path);
    static InputFile standard_input() { return InputFile(); }
    ~InputFile();
    InputFile(const InputFile &) = delete;
    InputFile &operator=(const InputFile &) = delete;
    const std::string &path() const noexcept { return path_; }
    bool sized() const noexcept { return file_ != stdin; }
    size_t size() const noexcept { return size_; } // 0 of standard input
    void seek(size_t offset) noexcept { ::fseeko(file_, static_cast<off_t>(offset), SEEK_SET); }
    bool read(void *data, size_t size);       // false: the file has fewer bytes
    void read_known(void *data, size_t size); // a Failure if it has fewer, as once it was longer
    bool ended();                             // nothing is left; waits for standard input, as read does, until a signal

  private:
    InputFile() : path_("standard input"), file_(stdin) {}
    void check_input() const; // a Failure if reading failed
    std::string path_;        // as messages name it
    std::FILE *file_;
    size_t size_ = 0;
};

// All of a regular file.
std::string whole_text(const std::string &path);

} // namespace cli
