/* Tests frames of every pixel type, and the chi-square of frames: valid ones, damaged ones, and against a plain fit. */
#include <stdlib.h>
#include <string.h>

#include <toliman/components.h>
#include <toliman/linear.h>

#include "cae_scene.h"
#include "images.h"

enum { COUNT = 3, kGap = 5 };

static const char *const shared_nuisances = "\"flux_a\", \"flux_b\", \"shift_x\", \"shift_y\"";

/* Shared by the tests; the network and the fit belong to the same scene. */
static toliman_sim *sim;
static toliman_cae *cae;
static toliman_linear *linear;

FIXTURE(set_up) {
    sim = make_sim(kSide, kSide, 0, shared_nuisances);
    cae = make_cae(sim, 1, 0, NULL);
    assert_ok(toliman_linear_create(sim, NULL, &linear));
    return 0;
}

FIXTURE(tear_down) {
    toliman_linear_destroy(linear), toliman_cae_destroy(cae), toliman_sim_destroy(sim);
    return 0;
}

static int is_signed(int32_t kind) {
    return kind == TOLIMAN_PIXEL_I16 || kind == TOLIMAN_PIXEL_I32 || kind == TOLIMAN_PIXEL_F32 ||
           kind == TOLIMAN_PIXEL_F64 || kind == TOLIMAN_PIXEL_I16BE || kind == TOLIMAN_PIXEL_F32BE;
}

/* A number that the type can represent, with more than one non-zero byte if the type has more. */
static double number_at(int32_t kind, size_t i) {
    const double small = (double)(i * 37 % 251);
    if (kind == TOLIMAN_PIXEL_U8)
        return small;
    const double large = small * 111 + (double)(i % 7);
    return is_signed(kind) && i % 3 == 0 ? -large : large;
}

static size_t width_of(int32_t kind) {
    const size_t widths[] = {1, 2, 4, 2, 4, 4, 8, 2, 4, 2, 4};
    return widths[kind - TOLIMAN_PIXEL_U8];
}

/* The bytes of a pixel, least significant first, reversed if the type is big-endian. */
static void put_pixel(int32_t kind, double value, unsigned char *at) {
    const size_t width = width_of(kind);
    const int64_t whole = (int64_t)value;
    const float narrow = (float)value;
    if (kind == TOLIMAN_PIXEL_F64)
        memcpy(at, &value, width);
    else if (kind == TOLIMAN_PIXEL_F32 || kind == TOLIMAN_PIXEL_F32BE)
        memcpy(at, &narrow, width);
    else
        memcpy(at, &whole, width);
    for (size_t i = 0; kind >= TOLIMAN_PIXEL_U16BE && i < width / 2; i++) {
        const unsigned char byte = at[i];
        at[i] = at[width - 1 - i];
        at[width - 1 - i] = byte;
    }
}

/* Frames of one pixel type, row r of frame k at k frame_stride + r stride; equal to doubles without gaps. */
static void fill(int32_t kind, size_t stride, size_t frame_stride, unsigned char *pixels, double *plain) {
    for (size_t k = 0; k < COUNT; k++)
        for (size_t r = 0; r < kSide; r++)
            for (size_t c = 0; c < kSide; c++) {
                const size_t i = (k * kSide + r) * kSide + c;
                plain[i] = number_at(kind, i);
                put_pixel(kind, plain[i], pixels + (k * frame_stride + r * stride + c) * width_of(kind));
            }
}

