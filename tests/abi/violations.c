/* A library with a name like libtoliman's that calls every forbidden function: the watch must report each call. */
#include <fenv.h>
#include <locale.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

void openblas_set_num_threads(int count);

static void with_list(const char *format, ...) {
    va_list list;
    va_start(list, format);
    vprintf(format, list);
    va_end(list);
}

/* Through volatile pointers, so that the compiler cannot replace one function by another. */
#define DO(name, ...)                                                                                                  \
    if (strcmp(what, #name) == 0) {                                                                                    \
        __typeof__(name) *volatile call = name;                                                                        \
        call(__VA_ARGS__);                                                                                             \
        return;                                                                                                        \
    }

void call_forbidden(const char *what) {
    DO(exit, 0)
    DO(_exit, 0)
    DO(_Exit, 0)
    DO(quick_exit, 0)
    DO(abort)
    DO(printf, "%d", 1)
    DO(fprintf, stderr, "%d", 1)
    DO(fputs, "a", stdout)
    DO(fputc, 'a', stdout)
    DO(fwrite, "a", 1, 1, stderr)
    DO(puts, "a")
    DO(putchar, 'a')
    DO(perror, "a")
    DO(write, 1, "a", 1)
    DO(setlocale, LC_ALL, "C")
    DO(uselocale, LC_GLOBAL_LOCALE)
    DO(signal, SIGUSR1, SIG_IGN)
    DO(sigaction, SIGUSR1, NULL, NULL)
    DO(setenv, "TOLIMAN_BAD", "1", 1)
    DO(unsetenv, "TOLIMAN_BAD")
    DO(getenv, "HOME")
    DO(secure_getenv, "HOME")
    DO(fesetround, FE_DOWNWARD)
    DO(openblas_set_num_threads, 1)
    DO(srand, 1)
    DO(umask, 077)
    DO(chdir, "/")
    if (strcmp(what, "vprintf") == 0)
        with_list("%d", 1);
}
