/* The whole pipeline in C: simulates a scene, trains the network, encodes frames one by one, and prints the period.
 *
 *     first_light examples/scenes/chapter.json
 */
#include <stdio.h>
#include <stdlib.h>

#include <toliman/core.h>

static void check(toliman_status status) {
    if (status == TOLIMAN_OK)
        return;
    fprintf(stderr, "%s: %s\n", toliman_constant_name(status), toliman_last_error());
    exit(EXIT_FAILURE);
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: first_light SCENE\n");
        return EXIT_FAILURE;
    }
    toliman_sim *sim = NULL;
    check(toliman_sim_create_file(argv[1], NULL, &sim));
    toliman_sim_info info = TOLIMAN_SIM_INFO_INIT;
    check(toliman_sim_get_info(sim, &info));

    toliman_cae *cae = NULL;
    check(toliman_cae_create(sim, info.seed, NULL, &cae));
    check(toliman_cae_train(cae, NULL, NULL));

    /* Frequencies from 1.5 cycles in the whole series to one cycle per two frames, which are one day apart. */
    double f0, df;
    int64_t nf;
    toliman_period *period = NULL;
    check(toliman_period_suggest(NULL, NULL, NULL, 0, (double)info.frames, &f0, &df, &nf, NULL));
    check(toliman_period_create(f0, df, nf, NULL, &period));

    double *pixels = malloc((size_t)(info.rows * info.cols) * sizeof *pixels);
    if (pixels == NULL)
        return EXIT_FAILURE;
    const toliman_image image = {.struct_size = sizeof image, .pixels = pixels};
    for (int64_t k = 0; k < info.frames; k++) {
        double time, latent;
        check(toliman_sim_get_series(sim, k, 1, &time, NULL));
        check(toliman_sim_frame(sim, NULL, info.seed, k, 1, pixels));
        check(toliman_cae_encode(cae, &image, 1, &latent, NULL));
        check(toliman_period_push(period, time, latent, 1));
    }
    toliman_period_peak peak = TOLIMAN_PERIOD_PEAK_INIT;
    check(toliman_period_query_peak(period, &peak));
    printf("true period %g days, found %.2f days, log10 FAP %.1f\n", info.period_days, peak.period, peak.log10_fap);

    free(pixels);
    toliman_period_destroy(period);
    toliman_cae_destroy(cae);
    toliman_sim_destroy(sim);
    return EXIT_SUCCESS;
}
