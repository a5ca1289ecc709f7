// Reads a ledger file: its header and its records (tools/docs/formats.md, "TLML").
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

using EachRecord = std::function<void(const Record &, uint64_t number)>;

class LedgerFile {
  public:
    static constexpr const char *kName = "ledger.tlml";
    static constexpr size_t kChunk = 1024; // records read or written at once
    static constexpr uint64_t kMaxRecords = uint64_t{1} << 29;
    size_t header_size() const noexcept { return header_size(columns_.count()); }
    size_t record_size() const noexcept { return track::record_size(columns_.count()); }
    uint64_t offset_of(uint64_t number) const noexcept { return header_size() + number * record_size(); }
    uint32_t checksum_in(const uint8_t *bytes) const noexcept; // stored at the end of a record

    // Reads the header: Status::not_found, Status::format.
    explicit LedgerFile(Store &store);
    // Creates an empty ledger atomically and durably.
    static void begin(Store &store, const Terms &terms, const Columns &columns);

    const Terms &terms() const noexcept { return terms_; }
    const Columns &columns() const noexcept { return columns_; }
    uint64_t salt() const noexcept { return salt_; }
    // Fails with Status::mismatch for other terms.
    void check_terms(const Terms &terms) const;
    // Number of records of full size, valid or not.
    uint64_t count() const;
    uint64_t size() const;
    bool has_records() const { return size() > header_size(); }

    // State of sequential reading: the last record's checksum, and the number of durable records that it states.
    struct Tail {
        uint32_t chain, synced;
    };
    Tail start() const noexcept { return {chain_, 0}; }
    // Passes valid records from number `first` to `each`, and appends their bytes to `kept` unless it is NULL. Returns
    // the number of the first invalid one, or `end`.
    uint64_t scan(uint64_t first, uint64_t end, Tail &tail, const EachRecord &each,
                  std::vector<uint8_t> *kept = nullptr) const;
    // Passes every valid record to `each` and skips damaged ones. Returns the number of those skipped.
    uint64_t salvage(const EachRecord &each) const;
    // Returns whether the invalid record `bad` had been fsync'ed, according to a later one.
    bool was_durable(uint64_t bad) const;
    void read(uint64_t number, void *bytes) const;
    // Decodes the record with this number, which follows `tail`. Status::format if it is damaged.
    Record record(const uint8_t *bytes, uint64_t number, Tail &tail) const;
    [[noreturn]] void fail_at(uint64_t number, Status status, const char *why) const;
    std::string path() const { return store_->path(kName); }

  private:
    static size_t header_size(size_t columns) noexcept { return 124 + columns * Columns::kSavedSize; }
    void read_header(const std::vector<uint8_t> &bytes);
    bool decode(const uint8_t *bytes, uint64_t number, Tail &tail, Record &record) const;

    Store *store_;
    Terms terms_;
    Columns columns_;
    uint64_t salt_ = 0;
    uint32_t chain_ = 0; // checksum of the header
};

// Writes a complete ledger that replaces the present one, whose lock moves to it.
class LedgerWriter {
  public:
    LedgerWriter(Store &store, const Terms &terms, const Columns &columns);
    ~LedgerWriter(); // removes the file unless it is finished
    LedgerWriter(const LedgerWriter &) = delete;
    LedgerWriter &operator=(const LedgerWriter &) = delete;
    void append(const Record &record);
    void finish(); // makes the file durable and gives it its name
    uint64_t salt() const noexcept { return salt_; }
    uint64_t count() const noexcept { return count_; } // records
    uint32_t chain() const noexcept { return chain_; } // checksum of the last record, or of the header

  private:
    void flush();
    Store &store_;
    std::string temporary_;
    size_t columns_;
    uint64_t salt_, at_ = 0, count_ = 0;
    uint32_t chain_;
    bool finished_ = false;
    std::vector<uint8_t> waiting_; // bytes
};

} // namespace toliman::track
