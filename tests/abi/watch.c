/* Replaces the C library functions that a library must not call: each reports its caller, and continues. The program
 * exports them, so that the dynamic linker binds every library to them. */
#include <dlfcn.h>
#include <fcntl.h>
#include <fenv.h>
#include <locale.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "watch.h"

static int report_file = -1;

void watch_into(const char *path) {
    report_file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
}

void stop_watching(void) {
    close(report_file);
    report_file = -1;
}

/* Does not use stdio or write, which are watched. */
static void report_call(const char *name, const void *caller) {
    Dl_info found;
    if (report_file < 0)
        return;
    const char *const path = dladdr(caller, &found) != 0 ? found.dli_fname : "?", *const slash = strrchr(path, '/');
    char line[200];
    const int length = snprintf(line, sizeof line, "%s from %s\n", name, slash == NULL ? path : slash + 1);
    syscall(SYS_write, report_file, line, (size_t)length);
}

static void *next(const char *name) {
    return dlsym(RTLD_NEXT, name);
}

#define CALLER __builtin_return_address(0)

/* Reports every caller while the watch is on, the library itself or one of its dependencies. */
#define WATCH(result, name, parameters, arguments)                                                                     \
    result name parameters {                                                                                           \
        result(*real) parameters;                                                                                      \
        *(void **)&real = next(#name);                                                                                 \
        report_call(#name, CALLER);                                                                                    \
        return real arguments;                                                                                         \
    }

/* The same for functions that never return: the program exits here, and the test sees it. */
#define WATCH_END(name, parameters, code)                                                                              \
    _Noreturn void name parameters {                                                                                   \
        report_call(#name, CALLER);                                                                                    \
        for (;;)                                                                                                       \
            syscall(SYS_exit_group, code);                                                                             \
    }

/* Output functions, reported if they write to the program's stdout or stderr. */
#define WATCH_STREAM(result, name, parameters, arguments)                                                              \
    result name parameters {                                                                                           \
        result(*real) parameters;                                                                                      \
        *(void **)&real = next(#name);                                                                                 \
        if (stream == stdout || stream == stderr)                                                                      \
            report_call(#name, CALLER);                                                                                \
        return real arguments;                                                                                         \
    }

/* Functions with variable arguments after a format. */
#define WATCH_FORMAT(name, parameters, valid, stream)                                                                  \
    int name parameters {                                                                                              \
        va_list arguments;                                                                                             \
        if (valid)                                                                                                     \
            report_call(#name, CALLER);                                                                                \
        va_start(arguments, format);                                                                                   \
        const int count = vfprintf(stream, format, arguments);                                                         \
        va_end(arguments);                                                                                             \
        return count;                                                                                                  \
    }

#ifndef __clang__
#pragma GCC diagnostic ignored "-Wmissing-attributes"
#pragma GCC diagnostic ignored "-Wnonnull-compare"
#endif

WATCH_END(exit, (int code), code)
WATCH_END(_exit, (int code), code)
WATCH_END(_Exit, (int code), code)
WATCH_END(quick_exit, (int code), code)
WATCH_END(abort, (void), 134)

WATCH_FORMAT(printf, (const char *format, ...), 1, stdout)
WATCH_FORMAT(fprintf, (FILE * stream, const char *format, ...), stream == stdout || stream == stderr, stream)
WATCH_STREAM(int, vfprintf, (FILE * stream, const char *format, va_list list), (stream, format, list))
WATCH_STREAM(int, fputs, (const char *text, FILE *stream), (text, stream))
WATCH_STREAM(int, fputc, (int c, FILE *stream), (c, stream))
WATCH_STREAM(int, putc, (int c, FILE *stream), (c, stream))
WATCH_STREAM(size_t, fwrite, (const void *data, size_t size, size_t n, FILE *stream), (data, size, n, stream))
WATCH(int, vprintf, (const char *format, va_list list), (format, list))
WATCH(int, puts, (const char *text), (text))
WATCH(int, putchar, (int c), (c))
WATCH(void, perror, (const char *text), (text))

ssize_t write(int file, const void *data, size_t size) {
    if (file == STDOUT_FILENO || file == STDERR_FILENO)
        report_call("write", CALLER);
    return syscall(SYS_write, file, data, size);
}

WATCH(char *, setlocale, (int category, const char *name), (category, name))
WATCH(locale_t, uselocale, (locale_t locale), (locale))
WATCH(sighandler_t, signal, (int number, sighandler_t handler), (number, handler))
WATCH(int, sigaction, (int number, const struct sigaction *new, struct sigaction *old), (number, new, old))
WATCH(int, sigprocmask, (int how, const sigset_t *set, sigset_t *old), (how, set, old))
WATCH(int, pthread_sigmask, (int how, const sigset_t *set, sigset_t *old), (how, set, old))
WATCH(int, putenv, (char *text), (text))
WATCH(int, setenv, (const char *name, const char *value, int replace), (name, value, replace))
WATCH(int, unsetenv, (const char *name), (name))
WATCH(int, clearenv, (void), ())
WATCH(char *, getenv, (const char *name), (name))
WATCH(char *, secure_getenv, (const char *name), (name))
WATCH(int, fesetround, (int mode), (mode))
WATCH(int, fesetenv, (const fenv_t *state), (state))
WATCH(int, feupdateenv, (const fenv_t *state), (state))
WATCH(int, feholdexcept, (fenv_t * state), (state))
WATCH(int, feenableexcept, (int exceptions), (exceptions))
WATCH(void, openblas_set_num_threads, (int count), (count))
WATCH(void, omp_set_num_threads, (int count), (count))
WATCH(void, srand, (unsigned seed), (seed))
WATCH(mode_t, umask, (mode_t mask), (mask))
WATCH(int, chdir, (const char *path), (path))
