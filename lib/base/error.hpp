// Errors inside the library: one exception type, thrown by fail() and converted to a status code by lib/api
// (guard.hpp).
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

// An error with its message and field in fixed arrays, so that throwing allocates nothing beyond the exception itself.
// Both are one line; control bytes are replaced by '?'.
class Error : public std::exception {
  public:
    Error(Status status, const char *text, const char *field) noexcept;
    Status status() const noexcept { return status_; }
    const char *what() const noexcept override { return text_; }
    const char *field() const noexcept { return field_; }

    // The same error of a member of a struct, whose name begins both texts.
    Error of_member(const char *prefix) const noexcept;

  private:
    Status status_;
    char text_[kErrorTextSize], field_[kErrorTextSize];
};

// Throws Error with a printf-formatted text that names the argument, its value and what is allowed. The piece of the
// format in braces becomes the field, which toliman_last_error_field returns; the braces are not printed:
// fail(Status::argument, "{sigma} = %g: must be above 0", sigma).
[[noreturn]] void fail(Status status, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Rethrows `inner` with more context: a new text, and the field of `inner`, or the piece in braces if `inner` has none.
[[noreturn]] void fail_within(const Error &inner, Status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// Runs work on a frame and prefixes the messages of its errors with the frame's number.
template <class Work> void in_frame(size_t frame, Work work) {
    try {
        work();
    } catch (const Error &error) {
        fail_within(error, error.status(), "frame %zu: %s", frame, error.what());
    }
}

// Runs a check whose messages begin with the name of a member, and prefixes the name: "options->grid.".
template <class Work> void in_struct(const char *prefix, Work work) {
    try {
        work();
    } catch (const Error &error) {
        throw error.of_member(prefix);
    }
}

// Runs a user-supplied callback. An exception from a callback written in C++ cancels the call. An Error is that of a
// callback of the library's own, which has called the user's.
template <class Call> auto in_callback(const char *name, Call call) {
    try {
        return call();
    } catch (const Error &) {
        throw;
    } catch (const std::exception &error) {
        fail(Status::cancelled, "the %s callback threw an exception: %s", name, error.what());
    } catch (...) {
        fail(Status::cancelled, "the %s callback threw an exception", name);
    }
}

// The calling thread's last message and its field; set by lib/api only.
void set_last_error(const char *text, const char *field = "") noexcept;
const char *last_error() noexcept;
const char *last_error_field() noexcept;

} // namespace toliman
