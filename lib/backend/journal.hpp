// The journal of a long computation: results of its costly parts, from which the same computation continues after it
// was killed. formats.md, "TLMJ".
#pragma once
#include <cstdint>
#include <exception>
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
    // which the message names the first, Status::state if another process writes to it, Status::write if it cannot be
    // opened, read or locked.
    Journal(const std::string &path, const char *work, std::vector<Input> inputs);
    ~Journal();
    Journal(const Journal &) = delete;
    Journal &operator=(const Journal &) = delete;

    // The next record of an earlier process, NULL after the last one. One that is incomplete or damaged ends the file.
    // Status::write if it cannot be read: nothing is then overwritten.
    const Record *next();
    void take(); // goes on to the record after it
    // Appends a record after those that were taken; all others are dropped. It survives the end of the process, and, if
    // durable, a failure of the machine; so do all before it. Status::write on failure, Status::state if another
    // process has meanwhile created the file: the records before remain, and all further calls fail likewise.
    void append(uint64_t key, const std::vector<uint8_t> &bytes, bool durable = true);
    // The end of the records that were taken or appended, and the return to an earlier one: the next append replaces
    // all records after it.
    uint64_t position() const noexcept { return at_; }
    void return_to(uint64_t position) noexcept;

  private:
    [[noreturn]] void fail_to_write() const;
    void lock();
    void open();
    void check_header();
    void create();
    void write(uint64_t key, const std::vector<uint8_t> &bytes, bool durable);
    size_t read(uint64_t at, uint8_t *data, size_t size) const;
    bool read_record(Record &record);

    std::string path_;
    std::vector<Input> inputs_;
    std::vector<uint8_t> header_;
    int file_ = -1;
    uint64_t size_ = 0, at_ = 0; // of the file; of the end of the records that were taken
    std::exception_ptr failure_; // of a write: that of all further calls
    std::optional<Record> next_;
};

} // namespace toliman
