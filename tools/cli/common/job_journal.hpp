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

// An append-only file of lines, from which a stopped command resumes.
class JournalFile {
  public:
    // Opens or creates the file. Removes an incomplete last line, left by a process that died. Throws Failure if
    // another process writes to it.
    explicit JournalFile(const std::string &path);
    ~JournalFile(); // removes a new file without results
    JournalFile(const JournalFile &) = delete;
    JournalFile &operator=(const JournalFile &) = delete;

    const std::string &path() const noexcept { return path_; }
    // The lines at the time of opening; "" for a new file, which needs begin().
    const std::string &text() const noexcept { return text_; }
    // Writes the first lines of a new file, which are not a result.
    void begin(const std::string &lines);
    // Appends a result. It survives a crash of the process at once, and a failure of the machine after at most a
    // second.
    void add(const std::string &line);

  private:
    void append(const std::string &lines);

    std::string path_, text_;
    int file_;
    bool is_new_ = false; // without results
    std::chrono::steady_clock::time_point synced_;
};

} // namespace cli
