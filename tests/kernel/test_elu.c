/* Tests ELU against expm1l. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"

int shim_isas(void);
void shim_elu(int isa, float *values, size_t count);

enum { kCount = 300001 };

/* Magnitudes from 1e-30 to 1e5, both signs, and special values. */
static float *arguments(void) {
    float *values = malloc(kCount * sizeof *values);
    for (int i = 0; i < kCount; i++)
        values[i] = (float)((i % 2 ? 1 : -1) * pow(10, -30 + 35.0 * i / kCount));
    values[0] = 0.0f;
    values[1] = INFINITY;
    values[2] = -INFINITY;
    values[3] = NAN;
    return values;
}

static void test_relative_error(void **unused) {
    for (int isa = 0; isa < shim_isas(); isa++) {
        float *in = arguments(), *out = arguments();
        shim_elu(isa, out, kCount);
        assert_true(isinf(out[1]) && isnan(out[3]));
        for (int i = 0; i < kCount; i++)
            if (i != 1 && i != 3)
                assert_close(out[i], in[i] > 0 ? in[i] : (double)expm1l(in[i]), 2e-7, 0);
        free(in), free(out);
    }
}

/* The bits of a value must depend neither on its neighbours, which determine how a block is computed, nor on the vector
 * width, although multiplications and additions are fused. */
static void test_same_bits(void **unused) {
    float *fused = NULL;
    for (int isa = 0; isa < shim_isas(); isa++) {
        float *together = arguments();
        shim_elu(isa, together, kCount);
        const float *in = arguments();
        for (int i = 0; i < kCount; i += 7) {
            float alone = in[i];
            shim_elu(isa, &alone, 1);
            assert_memory_equal(&alone, &together[i], sizeof alone);
        }
        if (fused != NULL)
            assert_memory_equal(fused, together, kCount * sizeof *fused);
        if (isa == 1)
            fused = together;
        else
            free(together);
        free((void *)in);
    }
    free(fused);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_relative_error),
        cmocka_unit_test(test_same_bits),
    };
    return cmocka_run_group_tests_name("elu", tests, NULL, NULL);
}
