// The files of one folder, as few calls as a crash-safe state needs: a test may stand in for them, to fail, to lose
// what was not synced and to reorder it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace toliman {

class Store {
  public:
    virtual ~Store() = default;
    // Size of a file, -1 if there is none; what is read next is of the file that was looked at. Names are plain ones
    // (base/name.hpp). Status::not_found where reading fails, Status::format where the file is shorter, Status::write
    // where writing fails, all with the path in the message.
    virtual int64_t size(const std::string &name) = 0;
    virtual void read(const std::string &name, uint64_t at, void *data, size_t size) = 0; // all of it, or an error
    virtual void write(const std::string &name, uint64_t at, const void *data, size_t size) = 0; // makes the file
    virtual void truncate(const std::string &name, uint64_t size) = 0;
    virtual void sync(const std::string &name) = 0; // what was written of this file is on the disk
    virtual void rename(const std::string &from, const std::string &to) = 0;
    virtual void sync_folder() = 0;                              // new and renamed files are
    virtual std::string path(const std::string &name) const = 0; // for messages
};

// Replaces a file as a whole or not at all, by a file beside it; on the disk when it returns.
void replace_whole(Store &store, const std::string &name, const void *data, size_t size);

enum class Access { read, write };

// The files of a folder on the disk. For writing the folder is made unless it exists, and locked against other writers:
// Status::state if one holds it, Status::not_found for reading from none.
std::unique_ptr<Store> open_folder(const std::string &path, Access access);

} // namespace toliman
