/* Images in long double by their defining sums; the library provides only pupil, spectrum and positions. */
#ifndef TOLIMAN_TESTS_LONG_DOUBLE_SIM_H
#define TOLIMAN_TESTS_LONG_DOUBLE_SIM_H

#include <complex.h>

#include "offsets.h"
#include "scene_text.h"

static inline long double complex cis(long double cycles) {
    cycles -= rintl(cycles);
    return cosl(2 * M_PIl * cycles) + I * sinl(2 * M_PIl * cycles);
}

typedef struct {
    int n;                   /* pupil samples */
    long double aperture, p; /* m, rad */
    double *amplitude, *opd, *wavelength, *weight[2];
    long double offset[4]; /* px; long double, since 1e-10 px relative to 20 px is below double precision */
    int wavelengths;
    long double area;
} reference;

static inline double *doubles(size_t count) {
    double *const values = malloc(count * sizeof *values);
    assert_non_null(values);
    return values;
}

static inline reference reference_of(const toliman_sim *sim, long double aperture_m, long double pixel_arcsec) {
    const toliman_sim_info info = sim_info_of(sim);
    reference r = {.n = (int)info.pupil_samples, .aperture = aperture_m, .p = pixel_arcsec * M_PIl / 648000};
    const size_t cells = (size_t)(r.n * r.n);
    r.wavelengths = info.wavelengths;
    r.amplitude = doubles(cells);
    r.opd = doubles(cells);
    r.wavelength = doubles((size_t)r.wavelengths);
    r.weight[0] = doubles((size_t)r.wavelengths);
    r.weight[1] = doubles((size_t)r.wavelengths);
    assert_ok(toliman_sim_get_pupil(sim, r.amplitude, r.opd));
    assert_ok(toliman_sim_get_spectrum(sim, (size_t)r.wavelengths, r.wavelength, r.weight[0], r.weight[1], NULL));
    double offset[4];
    get_offsets(sim, offset);
    for (int i = 0; i < 4; i++)
        r.offset[i] = offset[i];
    for (size_t i = 0; i < cells; i++)
        r.area += r.amplitude[i];
    return r;
}

static inline void release(reference *r) {
    free(r->amplitude);
    free(r->opd);
    free(r->wavelength);
    free(r->weight[0]);
    free(r->weight[1]);
}

/* Adds one star in one wavelength to sum[count_y][count_x], at the pixels u[], v[] (in px from the axis). */
static inline void add_star(const reference *r, int star, int w, const double *u, int count_x, const double *v,
                            int count_y, long double *sum) {
    const long double lambda = r->wavelength[w], cell = r->aperture / r->n;
    const long double *const offset = r->offset + 2 * star;
    long double complex *const kernel = malloc(sizeof *kernel * (size_t)(r->n * (count_x + 1)));
    long double complex *const focal = calloc((size_t)(count_x * count_y), sizeof *focal);
    long double complex *const row = kernel + r->n * count_x;
    for (int j = 0; j < count_x; j++)
        for (int x = 0; x < r->n; x++)
            kernel[j * r->n + x] = cis(-(x - (r->n - 1) / 2.0L) * cell * u[j] * r->p / lambda);
    for (int y = 0; y < r->n; y++) {
        const long double pupil_y = (y - (r->n - 1) / 2.0L) * cell;
        for (int x = 0; x < r->n; x++) {
            const double a = r->amplitude[y * r->n + x];
            const long double pupil_x = (x - (r->n - 1) / 2.0L) * cell;
            const long double opd = r->opd[y * r->n + x] + (pupil_x * offset[0] + pupil_y * offset[1]) * r->p;
            row[x] = a != 0 ? a * cis(opd / lambda) : 0;
        }
        for (int j = 0; j < count_x; j++) {
            long double complex along = 0;
            for (int x = 0; x < r->n; x++)
                along += row[x] * kernel[j * r->n + x];
            for (int i = 0; i < count_y; i++)
                focal[i * count_x + j] += along * cis(-pupil_y * v[i] * r->p / lambda);
        }
    }
    const long double scale = cell * r->p / lambda;
    for (int i = 0; i < count_x * count_y; i++)
        sum[i] += r->weight[star][w] * scale * scale / r->area *
                  (creall(focal[i]) * creall(focal[i]) + cimagl(focal[i]) * cimagl(focal[i]));
    free(kernel);
    free(focal);
}

/* Adds both stars in all wavelengths, like add_star. */
static inline void add_stars(const reference *r, const double *u, int count_x, const double *v, int count_y,
                             long double *sum) {
    for (int star = 0; star < 2; star++)
        for (int w = 0; w < r->wavelengths; w++)
            if (!isnan(r->offset[2 * star]))
                add_star(r, star, w, u, count_x, v, count_y, sum);
}

#endif
