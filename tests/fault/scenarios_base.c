/* base.h */
#include <string.h>

#include "scenario.h"

static toliman_status texts(attempt *a) {
    (void)a;
    must(strlen(toliman_version()) > 0, "version");
    must(toliman_abi_version() == TOLIMAN_ABI_VERSION, "abi_version");
    must(strcmp(toliman_constant_name(TOLIMAN_E_MEMORY), "TOLIMAN_E_MEMORY") == 0, "name of a status");
    must(strcmp(toliman_constant_name(TOLIMAN_GOODNESS_TOO_GOOD), "too good") == 0, "constant_name");
    must(toliman_get_struct_size("toliman_machine") == sizeof(toliman_machine), "get_struct_size");
    return TOLIMAN_OK;
}

/* Reading the message of an error must not allocate. */
static toliman_status message(attempt *a) {
    double power;
    (void)a;
    must(toliman_period_batch(-0.5, 1, 1, NULL, NULL, NULL, 0, NULL, &power) == TOLIMAN_E_ARGUMENT, "not refused");
    must(strstr(toliman_last_error(), "-0.5") != NULL, "the message does not name the value");
    must(strcmp(toliman_last_error_field(), "f0") == 0, "the field is not the argument");
    return TOLIMAN_OK;
}

static toliman_status machine(attempt *a) {
    return toliman_get_machine((void *)a->out);
}

static const scenario all[] = {
    {.function = "toliman_version", .call = texts},
    {.function = "toliman_constant_name", .call = texts},
    {.function = "toliman_abi_version", .call = texts},
    {.function = "toliman_get_struct_size", .call = texts},
    {.function = "toliman_last_error", .call = message},
    {.function = "toliman_last_error_field", .call = message},
    {.function = "toliman_get_machine", .call = machine, .struct_size = sizeof(toliman_machine)},
};
SCENARIO_LIST(base_scenarios, all);
