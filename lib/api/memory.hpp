// Converts the caller's allocator to Memory (base/memory.hpp). A MemoryScope around the creation of an object makes its
// large arrays, including those in domain code that knows nothing of allocators, use it for their lifetime.
#pragma once
#include <toliman/base.h>

#include "api/accept.hpp"
#include "base/memory.hpp"

namespace toliman::api {

// NULL: the system's allocator.
inline Memory memory_of(const toliman_allocator *allocator) {
    if (allocator == nullptr)
        return {};
    check_struct_size("allocator", *allocator);
    if (allocator->allocate == nullptr || allocator->release == nullptr)
        fail(Status::argument, "{allocator->%s} is NULL", allocator->allocate == nullptr ? "allocate" : "release");
    if (allocator->reserved != 0)
        fail(Status::argument, "{allocator->reserved} = %u: must be 0", allocator->reserved);
    return {allocator->allocate, allocator->release, allocator->user_data};
}

inline Memory memory_of(const toliman_load_options *options) {
    const toliman_load_options known = accept(options, "options");
    return memory_of(known.allocator);
}

// The worker threads of a loaded object.
inline uint32_t threads_of(const toliman_load_options *options) {
    return accept(options, "options").threads;
}

} // namespace toliman::api
