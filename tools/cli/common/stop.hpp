// Signals: the program stops at the next opportunity or, during a long call of the library, after one second.
#pragma once
#include <functional>
#include <string>

#include "common/failure.hpp"

namespace cli {

constexpr int kPollTimeout = 1000; // ms, timeout of a wait: the longest delay until a signal is noticed

// Installs handlers for SIGINT, SIGTERM and SIGHUP (unless it is ignored, as by nohup) that only record the signal.
void watch_signals();
// The signal that was received, 0 if none, and its exit code.
int stop_signal() noexcept;
ExitCode stop_code() noexcept;
// Throws Failure with that exit code if a signal was received.
void stop_if_asked();

// Blocks these signals for a program that replaces this one, which unblocks them once it handles them. Throws Failure
// if one was received before.
void block_signals();

// While one exists, a signal that has not stopped the program after one second ends the process, with the message and
// the exit code of stop_if_asked(), from another thread. Not for work that the program saves after a signal, nor while
// it completes output files.
class StopLimit {
  public:
    // `message` outlives the object; that of the first of several is printed. Throws Failure if a signal was received.
    explicit StopLimit(const char *message = "stopped by a signal");
    ~StopLimit();
    StopLimit(const StopLimit &) = delete;
    StopLimit &operator=(const StopLimit &) = delete;
};

// Calls make() and returns its result. If it is true, make() has created this file or empty folder, which such an end
// of the process removes, the newest one first.
bool make_unfinished(const std::string &path, const std::function<bool()> &make);
// The file or folder is complete or was removed.
void end_unfinished(const std::string &path) noexcept;

// Starts an alarm every minute; alarm_expired() is true if there was one, or a SIGALRM, since its last call.
void set_alarm();
bool alarm_expired() noexcept;

} // namespace cli
