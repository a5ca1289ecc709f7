// Exception firewall of the C interface: every exported function that can fail runs its body in guard(), which converts
// exceptions to status codes. Also the checks of pointers, arrays and struct sizes that C callers pass.
#pragma once
#include <cstdint>

#include <toliman/base.h>

#include "api/oldest.hpp"
#include "base/error.hpp"

namespace toliman::api {

// Status::unsupported unless the thread rounds to nearest, the default. Exact sums and array indices computed in
// floating point assume it: in another mode sums would be wrong and indices could leave their arrays.
void require_nearest();

// Call in a catch block: converts the current exception to a status code and sets the thread's last message.
toliman_status status_of_exception() noexcept;

// Runs body() and returns TOLIMAN_OK, or the status code of the exception that it throws.
template <class Body> toliman_status guard(Body &&body) noexcept {
    try {
        require_nearest();
        body();
        return TOLIMAN_OK;
    } catch (...) {
        return status_of_exception();
    }
}

// Throws the error of a call of the C interface again.
void check_again(toliman_status status);

// Returns the target of a pointer argument; Status::argument, naming the argument, for NULL.
template <class T> T &required(T *pointer, const char *name) {
    if (pointer == nullptr)
        fail(Status::argument, "{%s} is NULL", name);
    return *pointer;
}

inline void required(const void *pointer, const char *name) {
    if (pointer == nullptr)
        fail(Status::argument, "{%s} is NULL", name);
}

// Checks an array argument of `count` elements of `bytes` each: its size must be representable, and the pointer not
// NULL unless the array is empty.
inline void required_array(const void *pointer, size_t count, size_t bytes, const char *name) {
    if (count > PTRDIFF_MAX / bytes)
        fail(Status::range, "{%s}: %zu elements of %zu bytes: does not fit in memory", name, count, bytes);
    if (count > 0)
        required(pointer, name);
}

// Returns the position of an index in [0, count); Status::range, naming the argument, outside it.
inline size_t required_index(int64_t index, size_t count, const char *name) {
    const auto given = static_cast<long long>(index);
    if (count == 0)
        fail(Status::range, "{%s} = %lld: there is none", name, given);
    if (index < 0 || static_cast<uint64_t>(index) >= count)
        fail(Status::range, "{%s} = %lld: must be in [0, %zu]", name, given, count - 1);
    return static_cast<size_t>(index);
}

// Status::argument unless an array has the length that it must have; what: "the number of samples".
inline void check_count(const char *name, size_t given, size_t wanted, const char *what) {
    if (given != wanted)
        fail(Status::argument, "{%s} = %zu: must be %zu, %s", name, given, wanted, what);
}

// Runs work on the contents of a file and prefixes the messages of its errors with the path.
template <class Work> void in_file(const char *path, Work work) {
    try {
        work();
    } catch (const Error &error) {
        fail_within(error, error.status(), "{%s}: %s", path, error.what());
    }
}

// Struct-size negotiation: a caller sets struct_size to the size of the struct it was compiled with. The library
// accepts every size from the first published layout (kOldest) to its own. A larger struct is rejected, since its
// further members would be ignored silently.
void check_struct_size(const char *name, uint32_t given, size_t oldest, size_t current);
template <class T> void check_struct_size(const char *name, const T &given) {
    check_struct_size(name, given.struct_size, kOldest<T>, sizeof(T));
}

// Copies a result struct to the caller, truncated to the members that the caller's struct has.
template <class T> void deliver(const T &result, T *out, const char *name) {
    check_struct_size(name, required(out, name));
    const uint32_t size = out->struct_size;
    T whole = result;
    whole.struct_size = size;
    __builtin_memcpy(out, &whole, size);
}

// Checks an image argument: not NULL, and a stride of at least one row.
template <class T> T *required_image(T *image, size_t stride, size_t cols, const char *name) {
    required(image, name);
    if (stride < cols)
        fail(Status::argument, "{stride} of %s = %zu: must be at least %zu, the number of columns", name, stride, cols);
    return image;
}

} // namespace toliman::api
