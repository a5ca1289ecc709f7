// A simulated disk with power cuts and failing calls. After a power cut, each sector that was written but not synced
// may or may not be on the disk.
#pragma once
#include <algorithm>
#include <cstring>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "backend/store.hpp"
#include "base/error.hpp"

namespace fault {

using Bytes = std::vector<uint8_t>;

struct PowerCut {};

// Synced contents of the disk, and the contents as seen through the page cache.
struct Disk {
    struct Write {
        uint64_t at;
        Bytes bytes; // empty: the file is truncated to `at`
    };
    struct File {
        Bytes synced, now;
        std::vector<Write> unsynced;
    };
    struct Rename {
        std::string from, to; // empty: a new file
        size_t file;
    };
    std::vector<File> files;
    std::map<std::string, size_t> synced_names, names;
    std::vector<Rename> unsynced_names;

    static void apply(std::map<std::string, size_t> &to, const Rename &rename) {
        to.erase(rename.from);
        to[rename.to] = rename.file;
    }

    static void apply(Bytes &to, const Write &write) {
        to.resize(write.bytes.empty() ? write.at : std::max<size_t>(to.size(), write.at + write.bytes.size()));
        std::copy(write.bytes.begin(), write.bytes.end(), to.begin() + static_cast<std::ptrdiff_t>(write.at));
    }

    // One of the states that a power cut may leave: any sectors of each unsynced write, any truncations, and the new
    // names and renames up to some moment.
    Disk after_power_cut(std::mt19937_64 &random) const {
        constexpr size_t kSector = 512;
        const double share = std::vector<double>{0, 1, 0.5, 0.9}[random() % 4];
        const auto kept = [&] { return std::uniform_real_distribution<double>(0, 1)(random) < share; };
        Disk disk;
        disk.synced_names = synced_names;
        const size_t renames = share == 0   ? 0
                               : share == 1 ? unsynced_names.size()
                                            : random() % (unsynced_names.size() + 1);
        for (size_t i = 0; i < renames; i++)
            apply(disk.synced_names, unsynced_names[i]);
        disk.names = disk.synced_names;
        for (const File &file : files) {
            Bytes left = file.synced;
            for (const Write &write : file.unsynced) {
                if (write.bytes.empty() && kept())
                    left.resize(write.at);
                for (size_t done = 0; done < write.bytes.size();) {
                    const size_t at = write.at + done,
                                 size = std::min(kSector - at % kSector, write.bytes.size() - done);
                    const uint8_t *sector = write.bytes.data() + done;
                    if (kept())
                        apply(left, {at, Bytes(sector, sector + size)});
                    done += size;
                }
            }
            disk.files.push_back({left, left, {}});
        }
        return disk;
    }
};

// A folder on such a disk. Power is cut at call number power_cut_at (from 0); call number failure_at fails.
class FakeStore final : public toliman::Store {
  public:
    explicit FakeStore(Disk &disk, long power_cut_at = -1, long failure_at = -1)
        : disk_(disk), power_cut_at_(power_cut_at), failure_at_(failure_at) {}

    // There is no other writer, so the lock is always granted; the call itself may fail.
    void lock(const std::string &) override { call(toliman::Status::write); }
    void check_unchanged(const std::string &name, uint64_t size) override {
        call(toliman::Status::write);
        const auto found = disk_.names.find(name);
        if (found == disk_.names.end() || disk_.files[found->second].now.size() != size)
            toliman::fail(toliman::Status::write, "disk/%s: was changed", name.c_str());
    }
    int64_t size(const std::string &name) override {
        call(toliman::Status::not_found);
        return disk_.names.count(name) != 0 ? static_cast<int64_t>(file(name).now.size()) : -1;
    }
    size_t read(const std::string &name, uint64_t at, void *data, size_t size) override {
        call(toliman::Status::not_found);
        const Bytes &now = file(name).now;
        const size_t there = at < now.size() ? std::min<size_t>(size, now.size() - at) : 0;
        if (there > 0)
            std::memcpy(data, now.data() + at, there);
        return there;
    }
    void create(const std::string &name) override {
        call(toliman::Status::write);
        make(name);
    }
    void discard(const std::string &) noexcept override {}
    void lock_created(const std::string &) override { call(toliman::Status::write); }
    void write(const std::string &name, uint64_t at, const void *data, size_t size) override {
        const auto *bytes = static_cast<const uint8_t *>(data);
        if (fails()) { // a partial write
            put(name, at, bytes, std::min(size, size / 2 + 7));
            refuse(toliman::Status::write);
        }
        put(name, at, bytes, size);
    }
    void truncate(const std::string &name, uint64_t size) override {
        call(toliman::Status::write);
        file(name).now.resize(size);
        file(name).unsynced.push_back({size, {}});
    }
    void sync(const std::string &name) override {
        const bool fail = fails();
        Disk::File &known = file(name);
        const std::vector<Disk::Write> writes = std::exchange(known.unsynced, {});
        if (fail) // the unsynced writes are lost, as in a page cache that marks failed pages clean
            refuse(toliman::Status::write);
        for (const Disk::Write &write : writes)
            Disk::apply(known.synced, write);
    }
    void rename(const std::string &from, const std::string &to) override {
        call(toliman::Status::write);
        const Disk::Rename change = {from, to, disk_.names.at(from)};
        disk_.unsynced_names.push_back(change);
        Disk::apply(disk_.names, change);
    }
    void sync_folder() override {
        call(toliman::Status::write);
        disk_.synced_names = disk_.names;
        disk_.unsynced_names.clear();
    }
    std::string path(const std::string &name) const override { return "disk/" + name; }

  private:
    bool fails() {
        if (calls_ == power_cut_at_)
            throw PowerCut();
        return calls_++ == failure_at_;
    }
    [[noreturn]] static void refuse(toliman::Status status) { toliman::fail(status, "disk: input/output error"); }
    void call(toliman::Status status) {
        if (fails())
            refuse(status);
    }
    Disk::File &file(const std::string &name) { return disk_.files.at(disk_.names.at(name)); }
    void make(const std::string &name) {
        const Disk::Rename change = {"", name, disk_.files.size()};
        disk_.files.emplace_back();
        disk_.unsynced_names.push_back(change);
        Disk::apply(disk_.names, change);
    }
    void put(const std::string &name, uint64_t at, const uint8_t *bytes, size_t size) {
        if (disk_.names.count(name) == 0)
            make(name);
        Disk::File &known = file(name);
        known.now.resize(std::max<size_t>(known.now.size(), at + size));
        std::copy_n(bytes, size, known.now.begin() + static_cast<ptrdiff_t>(at));
        known.unsynced.push_back({at, Bytes(bytes, bytes + size)});
    }

    Disk &disk_;
    long power_cut_at_, failure_at_, calls_ = 0;
};

} // namespace fault
