// Files that appear whole or not at all, and streams that are written straight through.
#pragma once
#include <cstdio>
#include <string>
#include <sys/types.h>
#include <vector>

namespace cli {

// What an output may replace without --force: files that content.hpp recognises as this program's, scenes too, or
// whatever its caller knows to be its own. Empty files may always be replaced.
enum class Replaces { results, scenes, anything };
// --force: from now on every output may replace any file.
void replace_anything() noexcept;

// Written beside `path` as `path`.0.tmp, or the next number that is free; commit() renames it, destruction without
// commit removes it. A symbolic link keeps standing and its target is replaced. "-" (standard output), a pipe or a
// device is written straight, but nothing to a terminal except scenes, which are text. Until then it is its owner's
// alone; it takes the permissions of the file that it replaces, or those of any new file of this process.
class OutputFile {
  public:
    explicit OutputFile(const std::string &path, Replaces what = Replaces::results);
    ~OutputFile();
    OutputFile(const OutputFile &) = delete;
    OutputFile &operator=(const OutputFile &) = delete;
    // Fails where numbers of so many bytes, in an array with these axes, find no room on the disk.
    void need_space(const std::vector<size_t> &axes, size_t width) const;
    void write(const void *data, size_t size);
    void print(const char *format, ...) __attribute__((format(printf, 2, 3)));
    // For a library that writes files by name: a name that is free and commit() will rename. Write nothing else then.
    std::string hand_over();
    [[noreturn]] void fail(const std::string &why) const;
    // Gives the descriptor back before commit(), for many files at once; write nothing else then.
    void close();
    void commit();

  private:
    [[noreturn]] void fail() const;
    int open_temporary(mode_t mode);
    bool keep_private() noexcept;
    void abandon() noexcept;
    std::string path_; // as messages name it
    bool is_stdout_;
    std::string target_, temporary_; // both empty when written straight; the second also once it is renamed
    mode_t mode_ = 0;                // permissions when whole
    std::FILE *file_;                // null when handed over or closed
};

// A folder for results, made if it is not there; a folder that was made is removed again unless kept.
class OutputFolder {
  public:
    explicit OutputFolder(const std::string &path);
    ~OutputFolder();
    OutputFolder(const OutputFolder &) = delete;
    OutputFolder &operator=(const OutputFolder &) = delete;
    std::string file(const std::string &name) const { return path_ + "/" + name; }
    void keep() noexcept { made_ = false; }

  private:
    std::string path_;
    bool made_;
};

// A Failure where the output is one of the inputs, by this or another name; - is standard output.
void check_apart(const std::string &output, const std::vector<std::string> &inputs);

// Fails now where an OutputFile would in the end; leaves nothing behind.
void check_output(const std::string &path);

// Data on stdout; a full disk is exit code 6, and so without a message is a pipe that its reader closed. A signal ends
// the waiting for a reader: what is not written then goes before the next text.
void print_stdout(const std::string &text);

} // namespace cli
