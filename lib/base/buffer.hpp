// Aligned arrays: std::vector on 64-byte boundaries, so that vector loads never split a cache line. Memory comes from
// the allocator in effect where the array is constructed (base/memory.hpp).
#pragma once
#include <cstddef>
#include <limits>
#include <new>
#include <type_traits>
#include <vector>

#include "base/error.hpp"
#include "base/memory.hpp"

namespace toliman {

// Captures the memory in effect at construction; a copy captures the memory in effect when it is made.
template <class T> class AlignedAllocator {
  public:
    using value_type = T;
    using propagate_on_container_move_assignment = std::true_type;
    using propagate_on_container_swap = std::true_type;
    static constexpr size_t alignment = 64;
    AlignedAllocator() noexcept : memory_(current_memory()) {}
    template <class U> AlignedAllocator(const AlignedAllocator<U> &other) noexcept : memory_(other.memory()) {}
    AlignedAllocator select_on_container_copy_construction() const noexcept { return AlignedAllocator(); }
    T *allocate(size_t count) {
        if (count > (std::numeric_limits<size_t>::max() - alignment) / sizeof(T))
            throw std::bad_alloc();
        return static_cast<T *>(memory_.take(bytes(count), alignment));
    }
    void deallocate(T *memory, size_t count) noexcept { memory_.give_back(memory, bytes(count)); }
    const Memory &memory() const noexcept { return memory_; }
    template <class U> bool operator==(const AlignedAllocator<U> &other) const noexcept {
        return memory_ == other.memory();
    }
    template <class U> bool operator!=(const AlignedAllocator<U> &other) const noexcept { return !(*this == other); }

  private:
    static size_t bytes(size_t count) noexcept {
        const size_t rounded = (count * sizeof(T) + alignment - 1) / alignment * alignment;
        return rounded != 0 ? rounded : alignment;
    }
    Memory memory_;
};

template <class T> using Buffer = std::vector<T, AlignedAllocator<T>>;

// Leaves new elements of trivial type unset: a page of memory is not touched before it is written.
template <class T> class UnsetAllocator : public AlignedAllocator<T> {
  public:
    template <class U> struct rebind { using other = UnsetAllocator<U>; };
    using AlignedAllocator<T>::AlignedAllocator;
    template <class U> void construct(U *place) noexcept {
        static_assert(std::is_trivial_v<U>);
        ::new (static_cast<void *>(place)) U;
    }
};

template <class T> using UnsetBuffer = std::vector<T, UnsetAllocator<T>>;

// Returns a * b; Status::range, naming what is sized, on overflow.
inline size_t checked_product(size_t a, size_t b, const char *what) {
    if (a != 0 && b > std::numeric_limits<size_t>::max() / a)
        fail(Status::range, "{%s}: %zu x %zu does not fit in memory", what, a, b);
    return a * b;
}

} // namespace toliman
