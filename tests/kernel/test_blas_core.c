/* Tests which OpenBLAS kernels are reported as faster, for each instruction set and each set of kernels in use.
 * OpenBLAS selects its kernels at program start, so this program runs itself once for each. */
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <toliman/base.h>

#include "assert_close.h"

int shim_choose_isa(int isa);

static const struct {
    const char *core, *better[3]; /* on baseline, avx2, avx512 */
} kCases[] = {
    {"Prescott", {"", "Haswell", "SkylakeX"}},
    {"Sandybridge", {"", "", "SkylakeX"}},
    {"Haswell", {"", "", "SkylakeX"}},
    {"SkylakeX", {"", "", ""}},
};

/* Runs in a program started with these kernels; returns 77 if the processor does not support them. */
static int check_case(int number) {
    toliman_machine machine = {.struct_size = sizeof machine};
    for (int isa = 0; isa < 3; isa++) {
        shim_choose_isa(isa); /* only the detection changes: no kernel runs */
        if (toliman_get_machine(&machine) != TOLIMAN_OK)
            return 1;
        if (strcmp(machine.blas_core, kCases[number].core) != 0)
            return 77;
        if (strcmp(machine.blas_better, kCases[number].better[isa]) != 0)
            return 2 + isa;
        if (machine.blas_is_slow != (machine.blas_better[0] != '\0'))
            return 5;
    }
    return 0;
}

TEST(older_kernels_are_reported) {
#if !defined(__x86_64__)
    skip(); /* the cases are kernels of x86-64 */
#endif
    int seen = 0;
    for (size_t i = 0; i < sizeof kCases / sizeof *kCases; i++) {
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            const char number[2] = {(char)('0' + i), '\0'};
            setenv("OPENBLAS_CORETYPE", kCases[i].core, 1);
            execl("/proc/self/exe", "test_blas_core", number, (char *)NULL);
            _exit(99);
        }
        int status = 0;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFEXITED(status));
        if (WEXITSTATUS(status) == 77)
            continue;
        assert_int_equal(WEXITSTATUS(status), 0);
        seen++;
    }
    assert_true(seen > 0);
}

TEST(no_kernels_are_better_than_those_of_other_processors) {
#if defined(__x86_64__)
    skip();
#endif
    toliman_machine machine = {.struct_size = sizeof machine};
    assert_int_equal(toliman_get_machine(&machine), TOLIMAN_OK);
    assert_string_equal(machine.blas_better, "");
    assert_int_equal(machine.blas_is_slow, 0);
}

int main(int argc, char **argv) {
    if (argc > 1)
        return check_case(argv[1][0] - '0');
    return RUN_ALL(NULL, NULL);
}