/* promise: latents-ignore-other-frames */
TEST(every_kind_of_pixels_and_every_layout_gives_the_same_bits) {
    /* without gaps, with gaps, and with the rows of all frames interleaved */
    const size_t strides[][2] = {{0, 0}, {kSide + kGap, (kSide + kGap) * (kSide + kGap)}, {COUNT * kSide, kSide}};
    unsigned char *pixels = malloc(8 * COUNT * (kSide + kGap) * (kSide + kGap));
    double *plain = new_image(COUNT * kPixels);
    assert_non_null(pixels);
    for (int32_t kind = TOLIMAN_PIXEL_U8; kind <= TOLIMAN_PIXEL_F32BE; kind++)
        for (size_t s = 0; s < 3; s++) {
            const size_t stride = strides[s][0], frame_stride = strides[s][1];
            fill(kind, stride ? stride : kSide, frame_stride ? frame_stride : kPixels, pixels, plain);
            const toliman_image image = {.struct_size = sizeof image,
                                         .pixel = kind,
                                         .pixels = pixels,
                                         .rows = s == 0 ? 0 : kSide,
                                         .cols = s == 0 ? 0 : kSide,
                                         .stride = (int64_t)stride,
                                         .frame_stride = (int64_t)frame_stride};
            double latents[COUNT], values[COUNT], alone;
            assert_ok(toliman_cae_encode(cae, &image, COUNT, latents, NULL));
            assert_ok(toliman_linear_encode(linear, &image, COUNT, values, NULL));
            assert_ok(toliman_cae_encode(cae, &image, 1, &alone, NULL));
            assert_memory_equal(&latents[0], &alone, sizeof alone);
            assert_ok(toliman_linear_encode(linear, &image, 1, &alone, NULL));
            assert_memory_equal(&values[0], &alone, sizeof alone);
            for (size_t k = s; k < COUNT; k += 3) { /* one of the frames for each layout */
                assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(plain + k * kPixels), 1, &alone, NULL));
                assert_memory_equal(&latents[k], &alone, sizeof alone);
                assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(plain + k * kPixels), 1, &alone, NULL));
                assert_memory_equal(&values[k], &alone, sizeof alone);
            }
        }
    free(plain), free(pixels);
}

/* promise: components-take-all-or-none */
TEST(components_take_many_frames_or_none) {
    enum { SMALL = 1 << 4 };
    const toliman_components_options options = {.struct_size = sizeof options, .bin = SMALL, .capacity = COUNT};
    toliman_components *one_by_one, *at_once;
    unsigned char *pixels = malloc(2 * COUNT * kPixels);
    double *plain = new_image(COUNT * kPixels), series[2][COUNT];
    assert_non_null(pixels);
    fill(TOLIMAN_PIXEL_U16BE, kSide, kPixels, pixels, plain);
    assert_ok(toliman_components_create(sim, &options, &one_by_one));
    assert_ok(toliman_components_create(sim, &options, &at_once));
    for (size_t k = 0; k < COUNT; k++)
        assert_ok(toliman_components_push(one_by_one, PLAIN_IMAGE(plain + k * kPixels), 1));
    const toliman_image *const image = IMAGE_OF(TOLIMAN_PIXEL_U16BE, pixels);
    assert_ok(toliman_components_push(at_once, NULL, 0));
    assert_refused(toliman_components_push(at_once, image, COUNT + 1), TOLIMAN_E_CAPACITY, "count");
    plain[kPixels + 300] = NAN;
    assert_fails(toliman_components_push(at_once, PLAIN_IMAGE(plain), COUNT), TOLIMAN_E_ARGUMENT,
                 "frame 1: counts[1][44] = nan");
    assert_ok(toliman_components_push(at_once, image, COUNT)); /* contains none of the other frames */
    assert_ok(toliman_components_train(one_by_one, NULL, NULL));
    assert_ok(toliman_components_train(at_once, NULL, NULL));
    assert_ok(toliman_components_get_series(one_by_one, 0, series[0], NULL));
    assert_ok(toliman_components_get_series(at_once, 0, series[1], NULL));
    assert_memory_equal(series[0], series[1], sizeof series[0]);
    toliman_components_destroy(one_by_one), toliman_components_destroy(at_once), free(plain), free(pixels);
}

static void assert_image_refused(const toliman_image *image, size_t count, toliman_status status, const char *field) {
    double values[2] = {1, 2};
    toliman_frame_goodness fits[2] = {TOLIMAN_FRAME_GOODNESS_INIT};
    fits[0].chi_square = 3;
    assert_refused(toliman_cae_encode(cae, image, count, values, fits), status, field);
    assert_refused(toliman_linear_encode(linear, image, count, values, fits), status, field);
    assert_true(values[0] == 1 && values[1] == 2 && fits[0].chi_square == 3 && fits[1].struct_size == 0);
}

