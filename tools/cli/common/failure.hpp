// Failures of the program: a documented exit code and one line on standard error.
#pragma once
#include <functional>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <utility>

#include <toliman/toliman.hpp>

namespace cli {

enum ExitCode {
    kExitOk = 0,
    kExitInternal = 1,
    kExitUsage = 2,    // options or scene content
    kExitInput = 3,    // an input file missing or malformed
    kExitRejected = 4, // finished, but samples or frames were skipped (--strict), a candidate is not a planet, or
                       // doctor is not ready
    kExitState = 5,    // a state folder is damaged and not recoverable
    kExitOutput = 6,   // an output cannot be written, or another process is writing to it
    kExitHungUp = 129, // 128 + signal number
    kExitInterrupted = 130,
    kExitTerminated = 143,
};

// One line of text, control bytes shown as ?.
class Failure : public std::runtime_error {
  public:
    Failure(ExitCode code, const std::string &text);
    ExitCode code() const noexcept { return code_; }

  private:
    ExitCode code_;
};

// An input file that cannot be used: exit code 3.
[[noreturn]] void malformed(const std::string &path, const std::string &why);

// Mistakes on the command line: whether each was made, and what is said of it. Throws Failure for the first one made.
using Mistakes = std::initializer_list<std::pair<bool, std::string>>;
void refuse_mistakes(Mistakes mistakes);

// Members of the library's options, and the options of the command line that set them.
using OptionNames = std::initializer_list<std::pair<const char *, const char *>>;

// The library's message about a member or argument, named as the user knows it.
std::string message_about(const std::string &name, const toliman::error &error);

// Failure of usage if the error is about a member of the library's options that is in the table.
void refuse_option(const toliman::error &error, OptionNames names);

// Result of some work: kExitOk, or the exit code and the message of the exception it threw.
struct Ending {
    ExitCode code = kExitOk;
    std::string why;
};
Ending ending_of(const std::function<void()> &work);

} // namespace cli
