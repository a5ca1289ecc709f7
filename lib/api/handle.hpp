// Base of every object behind an opaque pointer: a type tag against misuse, and a reader-writer count of running calls.
//
// A call that modifies the object excludes all others; const calls exclude only those. An excluded call fails with
// TOLIMAN_E_STATE and never waits: a callback that used the object of its own running call would otherwise deadlock.
// The count is one atomic integer: n > 0 const calls, or kExclusive.
//
// The type tag is the address of a static string. It detects a pointer to another type. After destruction it is NULL,
// which is seen only as long as the memory has not been reused: a debugging aid, not a guarantee. It follows two unused
// words because malloc implementations overwrite the beginning of a freed block with their list pointers.
#pragma once
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "api/guard.hpp"

namespace toliman::api {

template <class T> class Handle {
  public:
    Handle() noexcept = default;
    ~Handle() { type_ = nullptr; }

    // Begins a call. Status::argument for an object of another type or, as far as its memory still shows it, a
    // destroyed one; Status::state if running calls exclude this one.
    void begin(bool shared, const char *name) const {
        if (type_ != T::kType)
            fail(Status::argument, "{%s} is not a %s, or was destroyed", name, T::kType);
        int32_t calls = calls_.load(std::memory_order_relaxed);
        do {
            if (calls < 0 || (calls > 0 && !shared))
                fail(Status::state, "{%s} is in use by another thread or by the call that runs this callback", name);
        } while (!calls_.compare_exchange_weak(calls, shared ? calls + 1 : kExclusive, std::memory_order_acquire,
                                               std::memory_order_relaxed));
    }
    // Ends a call.
    void end(bool shared) const noexcept {
        if (shared)
            calls_.fetch_sub(1, std::memory_order_release);
        else
            calls_.store(0, std::memory_order_release);
    }

  private:
    static constexpr int32_t kExclusive = -1;

    const void *unused_[2] = {};            // overwritten by malloc's free lists
    const char *volatile type_ = T::kType;  // volatile: the destructor's store must not be optimised away
    mutable std::atomic<int32_t> calls_{0}; // number of running const calls, or kExclusive
};

// One call on a handle, from construction to the end of the scope. A pointer to const makes it a shared call.
template <class T> class Use {
  public:
    Use(T *handle, const char *name) : handle_(required(handle, name)) { handle_.begin(kShared, name); }
    ~Use() { handle_.end(kShared); }
    Use(const Use &) = delete;
    Use &operator=(const Use &) = delete;

    T *operator->() const noexcept { return &handle_; }
    T &operator*() const noexcept { return handle_; }

  private:
    static constexpr bool kShared = std::is_const_v<T>;
    T &handle_;
};

// Runs body(object) in guard(), as one call on the object.
template <class T, class Body> toliman_status call(T *handle, const char *name, Body &&body) noexcept {
    return guard([&] {
        const Use use(handle, name);
        body(*use);
    });
}

// Runs body(object, result) as one call on the object, and delivers the result, a public struct that begins empty.
template <class T, class Result, class Body>
toliman_status query(T *handle, const char *name, Result *out, Body &&body) noexcept {
    return call(handle, name, [&](auto &self) {
        check_struct_size("out", required(out, "out"));
        Result result = {};
        body(self, result);
        deliver(result, out, "out");
    });
}

// Deletes an object. An object in use is left unchanged and sets toliman_last_error, since destroy returns nothing.
template <class T> void destroy(T *handle) noexcept {
    if (handle == nullptr)
        return;
    try {
        handle->begin(false, T::kType);
    } catch (...) {
        status_of_exception();
        return;
    }
    delete handle;
}

} // namespace toliman::api