TEST(impossible_images_are_refused) {
    double *frames = new_image(2 * kPixels), values[2];
    for (size_t i = 0; i < 2 * kPixels; i++)
        frames[i] = 1;
    const toliman_image good = {.struct_size = sizeof good, .pixels = frames};
    const uint32_t size = sizeof good;
    const struct {
        toliman_image image;
        size_t count;
        const char *field;
    } cases[] = {{{.struct_size = size, .pixels = frames, .pixel = 42}, 2, "image->pixel"},
                 {{.struct_size = size}, 2, "image->pixels"},
                 {{.struct_size = size, .pixels = frames, .rows = 255}, 2, "image->rows"},
                 {{.struct_size = size, .pixels = frames, .cols = -1}, 2, "image->cols"},
                 {{.struct_size = size, .pixels = frames, .stride = 255}, 2, "image->stride"},
                 {{.struct_size = size, .pixels = frames, .frame_stride = -1}, 2, "image->frame_stride"},
                 {{.struct_size = size, .pixels = (char *)frames + 4}, 2, "image->pixels"}, /* not aligned */
                 {{.struct_size = 3, .pixels = frames}, 2, "image->struct_size"},
                 {good, (size_t)1 << 60, "image"}, /* from here on: does not fit in memory */
                 {good, SIZE_MAX, "image"},
                 {{.struct_size = size, .pixels = frames, .stride = INT64_MAX}, 2, "image"},
                 {{.struct_size = size, .pixels = frames, .stride = INT64_MAX / 8}, 2, "image"},
                 {{.struct_size = size, .pixels = frames, .frame_stride = INT64_MAX}, 2, "image"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_image_refused(&cases[i].image, cases[i].count, i < 8 ? TOLIMAN_E_ARGUMENT : TOLIMAN_E_RANGE,
                             cases[i].field);
    assert_image_refused(NULL, 1, TOLIMAN_E_ARGUMENT, "image");
    frames[kPixels + 259] = INFINITY;
    assert_image_refused(&good, 2, TOLIMAN_E_ARGUMENT, "counts[1][3]");
    assert_fails(toliman_linear_encode(linear, &good, 2, values, NULL), TOLIMAN_E_ARGUMENT,
                 "frame 1: counts[1][3] = inf");
    assert_invalid(toliman_linear_encode(NULL, &good, 1, values, NULL), "linear");
    assert_invalid(toliman_linear_encode(linear, &good, 1, NULL, NULL), "values_px");
    assert_ok(toliman_linear_encode(linear, NULL, 0, NULL, NULL));
    assert_ok(toliman_cae_encode(cae, NULL, 0, NULL, NULL));
    toliman_frame_goodness older[2] = {{.struct_size = 4}};
    assert_invalid(toliman_linear_encode(linear, &good, 2, values, older), "goodness->struct_size");
    free(frames);
}

/* Residual over sigma, minus its projections on the images one after the other, in long double. */
static double slow_chi_square(const double *frame) {
    const int32_t kinds[] = {TOLIMAN_SIM_IMAGE_STAR_A, TOLIMAN_SIM_IMAGE_STAR_B, TOLIMAN_SIM_IMAGE_SHIFT_X,
                             TOLIMAN_SIM_IMAGE_SHIFT_Y, TOLIMAN_SIM_IMAGE_SEPARATION};
    enum { PLANES = 5 };
    static double image[kPixels], variance[kPixels];
    static long double planes[PLANES][kPixels], residual[kPixels];
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_VARIANCE, variance, kSide));
    assert_ok(toliman_sim_get_image(sim, TOLIMAN_SIM_IMAGE_BOTH, image, kSide));
    for (size_t i = 0; i < kPixels; i++)
        residual[i] = ((long double)frame[i] - image[i]) / sqrtl(variance[i]);
    for (size_t p = 0; p <= PLANES; p++) {
        long double *const plane = p < PLANES ? planes[p] : residual;
        if (p < PLANES) {
            assert_ok(toliman_sim_get_image(sim, kinds[p], image, kSide));
            for (size_t i = 0; i < kPixels; i++)
                plane[i] = image[i] / sqrtl(variance[i]);
        }
        for (size_t q = 0; q < 2 * p; q++) { /* projected twice because of rounding */
            long double along = 0, square = 0;
            for (size_t i = 0; i < kPixels; i++)
                along += plane[i] * planes[q % p][i], square += planes[q % p][i] * planes[q % p][i];
            for (size_t i = 0; i < kPixels; i++)
                plane[i] -= along / square * planes[q % p][i];
        }
    }
    long double left = 0;
    for (size_t i = 0; i < kPixels; i++)
        left += residual[i] * residual[i];
    return (double)(left / (kPixels - PLANES));
}

