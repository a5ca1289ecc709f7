/* Writes weights blobs of every encoding to the given folder and prints, as one JSON object per line, the performance
 * of a network loaded from each. weights.py runs this program and prints the table. */
#include "cae_scene.h"
#include "images.h"
#include "shipped_scene.h"
#include "timing.h"

enum { FRAMES = 2000, BATCH = 40, COMBINATIONS = 9, REPEATS = 9 };

static const char *const names[] = {"float32", "bf16", "fp16"};

/* The chapter's scene with four nuisances projected out. */
static toliman_sim *scene(void) {
    char *const json = replaced_again(
        shipped_scene("chapter"), "\"accuracy\"",
        "\"preprocess\": {\"project\": [\"flux_a\", \"flux_b\", \"shift_x\", \"shift_y\"]}, \"accuracy\"");
    toliman_sim *const sim = sim_of(json);
    free(json);
    return sim;
}

/* Saves the network to the folder and loads it from there REPEATS times. */
static toliman_cae *by_file(const toliman_cae *cae, const char *folder, int32_t weights, int32_t planes,
                            timing *loading) {
    char path[4096];
    toliman_cae_save_options options = TOLIMAN_CAE_SAVE_OPTIONS_INIT;
    options.weights_encoding = weights;
    options.planes_encoding = planes;
    snprintf(path, sizeof path, "%s/%s-%s.tlmw", folder, names[weights - TOLIMAN_CAE_ENCODING_FLOAT32],
             names[planes - TOLIMAN_CAE_ENCODING_FLOAT32]);
    assert_ok(toliman_cae_save_file(cae, &options, path));
    toliman_cae *loaded = NULL;
    double times[REPEATS];
    for (int i = 0; i < REPEATS; i++) {
        toliman_cae_destroy(loaded);
        const double start = processor_s();
        assert_ok(toliman_cae_load_file(path, NULL, &loaded));
        times[i] = processor_s() - start;
    }
    *loading = timing_of(times, REPEATS);
    return loaded;
}

static double latent_of(const toliman_cae *cae, const double *frame) {
    double latent = 0;
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &latent, NULL));
    return latent;
}

/* Frames of the scene without displacement, numbered after those of its cadence; latents[network][frame]. */
static void encode_frames(const toliman_sim *sim, toliman_cae *const *networks, double latents[][FRAMES]) {
    static const double zero[BATCH];
    double *const frames = new_image(BATCH * (size_t)kPixels);
    for (int first = 0; first < FRAMES; first += BATCH) {
        assert_ok(toliman_sim_frame(sim, zero, 1, 1095 + first, BATCH, frames));
        for (int k = 0; k < COMBINATIONS; k++)
            assert_ok(toliman_cae_encode(networks[k], PLAIN_IMAGE(frames), BATCH, &latents[k][first], NULL));
    }
    free(frames);
}

static double deviation(const double *values, const double *from) {
    double sum = 0, squares = 0;
    for (int i = 0; i < FRAMES; i++)
        sum += values[i] - (from != NULL ? from[i] : 0);
    for (int i = 0; i < FRAMES; i++)
        squares += pow(values[i] - (from != NULL ? from[i] : 0) - sum / FRAMES, 2);
    return sqrt(squares / (FRAMES - 1));
}

int main(int count, char **arguments) {
    static double latents[COMBINATIONS][FRAMES];
    assert_int_equal(count, 2);
    toliman_sim *const sim = scene();
    toliman_sim_bounds bounds = {.struct_size = sizeof bounds};
    assert_ok(toliman_sim_get_bounds(sim, &bounds));
    toliman_cae *const trained = make_cae(sim, 1, 600, NULL);
    toliman_cae *networks[COMBINATIONS];
    timing loading[COMBINATIONS];
    for (int32_t k = 0; k < COMBINATIONS; k++)
        networks[k] = by_file(trained, arguments[1], TOLIMAN_CAE_ENCODING_FLOAT32 + k / 3,
                              TOLIMAN_CAE_ENCODING_FLOAT32 + k % 3, &loading[k]);
    encode_frames(sim, networks, latents);

    double *const still = new_image(kPixels), *const brighter = new_image(kPixels), *const shifted = new_image(kPixels);
    assert_ok(toliman_sim_expect(sim, 0, still, kSide));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_STAR_A, brighter, kSide));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_SHIFT_X, shifted, kSide));
    for (int i = 0; i < kPixels; i++) {
        brighter[i] = still[i] + 1e-3 * brighter[i];
        shifted[i] = still[i] + 1e-4 * shifted[i];
    }
    const double sigma = deviation(latents[0], NULL);
    for (int k = 0; k < COMBINATIONS; k++) {
        const toliman_cae *const cae = networks[k];
        const double slope = (encode_expected(cae, sim, 1e-5) - encode_expected(cae, sim, -1e-5)) / 2e-5;
        printf("{\"weights\": \"%s\", \"planes\": \"%s\", \"load_s\": %.4g, \"load_spread\": %.2g, \"slope\": %.9g, "
               "\"bias\": %.3g, \"change\": %.3g, "
               "\"flux\": %.3g, \"shift\": %.3g, \"efficiency\": %.6g}\n",
               names[k / 3], names[k % 3], loading[k].median, loading[k].spread, slope,
               (latent_of(cae, still) - latent_of(trained, still)) / sigma, deviation(latents[k], latents[0]) / sigma,
               (latent_of(cae, brighter) - latent_of(trained, brighter)) / sigma,
               (latent_of(cae, shifted) - latent_of(trained, shifted)) / sigma,
               bounds.crb_projected_px * slope / deviation(latents[k], NULL));
        toliman_cae_destroy(networks[k]);
    }
    free(still), free(brighter), free(shifted);
    toliman_cae_destroy(trained);
    toliman_sim_destroy(sim);
    return 0;
}
