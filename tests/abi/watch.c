/* The functions that a library with manners leaves alone, in place of the C library's: they tell who called, and go on.
 * The program exports them, so that every library that it loads is bound to them. */
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

static int report = -1;

void watch_into(const char *path) {
    report = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
}

void watch_no_more(void) {
    close(report);
    report = -1;
}

/* Not by stdio or write, which are watched. */
static void tell(const char *name, const void *caller) {
    Dl_info found;
    if (report < 0)
        return;
    const char *const path = dladdr(caller, &found) != 0 ? found.dli_fname : "?", *const slash = strrchr(path, '/');
    char line[200];
    const int length = snprintf(line, sizeof line, "%s from %s\n", name, slash == NULL ? path : slash + 1);
    syscall(SYS_write, report, line, (size_t)length);
}

static void *next(const char *name) {
    return dlsym(RTLD_NEXT, name);
}

#define CALLER __builtin_return_address(0)

/* Whoever calls it while the library is at work, itself or one that it has brought along. */
#define WATCH(result, name, parameters, arguments)                                                                     \
    result name parameters {                                                                                           \
        result(*real) parameters;                                                                                      \
        *(void **)&real = next(#name);                                                                                 \
        tell(#name, CALLER);                                                                                           \
        return real arguments;                                                                                         \
    }

/* The same of what never returns: the program ends here, so that the test sees it. */
#define WATCH_END(name, parameters, code)                                                                              \
    _Noreturn void name parameters {                                                                                   \
        tell(#name, CALLER);                                                                                           \
        for (;;)                                                                                                       \
            syscall(SYS_exit_group, code);                                                                             \
    }

/* Output, where it goes to the program's own stdout or stderr. */
#define WATCH_STREAM(result, name, parameters, arguments)                                                              \
    result name parameters {                                                                                           \
        result(*real) parameters;                                                                                      \
        *(void **)&real = next(#name);                                                                                 \
        if (stream == stdout || stream == stderr)                                                                      \
            tell(#name, CALLER);                                                                                       \
        return real arguments;                                                                                         \
    }

/* Those with arguments after a format. */
#define WATCH_FORMAT(name, parameters, valid, stream)                                                                  \
    int name parameters {                                                                                              \
        va_list arguments;                                                                                             \
        if (valid)                                                                                                     \
            tell(#name, CALLER);                                                                                       \
        va_start(arguments, format);                                                                                   \
        const int count = vfprintf(stream, format, arguments);                                                         \
        va_end(arguments);                                                                                             \
        return count;                                                                                                  \
    }

#pragma GCC diagnostic ignored "-Wmissing-attributes"
#pragma GCC diagnostic ignored "-Wnonnull-compare"

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
        tell("write", CALLER);
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
