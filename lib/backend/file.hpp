// POSIX files: reads of whole files, atomic replacement, and the folder of a path.
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

// Replaces a file atomically: writes a temporary file in the same folder (path.0.tmp, or the next free number), calls
// fsync, renames it over path, or over the target of a symbolic link, and calls fsync on the folder. While it is
// written, the temporary file is readable by its owner only; it then gets the permissions of the file that it replaces,
// or those of a new file under the umask. Status::write on any failure, and if path is not a regular file; the old file
// is then unchanged and the temporary file is removed. If only the last step, the fsync of the folder, fails, the new
// file is in place, but a power failure may restore the old one.
void replace(const std::string &path, const void *data, size_t size);

// Sets permissions; also true if the file system does not support them.
bool set_mode(int descriptor, unsigned mode) noexcept;

// Restricts a new, empty file to its owner. `mode` becomes its previous permissions, which contain the umask; umask()
// itself can only be read by setting it, for the whole process.
bool keep_private(int descriptor, unsigned &mode) noexcept;

} // namespace toliman::file
