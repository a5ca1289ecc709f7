// The head of every object behind an opaque pointer: its type, and the calls that use it at the moment.
//
// A call that changes the object excludes all others, const calls exclude only those. A call that does not get in
// fails; it never waits, so that a callback which uses its own object fails too instead of blocking for ever.
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

    // Status::argument for an object of another type or a destroyed one, as far as its memory still shows that;
    // Status::state if the calls that use it exclude this one.
    void begin(bool shared, const char *name) const {
        if (type_ != T::kType)
            fail(Status::argument, "{%s} is no %s, or was destroyed", name, T::kType);
        int32_t calls = calls_.load(std::memory_order_relaxed);
        do {
            if (calls < 0 || (calls > 0 && !shared))
                fail(Status::state, "{%s} is in use by another thread, or by the call that runs this callback", name);
        } while (!calls_.compare_exchange_weak(calls, shared ? calls + 1 : kExclusive, std::memory_order_acquire,
                                               std::memory_order_relaxed));
    }
    void end(bool shared) const noexcept {
        if (shared)
            calls_.fetch_sub(1, std::memory_order_release);
        else
            calls_.store(0, std::memory_order_release);
    }

  private:
    static constexpr int32_t kExclusive = -1;

    const void *unused_[2] = {};            // where the C library keeps its lists of freed memory
    const char *volatile type_ = T::kType;  // volatile: the destructor's store must stay
    mutable std::atomic<int32_t> calls_{0}; // const calls that run, or kExclusive
};

// Use of a handle for one call, until the end of the scope.
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

// An object that cannot be destroyed now is left as it is, with a message for toliman_last_error.
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
