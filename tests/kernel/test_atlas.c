/* Tests images and derivatives interpolated from an atlas against images propagated at the place, and the adjoint of
 * the interpolation. */
#include <string.h>

#include "scene_text.h"
#include "uniform.h"

void *shim_atlas_make(const char *json, double reach_x, double reach_y, double *error, size_t *shape);
void shim_atlas_destroy(void *made);
int shim_atlas_covers(const void *made, size_t star, double x, double y);
void shim_atlas_images(const void *made, size_t star, size_t plane, double x, double y, size_t orders,
                       double *const *images);
void shim_atlas_adjoint(const void *made, size_t star, double x, double y, double (*random)(void), double *errors);
void shim_atlas_propagated(const void *made, size_t star, double x, double y, double *const *images);

enum { MOST_PIXELS = 64 * 64, IMAGES = 7 };

static double here[IMAGES][MOST_PIXELS], there[IMAGES][MOST_PIXELS];
static double *const at_here[] = {here[0], here[1], here[2], here[3], here[4], here[5], here[6]};
static double *const at_there[] = {there[0], there[1], there[2], there[3], there[4], there[5], there[6]};

static double random_number(void) {
    static uint64_t state = 3;
    return uniform_signed(&state);
}

/* Largest |a - b| and largest |b| of images first ... last at all places so far. */
typedef struct {
    int first, last;
    double error, largest;
} comparison;

static void compare(comparison *c, size_t pixels) {
    for (int image = c->first; image <= c->last; image++)
        for (size_t i = 0; i < pixels; i++) {
            c->error = fmax(c->error, fabs(here[image][i] - there[image][i]));
            c->largest = fmax(c->largest, fabs(there[image][i]));
        }
}

TEST(test_places) {
    const struct {
        const char *detector, *accuracy, *more;
        int stars;
    } cases[] = {
        {"\"shape\": [48, 48], \"pixel_scale_arcsec\": 0.2", "1e-9", "", 2},
        {"\"shape\": [48, 48], \"pixel_scale_arcsec\": 0.375", "1e-9", "", 2},
        {"\"shape\": [32, 32], \"pixel_scale_arcsec\": 0.6", "1e-9", "", 2},
        {"\"shape\": [48, 48], \"pixel_scale_arcsec\": 0.375", "1e-4", "", 2},
        {"\"shape\": [48, 48], \"pixel_scale_arcsec\": 0.375", "1e-6", "", 2},
        {"\"shape\": [48, 48], \"pixel_scale_arcsec\": 0.375", "1e-11", "", 2},
        {"\"shape\": [48, 48], \"pixel_scale_arcsec\": 0.375, \"pixel\": \"integrated\"", "1e-9", "", 2},
        {"\"shape\": [48, 48], \"pixel_scale_arcsec\": 0.6, \"pixel\": \"integrated\"", "1e-9",
         "\"systematics\": {\"jitter_sigma_px\": 0.2}, ", 2},
        {"\"shape\": [48, 48], \"pixel_scale_arcsec\": 0.375, \"pixel\": \"integrated\"", "1e-9",
         "\"systematics\": {\"jitter_covariance_px2\": {\"xx\": 0.05, \"yy\": 0.03, \"xy\": 0.02}}, ", 2},
        {"\"shape\": [33, 50], \"pixel_scale_arcsec\": 0.375", "1e-9", "", 2},
        {"\"shape\": [1, 7], \"pixel_scale_arcsec\": 0.375, \"scale_anisotropy\": 0.01, \"shear\": 0.02", "1e-9", "",
         2},
        {"\"shape\": [40, 31], \"pixel_scale_arcsec\": 0.2", "1e-9", "", 1},
    };
    const double places[][2] = {{0, 0},       {0.5, -0.5}, {1.25, 2.75},  {-11.3, 4.1}, {12.7, -8.5},
                                {-12.7, 8.5}, {12.7, 8.5}, {-12.7, -8.5}, {0.1, 1e-10}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        char more[200];
        snprintf(more, sizeof more, "%s\"accuracy\": %s, \"cadence\"", cases[c].more, cases[c].accuracy);
        char *text = replaced(cases[c].stars == 2 ? kBinaryScene : kSingleScene, "\"cadence\"", more);
        if (cases[c].stars == 2) /* with odd waves alone, defocus has no first-order effect */
            text = replaced_again(text, "\"m\": 5", "\"m\": 6");
        text = replaced_again(text,
                              cases[c].stars == 2 ? "\"shape\": [64, 64], \"pixel_scale_arcsec\": 0.2"
                                                  : "\"shape\": [32, 32], \"pixel_scale_arcsec\": 0.2",
                              cases[c].detector);
        comparison groups[4] = {{0, 0, 0, 0}, {1, 2, 0, 0}, {3, 5, 0, 0}, {6, 6, 0, 0}};
        double planned[2], worst[4];
        const double limit = atof(cases[c].accuracy);
        size_t shape[2];
        void *const atlas = shim_atlas_make(text, 12.7, 8.5, planned, shape);
        const size_t pixels = shape[0] * shape[1];
        for (size_t p = 0; p < sizeof places / sizeof *places; p++) {
            const size_t star = p % (size_t)cases[c].stars;
            const double x = places[p][0], y = places[p][1];
            assert_int_equal(shim_atlas_covers(atlas, star, x, y), 1);
            shim_atlas_propagated(atlas, star, x, y, at_there);
            shim_atlas_images(atlas, star, 0, x, y, 3, at_here);
            shim_atlas_images(atlas, star, 1, x, y, 1, &at_here[6]);
            for (int g = 0; g < 4; g++)
                compare(&groups[g], pixels);
            static double alone[MOST_PIXELS];
            double *const only[] = {alone}; /* the value does not depend on the derivatives that are requested */
            shim_atlas_images(atlas, star, 0, x, y, 1, only);
            double errors[2];
            shim_atlas_adjoint(atlas, star, x, y, random_number, errors);
            assert_true(errors[0] == 0);
            assert_at_most(errors[1], 1e-13);
            assert_memory_equal(alone, here[0], pixels * sizeof *alone);
        }
        for (int g = 0; g < 4; g++)
            worst[g] = groups[g].error / fmax(groups[g].largest, 1e-300);
        print_message(
            "case %zu: error of images %.2g, slopes %.2g, curvatures %.2g, focus %.2g; planned %.2g and %.2g\n", c,
            worst[0], worst[1], worst[2], worst[3], planned[0], planned[1]);
        assert_at_most(planned[0], limit);
        for (int g = 0; g < 4; g++) /* curvatures are promised to nobody */
            assert_at_most(worst[g], (g == 2 ? 60 : 1) * (planned[0] + planned[1]) + 1e-13);
        assert_int_equal(shim_atlas_covers(atlas, 0, 15.7, 0), 0);
        assert_int_equal(shim_atlas_covers(atlas, 0, 0, -11.5), 0);
        assert_int_equal(shim_atlas_covers(atlas, 0, NAN, 0), 0);
        shim_atlas_destroy(atlas);
        free(text);
    }
}

RUN_TESTS(NULL, NULL)
