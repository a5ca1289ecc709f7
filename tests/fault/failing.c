/* Replaces the C library's functions for memory and files. The program exports them, so that the dynamic linker binds
 * every library to them, including operator new, cJSON and zlib.
 *
 * Allocations count wherever they are made, except in FFTW, OpenBLAS and the Fortran library of OpenBLAS, which abort
 * the program when they get no memory. File calls count if libtoliman makes them. */
#include <errno.h>
#include <fcntl.h>
#include <link.h>
#include <malloc.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "failing.h"

#ifndef __clang__
#pragma GCC diagnostic ignored "-Wmissing-attributes"
#pragma GCC diagnostic ignored "-Wnonnull-compare"
#endif

/* Address ranges of libraries. */
typedef struct {
    uintptr_t from, to;
} range;
static range own[4], exempt[8], loader;
static size_t owns, exempts;

static const char *const exempt_names[] = {"libfftw3", "libopenblas", "libgfortran", "libquadmath"};

static range range_of(const struct dl_phdr_info *library) {
    range all = {UINTPTR_MAX, 0};
    for (int i = 0; i < library->dlpi_phnum; i++) {
        const ElfW(Phdr) *part = &library->dlpi_phdr[i];
        const uintptr_t from = library->dlpi_addr + part->p_vaddr, to = from + part->p_memsz;
        if (part->p_type != PT_LOAD)
            continue;
        all.from = from < all.from ? from : all.from;
        all.to = to > all.to ? to : all.to;
    }
    return all;
}

static int sort_library(struct dl_phdr_info *library, size_t size, void *unused) {
    const char *const slash = strrchr(library->dlpi_name, '/'), *const name = slash ? slash + 1 : library->dlpi_name;
    (void)size;
    (void)unused;
    if (strncmp(name, "libtoliman", 10) == 0 && owns < sizeof own / sizeof *own)
        own[owns++] = range_of(library);
    if (strncmp(name, "ld-linux", 8) == 0)
        loader = range_of(library);
    for (size_t i = 0; i < sizeof exempt_names / sizeof *exempt_names; i++)
        if (strncmp(name, exempt_names[i], strlen(exempt_names[i])) == 0 && exempts < sizeof exempt / sizeof *exempt)
            exempt[exempts++] = range_of(library);
    return 0;
}

static void __attribute__((constructor)) sort_libraries(void) {
    dl_iterate_phdr(sort_library, NULL);
}

static int is_in(const void *address, range where) {
    return (uintptr_t)address >= where.from && (uintptr_t)address < where.to;
}

static int is_in_any(const void *address, const range *ranges, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (is_in(address, ranges[i]))
            return 1;
    return 0;
}

/* The call that fails. */
static _Atomic int armed = FAIL_NOTHING;
static _Atomic long calls;
static _Atomic(const char *) first_failed;
static long fails_at;
static int fails_permanently, fails_with;

void arm(enum what what, long at, int permanent, int error) {
    calls = 0;
    first_failed = NULL;
    fails_at = at;
    fails_permanently = permanent;
    fails_with = error;
    armed = what;
}

long disarm(void) {
    armed = FAIL_NOTHING;
    return calls;
}

const char *failed_call(void) {
    return first_failed != NULL ? first_failed : "";
}

static int fails(const char *name) {
    const char *none = NULL;
    const long call = atomic_fetch_add(&calls, 1);
    const int failing = fails_permanently ? call >= fails_at : call == fails_at;
    if (failing)
        atomic_compare_exchange_strong(&first_failed, &none, name);
    return failing;
}

static int no_memory(const char *name, const void *caller) {
    if (armed != FAIL_MEMORY || is_in_any(caller, exempt, exempts) || !fails(name))
        return 0;
    errno = ENOMEM;
    return 1;
}

static int no_file(const char *name, const void *caller) {
    if (armed != FAIL_FILES || !is_in_any(caller, own, owns) || fails_with == SHORT_COUNT || !fails(name))
        return 0;
    errno = fails_with;
    return 1;
}

/* Half of the requested size if this call is the one to fail, else all of it. */
static size_t part_of(size_t size, const char *name, const void *caller) {
    const int counts = armed == FAIL_FILES && fails_with == SHORT_COUNT && is_in_any(caller, own, owns);
    return counts && fails(name) && size > 1 ? size / 2 : size;
}

/* Watched blocks in a hash table with open addressing; a freed block leaves a tombstone. Blocks of the loader live as
 * long as threads, whose stacks the C library keeps, so they are not watched. */
enum { CAPACITY = 1 << 18 };
static void *blocks[CAPACITY];
static long held;
static _Atomic int watching;
static atomic_flag lock = ATOMIC_FLAG_INIT;
static char tombstone;

static void begin(void) {
    while (atomic_flag_test_and_set(&lock))
        ;
}

static void end(void) {
    atomic_flag_clear(&lock);
}

static size_t place_of(const void *block) {
    return (size_t)(((uintptr_t)block >> 4) * 0x9e3779b97f4a7c15u >> 46);
}

static void *record_block(void *block, const void *caller) {
    if (block == NULL || !watching || is_in(caller, loader) || is_in_any(caller, exempt, exempts))
        return block;
    begin();
    size_t i = place_of(block);
    for (size_t tried = 0; blocks[i] != NULL && blocks[i] != (void *)&tombstone; i = (i + 1) % CAPACITY)
        if (++tried == CAPACITY)
            __builtin_trap();
    blocks[i] = block;
    held++;
    end();
    return block;
}

