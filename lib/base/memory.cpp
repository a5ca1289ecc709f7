// Method: the allocator is a thread-local value that lib/api sets for the duration of a create, load or copy. Arrays
// capture it when constructed and keep it for their lifetime, so that domain code needs no allocator parameters.
#include "base/memory.hpp"

#include <cstdlib>

#include "base/error.hpp"

#include "base/error.hpp"

namespace toliman {

namespace {

thread_local Memory current;

} // namespace

void *Memory::take(size_t size, size_t alignment) const {
    void *memory = allocate != nullptr ? in_callback("allocate", [&] { return allocate(size, alignment, user_data); })
                                       : std::aligned_alloc(alignment, size);
    if (memory == nullptr)
        fail(Status::memory, "out of memory: cannot allocate %zu bytes", size);
    return memory;
}

void Memory::give_back(void *memory, size_t size) const noexcept {
    if (release != nullptr)
        release(memory, size, user_data);
    else
        std::free(memory);
}

const Memory &current_memory() noexcept {
    return current;
}

MemoryScope::MemoryScope(const Memory &memory) noexcept : before_(current) {
    current = memory;
}

MemoryScope::~MemoryScope() {
    current = before_;
}

} // namespace toliman