TEST(chi_square_matches_a_plain_fit) {
    static double frame[kPixels];
    double value, alone;
    toliman_frame_goodness fits[2] = {TOLIMAN_FRAME_GOODNESS_INIT, TOLIMAN_FRAME_GOODNESS_INIT};
    assert_ok(toliman_sim_frame(sim, &(double){1e-3}, 3, 0, 1, frame));
    for (size_t i = 0; i < kPixels; i++)
        frame[i] *= 1 + 1e-4 * (i % 256 < 128); /* a frame that no scene produces */
    assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(frame), 1, &value, &fits[0]));
    assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(frame), 1, &alone, NULL));
    assert_memory_equal(&value, &alone, sizeof value);
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &value, &fits[1]));
    assert_ok(toliman_cae_encode(cae, PLAIN_IMAGE(frame), 1, &alone, NULL));
    assert_memory_equal(&value, &alone, sizeof value);
    const double expected = slow_chi_square(frame);
    assert_true(expected > 1.1);
    assert_close(fits[0].chi_square, expected, 1e-9, 0);
    assert_close(fits[1].chi_square, expected, 1e-5, 0); /* the network's planes are float32 */
}

static double as_swapped(double counts) {
    const uint32_t bits = (uint32_t)counts;
    return (double)(bits << 24 | (bits & 0xff00) << 8 | (bits >> 8 & 0xff00) | bits >> 24);
}

enum { TRANSPOSED, SHIFTED, SWAPPED, HALF_LOST, EMPTY, FAULTS };

static void damage(int fault, const double *good, double *out) {
    for (size_t r = 0; r < kSide; r++)
        for (size_t c = 0; c < kSide; c++) {
            const double counts[FAULTS] = {good[c * kSide + r], good[r * kSide + (c + 1) % kSide],
                                           as_swapped(good[r * kSide + c]), r % 2 ? 0 : good[r * kSide + c], 0};
            out[r * kSide + c] = counts[fault];
        }
}

/* For both estimators of a scene: chi-square of noisy frames is within 5 sigma of 1, and that of damaged frames
 * outside: above, or below where the fluxes are free and an empty frame is fitted without noise. */
static void check_scene(const toliman_sim *scene, const toliman_cae *network, const toliman_linear *fit) {
    enum { GOOD = 24 };
    const double sigma = sqrt(2.0 / kPixels);
    double *frames = new_image((GOOD + FAULTS) * kPixels), values[GOOD + FAULTS];
    toliman_frame_goodness fits[2][GOOD + FAULTS] = {{{.struct_size = sizeof fits[0][0]}},
                                                     {{.struct_size = sizeof fits[0][0]}}};
    for (size_t k = 0; k < GOOD; k++)
        assert_ok(toliman_sim_frame(scene, &(double){1e-6 * (double)k}, 9, (int64_t)k, 1, frames + k * kPixels));
    for (int fault = 0; fault < FAULTS; fault++)
        damage(fault, frames, frames + (size_t)(GOOD + fault) * kPixels);
    assert_ok(toliman_cae_encode(network, PLAIN_IMAGE(frames), GOOD + FAULTS, values, fits[0]));
    assert_ok(toliman_linear_encode(fit, PLAIN_IMAGE(frames), GOOD + FAULTS, values, fits[1]));
    for (int which = 0; which < 2; which++) {
        double mean = 0, scatter = 0;
        for (size_t k = 0; k < GOOD; k++) {
            const toliman_frame_goodness *const good = &fits[which][k];
            assert_close(good->chi_square, 1, 0, 5 * sigma);
            assert_close(good->chi_square_sigma, sigma, 0.05, 0);
            assert_true(good->largest_residual > 3.5 && good->largest_residual < 6.5);
            assert_int_equal(good->goodness, TOLIMAN_GOODNESS_GOOD);
            assert_int_equal(good->bad_pixels, 0);
            mean += good->chi_square / GOOD;
            scatter += (good->chi_square - 1) * (good->chi_square - 1) / GOOD;
        }
        assert_close(mean, 1, 0, 5 * sigma / sqrt(GOOD));
        assert_close(sqrt(scatter), sigma, 0.5, 0);
        for (size_t k = GOOD; k < GOOD + FAULTS; k++)
            assert_int_equal(fits[which][k].goodness,
                             fits[which][k].chi_square > 1 ? TOLIMAN_GOODNESS_POOR : TOLIMAN_GOODNESS_TOO_GOOD);
    }
    free(frames);
}

