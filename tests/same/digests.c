/* Prints what each call of the table tests/fault/scenarios computes, as a digest of its outputs, object and file, so
 * that processors, compilers and settings can be compared. Usage: digests ISA
 *
 *   ISA    0 baseline, 1 avx2, 2 avx512; the program exits with 77 if this processor does not support it */
#include <stdio.h>
#include <stdlib.h>

#include "attempts.h"

int shim_choose_isa(int isa);

int main(int count, char **arguments) {
    if (count != 2)
        return 2;
    if (!shim_choose_isa(atoi(arguments[1])))
        return 77;
    create_folders(1);
    for (size_t i = 0; i < scenario_count; i++) {
        now = scenarios[i];
        reference good = undisturbed_call(FAIL_NOTHING);
        printf("%s%s%s\t%016llx\n", now->function, now->variant ? ", " : "", now->variant ? now->variant : "",
               (unsigned long long)digest_of_reference(&good));
        end_of_calls(&good);
    }
    remove_folders();
    return defects != 0;
}
