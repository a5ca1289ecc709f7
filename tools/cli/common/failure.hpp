// How the program ends: exit codes of the documentation and one clear line on stderr.
#pragma once
#include <functional>
#include <stdexcept>
#include <string>

#include <toliman/toliman.hpp>

namespace cli {

enum ExitCode {
    kExitOk = 0,
    kExitInternal = 1,
    kExitUsage = 2,    // options or scene content
    kExitInput = 3,    // an input file missing or malformed
    kExitRejected = 4, // finished, but samples or frames were rejected (--strict)
    kExitState = 5,    // a state folder is damaged and not recoverable
    kExitOutput = 6,   // an output cannot be written, or another process is writing to it
    kExitHungUp = 129, // 128 and the signal
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

// What some work came to: kExitOk, or the code and the reason of what it threw.
struct Ending {
    ExitCode code = kExitOk;
    std::string why;
};
Ending ending_of(const std::function<void()> &work);

} // namespace cli
