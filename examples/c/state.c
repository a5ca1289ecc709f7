/* The orbit and the planets of a state folder of `toliman track --fit --system`: state FOLDER OBSERVER_FILE. */
#include <stdio.h>
#include <stdlib.h>

#include <toliman/toliman.h>

static void check(toliman_status status) {
    if (status == TOLIMAN_OK)
        return;
    fprintf(stderr, "%s: %s\n", toliman_constant_name(status), toliman_last_error());
    exit(EXIT_FAILURE);
}

int main(int argc, char **argv) {
    const toliman_sky_options seen_from = {.struct_size = sizeof seen_from, .observer = argc == 3 ? argv[2] : NULL};
    const toliman_measure_options measured = {.struct_size = sizeof measured, .kind = TOLIMAN_MEASURE_SEPARATION};
    toliman_measure *separations = NULL, *reduced = NULL;
    toliman_sky *sky = NULL, *better = NULL;
    toliman_planet *planets = NULL;
    toliman_sky_refit_result fit = TOLIMAN_SKY_REFIT_RESULT_INIT;
    toliman_planet_info found = TOLIMAN_PLANET_INFO_INIT;
    if (argc != 3)
        return EXIT_FAILURE;
    check(toliman_sky_create("alpha-cen", &seen_from, &sky));
    check(toliman_measure_load_file(argv[1], &measured, &separations));
    check(toliman_sky_refit(sky, separations, 0, &fit, &better));
    check(toliman_measure_load_file(argv[1], NULL, &reduced));
    check(toliman_planet_create(reduced, NULL, &planets));
    check(toliman_planet_get_info(planets, &found));
    printf("orbit: chi-square %.3f; %u planets\n", fit.chi_square, found.planets);
    toliman_planet_destroy(planets);
    toliman_measure_destroy(reduced);
    toliman_measure_destroy(separations);
    toliman_sky_destroy(better);
    toliman_sky_destroy(sky);
    return EXIT_SUCCESS;
}
