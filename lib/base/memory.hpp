// The allocator of aligned arrays: the system's, or the caller's while an object is being created.
#pragma once
#include <cstddef>

namespace toliman {

// A pair of functions; both NULL: the system's.
struct Memory {
    void *(*allocate)(size_t size, size_t alignment, void *user_data) = nullptr;
    void (*release)(void *memory, size_t size, void *user_data) = nullptr;
    void *user_data = nullptr;

    void *take(size_t size, size_t alignment) const; // allocates; Status::memory if memory is exhausted
    void give_back(void *memory, size_t size) const noexcept;
    bool operator==(const Memory &other) const noexcept {
        return allocate == other.allocate && release == other.release && user_data == other.user_data;
    }
};

// The allocator for arrays that this thread constructs now.
const Memory &current_memory() noexcept;

// Until the end of the scope, arrays constructed on this thread use this allocator, for their whole lifetime.
class MemoryScope {
  public:
    explicit MemoryScope(const Memory &memory) noexcept;
    ~MemoryScope();
    MemoryScope(const MemoryScope &) = delete;
    MemoryScope &operator=(const MemoryScope &) = delete;

  private:
    Memory before_;
};

} // namespace toliman
