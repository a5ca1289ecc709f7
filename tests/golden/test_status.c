/* Tests the numbers of the status codes, which are part of the binary interface: this list only ever grows. */
#include <stdio.h>
#include <string.h>

#include "assert_close.h"

#include <toliman/base.h>

TEST(codes_and_names) {
    static const char *const golden[] = {
        "TOLIMAN_OK",       "TOLIMAN_E_INTERNAL", "TOLIMAN_E_ARGUMENT",    "TOLIMAN_E_MEMORY", "TOLIMAN_E_NOT_FOUND",
        "TOLIMAN_E_FORMAT", "TOLIMAN_E_SCENE",    "TOLIMAN_E_UNSUPPORTED", "TOLIMAN_E_WRITE",  "TOLIMAN_E_CANCELLED",
        "TOLIMAN_E_RANGE",  "TOLIMAN_E_MISMATCH", "TOLIMAN_E_CAPACITY",    "TOLIMAN_E_STATE",  "TOLIMAN_E_LOST"};
    for (int32_t code = 0; code < (int32_t)(sizeof golden / sizeof golden[0]); code++)
        assert_string_equal(toliman_constant_name(code), golden[code]);
    assert_string_equal(toliman_constant_name(15), "?");
    assert_string_equal(toliman_constant_name(-1), "?");
    assert_int_equal(TOLIMAN_E_LOST, 14);
}

TEST(versions_agree) {
    assert_string_equal(toliman_version(), TOLIMAN_VERSION);
    assert_int_equal(toliman_abi_version(), TOLIMAN_ABI_VERSION);
}

TEST(properties_of_the_machine) {
    assert_refused(toliman_get_machine(NULL), TOLIMAN_E_ARGUMENT, "out");
    toliman_machine machine = {.struct_size = 1};
    assert_refused(toliman_get_machine(&machine), TOLIMAN_E_ARGUMENT, "out->struct_size");
    machine.struct_size = sizeof machine;
    assert_ok(toliman_get_machine(&machine));
    assert_true(machine.processors >= 1);
    assert_true(strlen(machine.isa) > 0 && strlen(machine.blas_core) > 0 && strlen(machine.fftw) > 0);
    assert_int_equal(machine.blas_is_slow, strlen(machine.blas_better) > 0);
}

RUN_TESTS(NULL, NULL)
