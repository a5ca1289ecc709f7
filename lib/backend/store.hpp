// The files of one folder, through the few operations that a crash-safe state needs. Tests substitute an implementation
// that fails, loses data that was not synced, and reorders writes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.hpp"

namespace toliman {

class Store {
  public:
    virtual ~Store() = default;
    // Locks a file against other writers until the store is destroyed; if the file does not exist yet, locks the
    // temporary file from which replace_whole creates it. Status::state if another writer holds the lock, Status::write
    // if locking fails.
    virtual void lock(const std::string &name) = 0;
    // Status::lost unless the opened file still has this name and this size.
    virtual void check_unchanged(const std::string &name, uint64_t size) = 0;
    // Size of a file, -1 if there is none. The file stays open: later reads are from the same file. For all functions:
    // names are plain (base/name.hpp); Status::not_found if reading fails, Status::write if writing fails,
    // Status::format if it is not a regular file, with the path in the message.
    virtual int64_t size(const std::string &name) = 0;
    // Returns the number of bytes read, fewer only at the end of the file.
    virtual size_t read(const std::string &name, uint64_t at, void *data, size_t size) = 0;
    virtual void create(const std::string &name) = 0; // empty, replacing one of that name
    // Locks a file just created, which will be renamed to a locked one. Status::write if locking fails.
    virtual void lock_created(const std::string &name) = 0;
    virtual void discard(const std::string &name) noexcept = 0; // removes a file that is not needed, if possible
    virtual void write(const std::string &name, uint64_t at, const void *data, size_t size) = 0; // creates the file
    virtual void truncate(const std::string &name, uint64_t size) = 0;
    virtual void sync(const std::string &name) = 0; // makes the file's contents durable (fdatasync)
    virtual void rename(const std::string &from, const std::string &to) = 0;
    virtual void sync_folder() = 0;                              // fsync: makes new and renamed files durable
    virtual std::string path(const std::string &name) const = 0; // for messages
};

// Reads exactly `size` bytes; Status::format if the file is shorter.
void read_all(Store &store, const std::string &name, uint64_t at, void *data, size_t size);

// Returns read(bytes) for a file of least to most bytes; nothing if there is none or if read throws Status::format or
// Status::argument.
template <class Read>
auto read_if_whole(Store &store, const std::string &name, size_t least, int64_t most, Read read)
    -> std::optional<std::invoke_result_t<Read, const std::vector<uint8_t> &>> {
    const int64_t size = store.size(name);
    if (size < static_cast<int64_t>(least) || size > most)
        return std::nullopt;
    std::vector<uint8_t> bytes(static_cast<size_t>(size));
    try {
        read_all(store, name, 0, bytes.data(), bytes.size());
        return read(bytes);
    } catch (const Error &error) {
        if (error.status() != Status::format && error.status() != Status::argument)
            throw;
        return std::nullopt;
    }
}

// Name of the temporary file that is written before it is renamed to `name`.
std::string temporary_of(const std::string &name);

// Replaces a file atomically and durably: temporary file, fsync, rename, fsync of the folder.
void replace_whole(Store &store, const std::string &name, const std::vector<uint8_t> &bytes);

enum class Access { read, write };

// Opens a folder of the file system. For writing it is created if necessary; for reading, Status::not_found if it does
// not exist.
std::unique_ptr<Store> open_folder(const std::string &path, Access access);

} // namespace toliman
