// Aligned arrays: std::vector on 64-byte boundaries, so that vector loads never split a cache line.
#pragma once
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <new>
#include <vector>

#include "base/error.hpp"

namespace toliman {

template <class T> struct AlignedAllocator {
    using value_type = T;
    static constexpr size_t alignment = 64;
    AlignedAllocator() noexcept = default;
    template <class U> AlignedAllocator(const AlignedAllocator<U> &) noexcept {}
    T *allocate(size_t count) {
        if (count > (std::numeric_limits<size_t>::max() - alignment) / sizeof(T))
            throw std::bad_alloc();
        const size_t bytes = (count * sizeof(T) + alignment - 1) / alignment * alignment;
        void *memory = std::aligned_alloc(alignment, bytes != 0 ? bytes : alignment);
        if (memory == nullptr)
            throw std::bad_alloc();
        return static_cast<T *>(memory);
    }
    void deallocate(T *memory, size_t) noexcept { std::free(memory); }
    template <class U> bool operator==(const AlignedAllocator<U> &) const noexcept { return true; }
    template <class U> bool operator!=(const AlignedAllocator<U> &) const noexcept { return false; }
};

template <class T> using Buffer = std::vector<T, AlignedAllocator<T>>;

// a * b, or an error that names what was being sized.
inline size_t checked_product(size_t a, size_t b, const char *what) {
    if (a != 0 && b > std::numeric_limits<size_t>::max() / a)
        fail(Status::range, "%s: %zu x %zu does not fit in memory", what, a, b);
    return a * b;
}

} // namespace toliman
