// The ledger's file: its header, and its lines as they are read (tools/docs/formats.md "TLML").
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "backend/store.hpp"
#include "track/columns.hpp"
#include "track/record.hpp"
#include "track/terms.hpp"

namespace toliman::track {

using EachLine = std::function<void(const Record &, uint64_t number)>;

class LedgerFile {
  public:
    static constexpr const char *kName = "ledger.tlml";
    static constexpr uint64_t kMostLines = uint64_t{1} << 30;
    size_t header_size() const noexcept { return header_size(columns_.count()); }
    size_t line_size() const noexcept { return track::line_size(columns_.count()); }
    uint64_t place_of(uint64_t number) const noexcept { return header_size() + number * line_size(); }
    uint32_t checksum_in(const uint8_t *line) const noexcept; // that stands at its end

    // Reads the header: Status::not_found, Status::format.
    explicit LedgerFile(Store &store);
    // Begins a file, whole and on the disk or not at all.
    static void begin(Store &store, const Terms &terms, const Columns &columns);

    const Terms &terms() const noexcept { return terms_; }
    const Columns &columns() const noexcept { return columns_; }
    uint64_t salt() const noexcept { return salt_; }
    // Status::mismatch unless they are the file's.
    void check_terms(const Terms &terms) const;
    // Lines that have their whole size.
    uint64_t count() const;
    uint64_t size() const;
    bool has_lines() const { return size() > header_size(); }

    // What the last line that was read says; to begin with, before line 0.
    struct Tail {
        uint32_t chain, synced;
    };
    Tail start() const noexcept { return {chain_, 0}; }
    // Hands out lines from `first` on as long as they are whole; returns the number of the first that is not, or end.
    uint64_t scan(uint64_t first, uint64_t end, Tail &tail, const EachLine &each) const;
    // Hands out every line that is whole, damaged ones left out; returns how many those are.
    uint64_t salvage(const EachLine &each) const;
    // Whether the disk had the line `bad`, which is not whole.
    bool had(uint64_t bad) const;
    void read(uint64_t number, void *line) const;
    // The record in a line that follows this checksum.
    Record record(const uint8_t *line, uint64_t number, Tail &tail) const;
    [[noreturn]] void refuse(uint64_t number, Status status, const char *why) const;
    std::string path() const { return store_->path(kName); }

  private:
    static size_t header_size(size_t columns) noexcept { return 124 + columns * Columns::kSavedSize; }
    void read_header(const std::vector<uint8_t> &bytes);
    bool decode(const uint8_t *line, uint64_t number, Tail &tail, Record &record) const;

    Store *store_;
    Terms terms_;
    Columns columns_;
    uint64_t salt_ = 0;
    uint32_t chain_ = 0; // the header's checksum
};

} // namespace toliman::track
