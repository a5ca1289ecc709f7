// The files of one folder, as few calls as a crash-safe state needs: a test may stand in for them, to fail, to lose
// what was not synced and to reorder it.
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
    // Locks a file against other writers until the store ends, or, while there is none, the temporary that
    // replace_whole makes of it. Status::state if another writer holds it, Status::write if it cannot be locked.
    virtual void lock(const std::string &name) = 0;
    // Status::write unless the file that is open here still has this name, and this size.
    virtual void check_unchanged(const std::string &name, uint64_t size) = 0;
    // Size of a file, -1 if there is none; what is read next is of the file that was looked at. Names are plain ones
    // (base/name.hpp). Status::not_found where reading fails, Status::write where writing fails, Status::format for
    // what is no regular file, with the path in the message.
    virtual int64_t size(const std::string &name) = 0;
    // Returns how many bytes there were, fewer only at the end of the file.
    virtual size_t read(const std::string &name, uint64_t at, void *data, size_t size) = 0;
    virtual void create(const std::string &name) = 0; // empty, in place of one of that name
    virtual void write(const std::string &name, uint64_t at, const void *data, size_t size) = 0; // makes the file
    virtual void truncate(const std::string &name, uint64_t size) = 0;
    virtual void sync(const std::string &name) = 0; // what was written of this file is on the disk
    virtual void rename(const std::string &from, const std::string &to) = 0;
    virtual void sync_folder() = 0;                              // new and renamed files are
    virtual std::string path(const std::string &name) const = 0; // for messages
};

// Status::format where the file is shorter.
void read_all(Store &store, const std::string &name, uint64_t at, void *data, size_t size);

// What read makes of all bytes of a file of least to most bytes; nothing if there is none or read finds it malformed.
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

// The name of the file that is made whole before it takes the name of another.
std::string temporary_of(const std::string &name);

// Replaces a file as a whole or not at all, by a file beside it; on the disk when it returns.
void replace_whole(Store &store, const std::string &name, const std::vector<uint8_t> &bytes);

enum class Access { read, write };

// The files of a folder on the disk. For writing the folder is made unless it exists; Status::not_found for reading
// from none.
std::unique_ptr<Store> open_folder(const std::string &path, Access access);

} // namespace toliman