TEST(damaged_frames_are_detected) {
    check_scene(sim, cae, linear);
}

/* This network projects nothing out, so its own residual is not available. */
TEST(damaged_frames_are_detected_in_the_chapter_scene) {
    toliman_sim *scene;
    toliman_linear *fit;
    assert_ok(toliman_sim_create_file("examples/scenes/chapter.json", NULL, &scene));
    assert_ok(toliman_linear_create(scene, NULL, &fit));
    toliman_cae *networks[2];
    assert_ok(toliman_cae_create(scene, 1, NULL, &networks[0]));
    const toliman_cae_options raw = {.struct_size = sizeof raw, .input = TOLIMAN_CAE_INPUT_RAW};
    assert_ok(toliman_cae_create(scene, 1, &raw, &networks[1]));
    check_scene(scene, networks[0], fit);
    static double frame[kPixels];
    double value;
    toliman_frame_goodness fits[2] = {TOLIMAN_FRAME_GOODNESS_INIT, TOLIMAN_FRAME_GOODNESS_INIT};
    assert_ok(toliman_sim_frame(scene, &(double){0}, 4, 4, 1, frame));
    for (int i = 0; i < 2; i++) { /* independent of the input */
        assert_ok(toliman_cae_encode(networks[i], PLAIN_IMAGE(frame), 1, &value, &fits[i]));
        toliman_cae_destroy(networks[i]);
    }
    assert_close(fits[0].chi_square, fits[1].chi_square, 1e-12, 0);
    toliman_linear_destroy(fit), toliman_sim_destroy(scene);
}

TEST(chi_square_is_the_same_on_any_number_of_workers) {
    double *frames = new_image(COUNT * kPixels), values[COUNT];
    toliman_frame_goodness first[2][COUNT], fits[COUNT] = {{.struct_size = sizeof fits[0]}};
    for (size_t k = 0; k < COUNT; k++)
        assert_ok(toliman_sim_frame(sim, &(double){0}, 1, (int64_t)k, 1, frames + k * kPixels));
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        const toliman_linear_options options = {.struct_size = sizeof options, .threads = threads};
        toliman_cae *const network = cae_on_threads(cae, threads);
        toliman_linear *template = NULL;
        assert_ok(toliman_linear_create(sim, &options, &template));
        for (int which = 0; which < 2; which++) {
            assert_ok(which ? toliman_cae_encode(network, PLAIN_IMAGE(frames), COUNT, values, fits)
                            : toliman_linear_encode(template, PLAIN_IMAGE(frames), COUNT, values, fits));
            if (threads == 1)
                memcpy(first[which], fits, sizeof fits);
            assert_memory_equal(fits, first[which], sizeof fits);
        }
        toliman_cae_destroy(network), toliman_linear_destroy(template);
    }
    for (size_t i = 0; i < kPixels; i++)
        frames[i] = 1e200;
    assert_ok(toliman_linear_encode(linear, PLAIN_IMAGE(frames), 1, values, fits));
    assert_true(isinf(fits[0].chi_square) && fits[0].goodness == TOLIMAN_GOODNESS_POOR);
    free(frames);
}

RUN_TESTS(set_up, tear_down)
