// Where aligned arrays come from: the system, or the caller of the API while an object is made.
#pragma once
#include <cstddef>

namespace toliman {

// Both functions or none (the system).
struct Memory {
    void *(*allocate)(size_t size, size_t alignment, void *user_data) = nullptr;
    void (*release)(void *memory, size_t size, void *user_data) = nullptr;
    void *user_data = nullptr;

    void *take(size_t size, size_t alignment) const; // Status::memory if there is none
    void give_back(void *memory, size_t size) const noexcept;
    bool operator==(const Memory &other) const noexcept {
        return allocate == other.allocate && release == other.release && user_data == other.user_data;
    }
};

// That of arrays which this thread makes by now.
const Memory &current_memory() noexcept;

// Until its end arrays of this thread come from there, and stay with it.
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