static void forget_block(const void *block) {
    if (block == NULL || !watching)
        return;
    begin();
    for (size_t i = place_of(block); blocks[i] != NULL; i = (i + 1) % CAPACITY)
        if (blocks[i] == block) {
            blocks[i] = &tombstone;
            held--;
            break;
        }
    end();
}

void watch_memory(void) {
    watching = 0;
    memset(blocks, 0, sizeof blocks);
    held = 0;
    watching = 1;
}

long blocks_held(void) {
    return held;
}

#define CALLER __builtin_return_address(0)

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *block, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);
extern void __libc_free(void *block);

void *malloc(size_t size) {
    return no_memory("malloc", CALLER) ? NULL : record_block(__libc_malloc(size), CALLER);
}

void *calloc(size_t count, size_t size) {
    return no_memory("calloc", CALLER) ? NULL : record_block(__libc_calloc(count, size), CALLER);
}

static void *reallocated(void *block, size_t size, const void *caller) {
    forget_block(block);
    void *const moved = __libc_realloc(block, size);
    if (moved == NULL && size != 0)
        record_block(block, caller);
    return record_block(moved, caller);
}

void *realloc(void *block, size_t size) {
    return no_memory("realloc", CALLER) ? NULL : reallocated(block, size, CALLER);
}

void *reallocarray(void *block, size_t count, size_t size) {
    size_t bytes;
    if (no_memory("reallocarray", CALLER) || __builtin_mul_overflow(count, size, &bytes))
        return NULL;
    return reallocated(block, bytes, CALLER);
}

void *aligned_alloc(size_t alignment, size_t size) {
    return no_memory("aligned_alloc", CALLER) ? NULL : record_block(__libc_memalign(alignment, size), CALLER);
}

void *memalign(size_t alignment, size_t size) {
    return no_memory("memalign", CALLER) ? NULL : record_block(__libc_memalign(alignment, size), CALLER);
}

int posix_memalign(void **out, size_t alignment, size_t size) {
    void *const block =
        no_memory("posix_memalign", CALLER) ? NULL : record_block(__libc_memalign(alignment, size), CALLER);
    if (block == NULL)
        return ENOMEM;
    *out = block;
    return 0;
}

void free(void *block) {
    forget_block(block);
    __libc_free(block);
}

/* File functions, implemented by direct system calls. */
#define FILE_CALL(name, parameters, number, ...)                                                                       \
    int name parameters {                                                                                              \
        return no_file(#name, CALLER) ? -1 : (int)syscall(number, __VA_ARGS__);                                        \
    }

FILE_CALL(fsync, (int file), SYS_fsync, file)
FILE_CALL(fdatasync, (int file), SYS_fdatasync, file)
FILE_CALL(ftruncate, (int file, off_t size), SYS_ftruncate, file, size)
FILE_CALL(fchmod, (int file, mode_t mode), SYS_fchmod, file, mode)
FILE_CALL(flock, (int file, int operation), SYS_flock, file, operation)
FILE_CALL(fstat, (int file, struct stat *attributes), SYS_fstat, file, attributes)
FILE_CALL(fstatat, (int folder, const char *path, struct stat *attributes, int flags), SYS_newfstatat, folder, path,
          attributes, flags)
FILE_CALL(lstat, (const char *path, struct stat *attributes), SYS_newfstatat, AT_FDCWD, path, attributes,
          AT_SYMLINK_NOFOLLOW)
FILE_CALL(stat, (const char *path, struct stat *attributes), SYS_newfstatat, AT_FDCWD, path, attributes, 0)
FILE_CALL(mkdir, (const char *path, mode_t mode), SYS_mkdirat, AT_FDCWD, path, mode)
FILE_CALL(unlink, (const char *path), SYS_unlinkat, AT_FDCWD, path, 0)
FILE_CALL(unlinkat, (int folder, const char *name, int flags), SYS_unlinkat, folder, name, flags)
FILE_CALL(rename, (const char *from, const char *to), SYS_renameat, AT_FDCWD, from, AT_FDCWD, to)
FILE_CALL(renameat, (int from, const char *old, int to, const char *new), SYS_renameat, from, old, to, new)

/* Closes the file in any case, as Linux does. */
int close(int file) {
    const int result = (int)syscall(SYS_close, file);
    return no_file("close", CALLER) ? -1 : result;
}

int open(const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    return no_file("open", CALLER) ? -1 : (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    return no_file("openat", CALLER) ? -1 : (int)syscall(SYS_openat, folder, path, flags, mode);
}

int fcntl(int file, int command, ...) {
    va_list arguments;
    va_start(arguments, command);
    void *const argument = va_arg(arguments, void *);
    va_end(arguments);
    return no_file("fcntl", CALLER) ? -1 : (int)syscall(SYS_fcntl, file, command, argument);
}

ssize_t read(int file, void *data, size_t size) {
    return no_file("read", CALLER) ? -1 : syscall(SYS_read, file, data, part_of(size, "read", CALLER));
}

ssize_t pread(int file, void *data, size_t size, off_t at) {
    return no_file("pread", CALLER) ? -1 : syscall(SYS_pread64, file, data, part_of(size, "pread", CALLER), at);
}

ssize_t write(int file, const void *data, size_t size) {
    return no_file("write", CALLER) ? -1 : syscall(SYS_write, file, data, part_of(size, "write", CALLER));
}

ssize_t pwrite(int file, const void *data, size_t size, off_t at) {
    return no_file("pwrite", CALLER) ? -1 : syscall(SYS_pwrite64, file, data, part_of(size, "pwrite", CALLER), at);
}

/* Supports only resolved == NULL, where the result is allocated. */
char *realpath(const char *path, char *resolved) {
    return resolved != NULL || no_file("realpath", CALLER) ? NULL : canonicalize_file_name(path);
}
