// The border: every exported function that can fail runs through guard(), the one place where exceptions end.
#pragma once
#include <cstdint>

#include <toliman/base.h>

#include "api/oldest.hpp"
#include "base/error.hpp"

namespace toliman::api {

// Exact sums and the places of samples rest on rounding to nearest, in which every program starts; in another mode they
// would be wrong, and arrays be left.
void require_nearest();

// The exception at hand as a status code and the thread's last message.
toliman_status status_of_exception() noexcept;

// Runs body(); an exception becomes a status code.
template <class Body> toliman_status guard(Body &&body) noexcept {
    try {
        require_nearest();
        body();
        return TOLIMAN_OK;
    } catch (...) {
        return status_of_exception();
    }
}

// The reference behind a pointer argument, or an error that names it.
template <class T> T &required(T *pointer, const char *name) {
    if (pointer == nullptr)
        fail(Status::argument, "{%s} is NULL", name);
    return *pointer;
}

inline void required(const void *pointer, const char *name) {
    if (pointer == nullptr)
        fail(Status::argument, "{%s} is NULL", name);
}

// An array argument of `count` elements of `bytes` each: no more than memory can hold, and not NULL unless it is empty.
inline void required_array(const void *pointer, size_t count, size_t bytes, const char *name) {
    if (count > PTRDIFF_MAX / bytes)
        fail(Status::range, "{%s}: %zu elements of %zu bytes: does not fit in memory", name, count, bytes);
    if (count > 0)
        required(pointer, name);
}

// Runs work on what stands in a file; its complaints are prefixed by the name.
template <class Work> void in_file(const char *path, Work work) {
    try {
        work();
    } catch (const Error &error) {
        fail_within(error, error.status(), "{%s}: %s", path, error.what());
    }
}

// Checks the caller's struct_size against the smallest layout ever published for the struct and today's.
void check_struct_size(const char *name, uint32_t given, size_t oldest, size_t current);
template <class T> void check_struct_size(const char *name, const T &given) {
    check_struct_size(name, given.struct_size, kOldest<T>, sizeof(T));
}

// Copies a result struct to a caller who may know fewer members.
template <class T> void deliver(const T &result, T *out, const char *name) {
    check_struct_size(name, required(out, name));
    const uint32_t size = out->struct_size;
    T whole = result;
    whole.struct_size = size;
    __builtin_memcpy(out, &whole, size);
}

// The defaults to a caller who may know fewer members, or more: those become 0.
template <class T> void deliver_defaults(const T &defaults, T *options, size_t size) noexcept {
    if (options == nullptr || size < sizeof defaults.struct_size)
        return;
    __builtin_memset(static_cast<void *>(options), 0, size);
    __builtin_memcpy(static_cast<void *>(options), &defaults, size < sizeof defaults ? size : sizeof defaults);
    options->struct_size = static_cast<uint32_t>(size);
}

// The caller's options over the defaults; NULL gives the defaults.
template <class T> T accept(const T *options, const T &defaults, const char *name) {
    T known = defaults;
    if (options != nullptr) {
        check_struct_size(name, *options);
        __builtin_memcpy(&known, options, options->struct_size);
    }
    return known;
}

// An image argument: not NULL and a stride that holds a row.
template <class T> T *required_image(T *image, size_t stride, size_t cols, const char *name) {
    required(image, name);
    if (stride < cols)
        fail(Status::argument, "{stride} of %s = %zu: must be at least %zu, the row's length", name, stride, cols);
    return image;
}

} // namespace toliman::api
