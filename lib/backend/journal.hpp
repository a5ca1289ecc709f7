// The journal of a long computation: results of its costly parts, from which the same computation continues after it
// was killed. formats.md, "TLMJ".
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace toliman {

class Journal {
  public:
    // What the results depend on, under the names of messages.
    struct Input {
        const char *name;
        uint64_t digest;
    };
    struct Record {
        uint64_t key = 0;
        std::vector<uint8_t> bytes;
    };

    // Opens an existing file and locks it; a new one is created with the first record. work: four letters.
    // Status::format for a file that is not a journal of this work, Status::mismatch for one with other inputs, of
    // which the message names the first, Status::state if another process writes to it.
    Journal(const std::string &path, const char *work, std::vector<Input> inputs);
    ~Journal();
    Journal(const Journal &) = delete;
    Journal &operator=(const Journal &) = delete;

    // The next record of an earlier process, NULL after the last one. One that is incomplete or damaged ends the file.
    const Record *next();
    void take(); // goes on to the record after it
    // Appends a record after those that were taken; all others are dropped. It survives a crash of the process at once,
    // and, if durable, a failure of the machine after at most a second. Status::write on failure: the records before
    // remain.
    void append(uint64_t key, const std::vector<uint8_t> &bytes, bool durable = true);
    // The end of the records that were taken or appended, and the return to an earlier one: the next append replaces
    // all records after it.
    uint64_t position() const noexcept { return at_; }
    void return_to(uint64_t position) noexcept;

  private:
    [[noreturn]] void fail_to_write() const;
    void check_header();
    void create();
    void sync();
    bool read_record(Record &record);

    std::string path_, work_;
    std::vector<Input> inputs_;
    int file_ = -1;
    uint64_t size_ = 0, at_ = 0; // of the file; of the end of the records that were taken
    std::optional<Record> next_;
    std::chrono::steady_clock::time_point synced_;
};

} // namespace toliman
