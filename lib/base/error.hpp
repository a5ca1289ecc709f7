// Errors inside the library: one exception type, thrown by fail() and turned into a status code at the C border.
#pragma once
#include <cstddef>
#include <cstdint>
#include <exception>

namespace toliman {

// Values equal TOLIMAN_OK and TOLIMAN_E_* of <toliman/base.h>; lib/api/base.cpp asserts it.
enum class Status : int32_t {
    ok = 0,
    internal = 1,
    argument = 2,
    memory = 3,
    not_found = 4,
    format = 5,
    scene = 6,
    unsupported = 7,
    write = 8,
    cancelled = 9,
    range = 10,
    mismatch = 11,
    capacity = 12,
    state = 13,
    lost = 14,
};

constexpr size_t kErrorTextSize = 1024;

// Carries its texts in place, so that throwing allocates nothing beyond the exception itself: one line each, control
// bytes shown as ?.
class Error final : public std::exception {
  public:
    Error(Status status, const char *text, const char *field) noexcept;
    Status status() const noexcept { return status_; }
    const char *what() const noexcept override { return text_; }
    const char *field() const noexcept { return field_; }

  private:
    Status status_;
    char text_[kErrorTextSize], field_[kErrorTextSize];
};

// Throws Error with a printf-formatted text. The text names the argument, its value and what is allowed. The field is
// the piece of the text that the format has in braces: fail(Status::argument, "{sigma} = %g: must be above 0", sigma).
[[noreturn]] void fail(Status status, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Throws what `inner` becomes where more is known: with another text, and its field unless it has none.
[[noreturn]] void fail_within(const Error &inner, Status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// Runs work on a frame; its complaints are prefixed by the frame's number.
template <class Work> void in_frame(size_t frame, Work work) {
    try {
        work();
    } catch (const Error &error) {
        fail_within(error, error.status(), "frame %zu: %s", frame, error.what());
    }
}

// Runs a callback of the caller. What it throws, if it is written in C++, cancels the call.
template <class Call> auto in_callback(const char *name, Call call) {
    try {
        return call();
    } catch (const std::exception &error) {
        fail(Status::cancelled, "the %s callback threw an exception: %s", name, error.what());
    } catch (...) {
        fail(Status::cancelled, "the %s callback threw an exception", name);
    }
}

// The calling thread's last message, and its field; set by the border only.
void set_last_error(const char *text, const char *field = "") noexcept;
const char *last_error() noexcept;
const char *last_error_field() noexcept;

} // namespace toliman
