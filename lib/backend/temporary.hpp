// Temporary files and folders, from which a file or folder gets its content and its name at once: TARGET.0.tmp to
// TARGET.99.tmp. tools/cli compiles it too: no error.hpp, errors are in errno.
#pragma once
#include <string>
#include <sys/types.h>

namespace toliman::temporary {

constexpr int kMost = 100; // for one target

std::string name(const std::string &target, int number);

// Creates a file for writing, or a folder, of this name and locks it until the returned descriptor is closed. Negative
// on failure, and nothing is left: EEXIST if the name is in use.
int create_file(const std::string &path, mode_t mode) noexcept;
int create_folder(const std::string &path) noexcept;

// Locks a file that another library has created under this name, likewise.
int lock(const std::string &path) noexcept;

// Removes the temporary files, or folders of files, of a target that are not locked: their writers have died. Never one
// of a living writer. On a file system without locks all remain. False with errno if the folder cannot be searched.
enum class Kind { file, folder };
bool remove_stale(const std::string &target, Kind kind);

} // namespace toliman::temporary
