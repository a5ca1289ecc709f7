// POSIX files: reads of whole and of growing files, atomic replacement, and the folder of a path.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace toliman::file {

// The folder of a path: "." if it has none.
std::string folder_of(const std::string &path);

// Returns all bytes of a regular file of at most `limit` bytes. Status::not_found if it cannot be read, Status::format
// if it is larger or empty.
std::vector<uint8_t> read(const std::string &path, size_t limit);

// Returns the first `size` bytes of a regular file, or all of a shorter one. Status::not_found if it cannot be read,
// Status::format if it is empty.
std::vector<uint8_t> head(const std::string &path, size_t size);

// Identity, size and last change of a regular file.
struct Stamp {
    uint64_t inode = 0; // 0: never examined
    uint64_t size = 0;
    int64_t changed_ns = 0;

    bool operator==(const Stamp &other) const noexcept {
        return inode == other.inode && size == other.size && changed_ns == other.changed_ns;
    }
    // Whether `now` is another file, or the same one truncated or overwritten; growth is not a replacement.
    bool was_replaced(const Stamp &now) const noexcept {
        return inode != 0 && (now.inode != inode || now.size < size || (now.size == size && !(now == *this)));
    }
};

// Status::not_found if there is no such file.
Stamp stamp(const std::string &path);

// Whether the file still has this stamp. False if it does not exist, Status::not_found if it cannot be examined.
bool is_unchanged(const std::string &path, const Stamp &before);

// A regular file for reading at any position. Status::not_found if it cannot be opened or read.
class Reader {
  public:
    explicit Reader(const std::string &path);
    ~Reader();
    Reader(const Reader &) = delete;
    Reader &operator=(const Reader &) = delete;

    Stamp stamp() const;
    // Reads up to `size` bytes at `at`; fewer only at the end of the file. Returns their number.
    size_t read(uint64_t at, void *data, size_t size) const;
    // Reads exactly `size` bytes that stamp() has counted; Status::not_found if the file was truncated since.
    void read_exactly(uint64_t at, void *data, size_t size) const;

  private:
    std::string path_;
    int descriptor_;
};

// Replaces a file atomically: writes a temporary file in the same folder (temporary.hpp), calls fsync, renames it over
// path, or over the target of a symbolic link, and calls fsync on the folder. While it is written, the temporary file
// is readable by its owner only; it then gets the permissions of the file that it replaces, or those of a new file
// under the umask. Status::write on any failure, and if path is not a regular file; the old file is then unchanged and
// the temporary file is removed. If only the last step, the fsync of the folder, fails, the new file is in place, but a
// power failure may restore the old one.
void replace(const std::string &path, const void *data, size_t size);

// Sets permissions; also true if the file system does not support them.
bool set_mode(int descriptor, unsigned mode) noexcept;

// Restricts a new, empty file to its owner. `mode` becomes its previous permissions, which contain the umask; umask()
// itself can only be read by setting it, for the whole process.
bool keep_private(int descriptor, unsigned &mode) noexcept;

} // namespace toliman::file
