/* Counts the bytes that a program requests from malloc and aligned_alloc. To be included by one file of the program.
 * Counts nothing under AddressSanitizer and ThreadSanitizer, which replace these functions. */
#ifndef TOLIMAN_TESTS_ASKED_MEMORY_H
#define TOLIMAN_TESTS_ASKED_MEMORY_H

#include <stddef.h>

__attribute__((unused)) static size_t asked;

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
void *__libc_malloc(size_t size);
void *__libc_memalign(size_t alignment, size_t size);

void *malloc(size_t size) {
    asked += size;
    return __libc_malloc(size);
}

void *aligned_alloc(size_t alignment, size_t size) {
    asked += size;
    return __libc_memalign(alignment, size);
}
#endif

#endif
