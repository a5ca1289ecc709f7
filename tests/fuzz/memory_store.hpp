// The files of a folder, in memory.
#pragma once
#include <algorithm>
#include <cstring>
#include <map>

#include "backend/store.hpp"
#include "fuzz.hpp"

namespace fuzz {

using Files = std::map<std::string, Bytes>;

class MemoryStore final : public toliman::Store {
  public:
    explicit MemoryStore(Files &files) : files_(files) {}
    void lock(const std::string &) override {}
    void check_unchanged(const std::string &name, uint64_t size) override {
        require(files_.at(name).size() == size, "the tracker does not know the size of its file");
    }
    int64_t size(const std::string &name) override {
        const auto found = files_.find(name);
        return found != files_.end() ? static_cast<int64_t>(found->second.size()) : -1;
    }
    size_t read(const std::string &name, uint64_t at, void *data, size_t size) override {
        const Bytes &bytes = files_.at(name);
        const size_t there = at < bytes.size() ? std::min<size_t>(size, bytes.size() - at) : 0;
        if (there > 0)
            std::memcpy(data, bytes.data() + at, there);
        return there;
    }
    void create(const std::string &name) override { files_[name].clear(); }
    void discard(const std::string &name) noexcept override { files_.erase(name); }
    void lock_created(const std::string &) override {}
    void write(const std::string &name, uint64_t at, const void *data, size_t size) override {
        Bytes &bytes = files_[name];
        bytes.resize(std::max<size_t>(bytes.size(), at + size));
        if (size > 0)
            std::memcpy(bytes.data() + at, data, size);
    }
    void truncate(const std::string &name, uint64_t size) override { files_[name].resize(size); }
    void sync(const std::string &) override {}
    void rename(const std::string &from, const std::string &to) override {
        files_[to] = std::move(files_.at(from));
        files_.erase(from);
    }
    void sync_folder() override {}
    std::string path(const std::string &name) const override { return name; }

  private:
    Files &files_;
};

} // namespace fuzz
