// An append-only file of lines, from which a stopped command resumes.
#pragma once
#include <chrono>
#include <string>

namespace cli {

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
