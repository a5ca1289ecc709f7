// Method: a signal handler records the signal, and the program stops where it checks for one: between chunks of frames
// and in callbacks of the library. Some calls of the library take seconds and have no callback (derivatives, frames of
// stars that follow their orbit). A thread therefore waits for the handler, and a second later removes the unfinished
// files and ends the process by _exit(2), unless the program has left the region of a StopLimit. One mutex guards all
// of this: the process never ends between the creation of a file and its registration.
#include "common/stop.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <mutex>
#include <semaphore.h>
#include <sys/time.h>
#include <system_error>
#include <thread>
#include <unistd.h>

#include "common/common.hpp"

namespace cli {

namespace {

constexpr std::chrono::seconds kGrace{1};
constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

std::atomic<int> stop_request{0}, alarm_flag{0};
static_assert(std::atomic<int>::is_always_lock_free, "signal handlers use them");
sem_t signalled;
bool is_watched = false; // the handlers are installed

std::mutex mutex;                    // of the following
int limits = 0;                      // number of StopLimits
const char *limit_message = nullptr; // of the first of them
std::vector<std::string> unfinished; // files and folders, in the order of their creation
bool is_guarded = false;             // the thread runs

void record_signal(int signal) {
    const int reason = errno;
    stop_request = signal;
    ::sem_post(&signalled);
    errno = reason;
}

void record_alarm(int) {
    alarm_flag = 1;
}

void end_process() {
    std::for_each(unfinished.rbegin(), unfinished.rend(), [](const std::string &path) { std::remove(path.c_str()); });
    const std::string erased = ::isatty(STDERR_FILENO) != 0 ? "\r\033[K" : ""; // the progress line
    const std::string text = erased + "toliman: " + limit_message + "\n";
    if (::write(STDERR_FILENO, text.data(), text.size()) < 0) { // nobody reads it
    }
    ::_exit(stop_code());
}

void guard() {
    while (::sem_wait(&signalled) != 0) {
    }
    std::this_thread::sleep_for(kGrace);
    const std::lock_guard<std::mutex> lock(mutex);
    if (limits > 0) // otherwise the next StopLimit throws
        end_process();
}

// Signals are left to the other threads, whose system calls they interrupt.
void start_guard() {
    if (!is_watched || is_guarded)
        return;
    is_guarded = true;
    sigset_t all, before;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, &before);
    try {
        std::thread(guard).detach();
    } catch (const std::system_error &) { // no more threads available: the program stops when it asks for it
    }
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

} // namespace

void watch_signals() {
    ::sem_init(&signalled, 0, 0);
    struct sigaction action = {}, hangup = {};
    action.sa_handler = record_signal;
    ::sigaction(SIGHUP, nullptr, &hangup);
    for (const int signal : kSignals)
        if (signal != SIGHUP || hangup.sa_handler != SIG_IGN)
            ::sigaction(signal, &action, nullptr);
    // A closed pipe and a file beyond the size limit are then write errors with a message.
    ::signal(SIGPIPE, SIG_IGN);
    ::signal(SIGXFSZ, SIG_IGN);
    is_watched = true;
}

int stop_signal() noexcept {
    return stop_request;
}

ExitCode stop_code() noexcept {
    return static_cast<ExitCode>(128 + stop_request); // the convention of shells
}

void stop_if_asked() {
    if (stop_request != 0)
        throw Failure(stop_code(), "stopped by a signal");
}

void block_signals() {
    sigset_t signals;
    ::sigemptyset(&signals);
    for (const int signal : kSignals)
        ::sigaddset(&signals, signal);
    ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    stop_if_asked();
}

StopLimit::StopLimit(const char *message) {
    const std::lock_guard<std::mutex> lock(mutex);
    stop_if_asked();
    start_guard();
    if (limits++ == 0)
        limit_message = message;
}

StopLimit::~StopLimit() {
    const std::lock_guard<std::mutex> lock(mutex);
    limits--;
}

bool make_unfinished(const std::string &path, const std::function<bool()> &make) {
    const std::lock_guard<std::mutex> lock(mutex);
    unfinished.reserve(unfinished.size() + 1);
    std::string name = path; // before the file exists: it may fail
    const bool made = make();
    if (made)
        unfinished.push_back(std::move(name));
    return made;
}

void end_unfinished(const std::string &path) noexcept {
    const std::lock_guard<std::mutex> lock(mutex);
    unfinished.erase(std::remove(unfinished.begin(), unfinished.end(), path), unfinished.end());
}

void set_alarm() {
    struct sigaction action = {};
    action.sa_handler = record_alarm;
    action.sa_flags = SA_RESTART; // it interrupts no write
    ::sigaction(SIGALRM, &action, nullptr);
    itimerval minute = {};
    minute.it_interval.tv_sec = minute.it_value.tv_sec = 60;
    ::setitimer(ITIMER_REAL, &minute, nullptr);
}

bool alarm_expired() noexcept {
    return alarm_flag.exchange(0) != 0;
}

} // namespace cli
