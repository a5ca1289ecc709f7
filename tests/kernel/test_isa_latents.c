/* Tests that latents of noisy frames agree within 1e-5 of their sigma on every instruction set, with the same
 * weights. */
#include "cae_scene.h"
#include "images.h"

int shim_choose_isa(int isa);

enum { kFrames = 6 };

static void check_layout(int32_t layout, uint32_t steps, double allowed) {
    assert_true(shim_choose_isa(0));
    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    toliman_cae_options options = TOLIMAN_CAE_OPTIONS_INIT;
    toliman_cae *cae = NULL;
    options.layout = layout;
    assert_ok(toliman_cae_create(sim, 7, &options, &cae));
    toliman_cae_train_options how = TOLIMAN_CAE_TRAIN_OPTIONS_INIT;
    how.steps = steps;
    if (steps != 0)
        assert_ok(toliman_cae_train(cae, &how, NULL));

    double *frames = new_image((size_t)kFrames * kPixels), first[kFrames], latents[kFrames];
    const double displacements[kFrames] = {0, 1e-6, -1e-6, 1e-5, 0, 1e-4};
    assert_ok(toliman_sim_frame(sim, displacements, 3, 0, kFrames, frames));
    for (int isa = 0; isa < 3; isa++) {
        if (!shim_choose_isa(isa))
            continue;
        assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frames), kFrames, isa == 0 ? first : latents, NULL));
        for (int i = 0; isa > 0 && i < kFrames; i++)
            assert_close(latents[i], first[i], 0, allowed);
    }
    free(frames);
    toliman_cae_destroy(cae);
    toliman_sim_destroy(sim);
}

static void test_flight(void **unused) {
    toliman_sim *sim = make_sim(kSide, kSide, 0, "");
    toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
    assert_ok(toliman_sim_get_bounds(sim, &bounds));
    check_layout(TOLIMAN_CAE_LAYOUT_FLIGHT, 100, 1e-5 * bounds.crb_px);
    toliman_sim_destroy(sim);
}

/* The latent has no unit; its sigma over frames is about 0.1. */
static void test_paper(void **unused) {
    check_layout(TOLIMAN_CAE_LAYOUT_PAPER, 0, 1e-5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flight),
        cmocka_unit_test(test_paper),
    };
    return cmocka_run_group_tests_name("isa_latents", tests, NULL, NULL);
}
