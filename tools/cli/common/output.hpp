// Output files that appear whole or not at all, and streams that are written directly.
#pragma once
#include <cstdio>
#include <functional>
#include <map>
#include <string>
#include <sys/types.h>
#include <vector>

#include "common/input.hpp"

namespace cli {

// What an output may replace without --force: files that content.hpp recognises as this program's, or these and scenes.
// Empty files may always be replaced.
enum class Replaces { results, scenes };
// --force: from now on every output may replace any file.
void replace_anything() noexcept;

// Written as `path`.0.tmp, or with the next free number; commit() renames it, destruction without commit removes it,
// and the next OutputFile of this path removes what a killed process left. The target of a symbolic link is replaced,
// not the link. "-" (standard output), a pipe or a device is written directly; only scenes, which are text, may go to a
// terminal. Until commit() only the owner can access the temporary file; then it gets the permissions of the file that
// it replaces, or those of a new file of this process.
class OutputFile {
  public:
    explicit OutputFile(const std::string &path, Replaces what = Replaces::results);
    ~OutputFile() { abandon(); }
    // Throws Failure if the disk has no space for an array with these axes and `width` bytes per number.
    void need_space(const std::vector<size_t> &axes, size_t width) const;
    void write(const void *data, size_t size);
    // Text, or a vector of numbers.
    template <class Sequence> void write(const Sequence &data) { write(data.data(), data.size() * sizeof data[0]); }
    // For a library that writes files by name: returns an unused name, which commit() will rename. Do not call write
    // then.
    std::string hand_over();
    // Then, once the library has created the file: marks it as that of a living writer.
    void take_back();
    [[noreturn]] void fail(const std::string &why) const;
    // Brings what was written to the disk; only the rename by commit() can then fail.
    void finish();
    void commit();
    // Removes the file that commit() will replace.
    void retract();

  private:
    [[noreturn]] void fail() const;
    int open_temporary(bool replaces, Replaces what);
    void abandon() noexcept;
    std::string path_; // the file's name in messages
    bool is_stdout_;
    std::string target_, temporary_; // both empty if written directly; temporary_ also after the rename
    mode_t mode_ = 0;                // permissions after commit()
    File file_;                      // null if handed over
};

// Files of results that agree.
class OutputFiles {
  public:
    // prefix: of the path of each file, before its name.
    explicit OutputFiles(const std::string &prefix) : prefix_(prefix) {}
    std::string file(const std::string &name) const { return prefix_ + name; }
    // A new file of this name, or the same as before.
    OutputFile &open(const std::string &name, Replaces what = Replaces::results);
    // The file of this name, which was opened, is not to be: commit() removes one of earlier results.
    void remove(const std::string &name);
    // Commits all open files: none is renamed before all are on the disk, and the file `last`, which implies that the
    // others are complete, is absent until they are and write_others() has returned.
    void commit(
        const std::string &last, const std::function<void()> &write_others = [] {});

  protected:
    std::map<std::string, OutputFile> files_;

  private:
    std::string prefix_;
    std::vector<std::string> removed_; // paths
};

// Those of a folder, created if it does not exist; a created folder is removed again unless its files are committed or
// keep() is called.
class OutputFolder : public OutputFiles {
  public:
    explicit OutputFolder(const std::string &path);
    // The same, with files that are opened at once, so that one that cannot be written fails before the work.
    OutputFolder(const std::string &path, const std::vector<const char *> &names);
    ~OutputFolder();
    void commit(const std::string &last);
    void keep() noexcept;

  private:
    std::string path_;
    bool made_;
};

// Values of one name, [rows].
struct Column {
    std::string name;
    const std::vector<double> *values;
};
// CSV: `mark`, the names, and a line for each value of the first column, with 17 digits.
void write_csv(OutputFile &out, const std::string &mark, const std::vector<Column> &columns);

// Throws Failure if the output is one of the inputs, also under another name; - is standard output.
void check_not_input(const std::string &output, const std::vector<std::string> &inputs);

// Throws Failure if an OutputFile could not be written; leaves nothing behind.
void check_output(const std::string &path);

// Writes data to standard output. Exit code 6 for a full disk and, without a message, for a pipe that its reader has
// closed. A signal ends the wait for a reader; unwritten text is then written before the next text.
void print_stdout(const std::string &text);

} // namespace cli
