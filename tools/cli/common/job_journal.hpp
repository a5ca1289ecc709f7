// Journals, from which a stopped command resumes: those of the library ("TLMJ" in formats.md), and files of lines.
#pragma once
#include <chrono>

#include "common/common.hpp"

namespace cli {

// Removes a journal, if there is one. Throws Failure if another process writes to it.
void remove_journal(const std::string &path);

// An error of the library about a journal: its message, the remedy, and the exit code.
[[noreturn]] void refuse_journal(const toliman::error &error);

// Writes the results of work whose journal remains until then: a Failure names it. Removes it afterwards.
void write_and_remove(const std::string &journal, const std::function<void()> &write);

// A file that is appended to by one process at a time.
class AppendFile {
  public:
    // Opens or creates it. remedy: end of the message of the Failure if another process writes to it.
    AppendFile(const std::string &path, const std::string &remedy);
    ~AppendFile();
    AppendFile(const AppendFile &) = delete;
    AppendFile &operator=(const AppendFile &) = delete;

    const std::string &path() const noexcept { return path_; }
    int64_t size() const;
    void truncate(int64_t size);
    void write(const void *data, size_t size);
    void sync();

  private:
    [[noreturn]] void fail() const;

    std::string path_;
    int file_;
};

// An append-only file of lines, from which a stopped command resumes.
class JournalFile {
  public:
    // Opens or creates the file. Removes an incomplete last line, left by a process that died. Throws Failure if
    // another process writes to it.
    explicit JournalFile(const std::string &path);
    ~JournalFile(); // removes a new file without results
    JournalFile(const JournalFile &) = delete;
    JournalFile &operator=(const JournalFile &) = delete;

    const std::string &path() const noexcept { return file_.path(); }
    // The lines at the time of opening; "" for a new file, which needs begin().
    const std::string &text() const noexcept { return text_; }
    // Writes the first lines of a new file, which are not a result.
    void begin(const std::string &lines);
    // Appends a result. It survives a crash of the process at once, and a failure of the machine after at most a
    // second.
    void add(const std::string &line);

  private:
    void append(const std::string &lines);

    AppendFile file_;
    std::string text_;
    bool is_new_ = false; // without results
    std::chrono::steady_clock::time_point synced_;
};

} // namespace cli
