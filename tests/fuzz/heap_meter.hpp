// Measures the cost of work: the peak of additional heap memory, and processor time. Replaces malloc and related
// functions in the whole program; to be included once.
#pragma once
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <ctime>
#include <malloc.h>

namespace meter {

inline std::atomic<size_t> held{0}, most{0};

inline void *allocated(void *memory) noexcept {
    const size_t now = held += memory != nullptr ? ::malloc_usable_size(memory) : 0;
    if (now > most)
        most = now;
    return memory;
}

inline void freed(void *memory) noexcept {
    held -= memory != nullptr ? ::malloc_usable_size(memory) : 0;
}

struct Cost {
    size_t bytes;
    double seconds;
};

// The minimum of three times, since other processes may be running.
template <class Work> Cost of(Work work) {
    Cost cost = {0, 1e9};
    for (int i = 0; i < 3; i++) {
        const size_t before = held;
        most = before;
        const std::clock_t start = std::clock();
        work();
        cost.seconds = std::min(cost.seconds, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
        cost.bytes = std::max(cost.bytes, most - before);
    }
    return cost;
}

} // namespace meter

extern "C" {
void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void *__libc_memalign(size_t, size_t);
void __libc_free(void *);

void *malloc(size_t size) {
    return meter::allocated(__libc_malloc(size));
}
void *calloc(size_t count, size_t size) {
    return meter::allocated(__libc_calloc(count, size));
}
void *realloc(void *memory, size_t size) {
    meter::freed(memory);
    return meter::allocated(__libc_realloc(memory, size));
}
void *memalign(size_t alignment, size_t size) {
    return meter::allocated(__libc_memalign(alignment, size));
}
void *aligned_alloc(size_t alignment, size_t size) {
    return meter::allocated(__libc_memalign(alignment, size));
}
int posix_memalign(void **out, size_t alignment, size_t size) {
    *out = meter::allocated(__libc_memalign(alignment, size));
    return *out != nullptr ? 0 : ENOMEM;
}
void free(void *memory) {
    meter::freed(memory);
    __libc_free(memory);
}
}
