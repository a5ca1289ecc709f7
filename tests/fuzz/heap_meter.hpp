// Measures the cost of work: the peak of additional heap memory, and processor time in user mode of the thread that
// does it, as the threads of OpenBLAS also spin without work. The time of the kernel is left out: it is mostly that of
// page faults, which virtual machines multiply, and the memory bounds it.
// Replaces malloc and related functions in the whole program; to be included once.
#pragma once
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <malloc.h>
#include <sys/resource.h>

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

inline double user_seconds() noexcept {
    rusage usage = {};
    getrusage(RUSAGE_THREAD, &usage);
    return static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

// The minimum of three times, since other processes may be running.
template <class Work> Cost of(Work work) {
    Cost cost = {0, 1e9};
    for (int i = 0; i < 3; i++) {
        const size_t before = held;
        most = before;
        const double start = user_seconds();
        work();
        cost.seconds = std::min(cost.seconds, user_seconds() - start);
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
