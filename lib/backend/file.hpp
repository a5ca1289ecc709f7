// POSIX files: whole reads, and writes that replace a file as a whole or not at all.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace toliman::file {

// All bytes of a regular file of at most `limit` bytes. Status::not_found if it cannot be read, Status::format if it is
// larger or empty.
std::vector<uint8_t> read(const std::string &path, size_t limit);

// The first `size` bytes of a regular file, or all of a shorter one. Status::not_found if it cannot be read,
// Status::format if it is empty.
std::vector<uint8_t> head(const std::string &path, size_t size);

// Writes a temporary beside path (path.0.tmp, or the next number that is free), syncs it and renames it over path, or
// over what path links to, then syncs the folder. The temporary is its owner's alone; whole, it takes the permissions
// of the file that it replaces, or those of any new file of this process. Status::write on any failure and for anything
// but a regular file; the old file then stands and nothing is left behind, except when the very last step, the folder's
// sync, fails: the new file then stands, but a power cut may bring back the old one.
void replace(const std::string &path, const void *data, size_t size);

// fchmod; true also on a file system that knows no permissions.
bool set_mode(int descriptor, unsigned mode) noexcept;

// Closes a new, still empty file to all others; `mode` is what it had, which tells the umask without changing it.
bool keep_private(int descriptor, unsigned &mode) noexcept;

} // namespace toliman::file
