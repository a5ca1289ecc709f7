/* Tests the autoencoder's passes against a plain network in double: its latent and loss, and differences of its
 * loss along a random direction in the weights of each kind of layer. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

double shim_loss_and_gradient(uint32_t layout, const float *weights, const float *image, float *gradient);
double shim_latent(uint32_t layout, const float *weights, const float *image);
double shim_latent_by_rows(uint32_t layout, const float *weights, const float *image);
size_t shim_tensor(uint32_t layout, size_t tensor, size_t *count);

enum { kMostPixels = 256 * 256, kMostWeights = 97858, kTensors = 20, kStages = 4 };
enum { kFlight = 1, kPaper, kCore };
static const size_t kChannels[kStages + 1] = {1, 8, 16, 32, 64};

typedef double Real;

static uint64_t state = 1;

static Real elu(Real x) {
    return x > 0 ? x : expm1(x);
}

/* 3x3 'same' convolution of in[side][side][from], kernel [to][from][3][3]; transposed: kernel [from][to][3][3]. */
static Real *convolve(const Real *in, size_t side, size_t from, size_t to, const Real *kernel, const Real *bias,
                      int transposed) {
    Real *out = malloc(side * side * to * sizeof *out);
    for (size_t i = 0; i < side * side * to; i++)
        out[i] = bias[i % to];
    for (long y = 0; y < (long)side; y++)
        for (long x = 0; x < (long)side; x++)
            for (long tap = 0; tap < 9; tap++) {
                const long sign = transposed ? -1 : 1, v = y + sign * (tap / 3 - 1), u = x + sign * (tap % 3 - 1);
                if (v < 0 || u < 0 || v >= (long)side || u >= (long)side)
                    continue;
                const Real *from_pixel = in + ((size_t)v * side + (size_t)u) * from;
                Real *to_pixel = out + ((size_t)y * side + (size_t)x) * to;
                for (size_t c = 0; c < from; c++)
                    if (from_pixel[c] != 0)
                        for (size_t k = 0; k < to; k++)
                            to_pixel[k] += from_pixel[c] * (transposed ? kernel[(c * to + k) * 9 + (size_t)tap]
                                                                       : kernel[(k * from + c) * 9 + (size_t)tap]);
            }
    return out;
}

/* Mean, or maximum and its index, of each 2x2 block of in[2 side][2 side][channels]. */
static Real *pool(const Real *in, size_t side, size_t channels, int maximum, int *place) {
    Real *out = malloc(side * side * channels * sizeof *out);
    for (size_t i = 0; i < side * side * channels; i++) {
        const size_t k = i % channels, x = i / channels % side, y = i / channels / side;
        Real sum = 0, best = -INFINITY;
        for (int q = 0; q < 4; q++) {
            const Real v = in[((2 * y + (size_t)q / 2) * 2 * side + 2 * x + (size_t)q % 2) * channels + k];
            sum += v / 4;
            if (v > best)
                best = v, place[i] = q;
        }
        out[i] = maximum ? best : sum;
    }
    return out;
}

/* Copies each value to its 2x2 block: to all four pixels, or to its index only. */
static Real *unpool(const Real *in, size_t side, size_t channels, int maximum, const int *place) {
    Real *out = calloc(4 * side * side * channels, sizeof *out);
    for (size_t i = 0; i < side * side * channels; i++) {
        const size_t k = i % channels, x = i / channels % side, y = i / channels / side;
        for (int q = 0; q < 4; q++)
            if (!maximum || place[i] == q)
                out[((2 * y + (size_t)q / 2) * 2 * side + 2 * x + (size_t)q % 2) * channels + k] = in[i];
    }
    return out;
}

static const Real *tensor(int layout, const Real *weights, size_t number) {
    size_t count;
    return weights + shim_tensor((uint32_t)layout, number, &count);
}

static size_t side_of(int layout) {
    return layout == kCore ? 128 : 256;
}

/* places: of the maxima of each stage. */
static Real slow_latent(int layout, const Real *weights, const Real *image, int **places) {
    const size_t input = side_of(layout), pixels = input * input, features = pixels / 4;
    Real *now = malloc(pixels * sizeof *now);
    memcpy(now, image, pixels * sizeof *now);
    for (size_t s = 0; s < kStages; s++) {
        const size_t side = input >> s, to = kChannels[s + 1], coarse = side * side / 4 * to;
        Real *next = convolve(now, side, kChannels[s], to, tensor(layout, weights, 2 * s),
                              tensor(layout, weights, 2 * s + 1), 0);
        for (size_t i = 0; layout == kPaper && i < side * side * to; i++)
            next[i] = elu(next[i]);
        places[s] = malloc(coarse * sizeof *places[s]);
        free(now);
        now = pool(next, side / 2, to, layout == kPaper, places[s]);
        for (size_t i = 0; layout != kPaper && i < coarse; i++)
            now[i] = elu(now[i]);
        free(next);
    }
    Real latent = tensor(layout, weights, 9)[0];
    for (size_t i = 0; i < features; i++)
        latent += now[i] * tensor(layout, weights, 8)[i];
    free(now);
    return latent;
}

static Real slow_loss(int layout, const Real *weights, const Real *image, Real *latent_out) {
    const size_t input = side_of(layout), pixels = input * input, features = pixels / 4;
    int *places[kStages];
    const Real latent = slow_latent(layout, weights, image, places);
    Real *now = malloc(features * sizeof *now);
    *latent_out = latent;
    for (size_t i = 0; i < features; i++)
        now[i] = elu(latent * tensor(layout, weights, 10)[i] + tensor(layout, weights, 11)[i]);
    for (size_t s = kStages; s-- > 0;) {
        const size_t side = input >> s, number = 12 + 2 * (kStages - 1 - s);
        Real *wide = unpool(now, side / 2, kChannels[s + 1], layout == kPaper, places[s]);
        free(now);
        now = convolve(wide, side, kChannels[s + 1], kChannels[s], tensor(layout, weights, number),
                       tensor(layout, weights, number + 1), 1);
        for (size_t i = 0; s > 0 && i < side * side * kChannels[s]; i++)
            now[i] = elu(now[i]);
        free(wide), free(places[s]);
    }
    Real loss = 0;
    for (size_t i = 0; i < pixels; i++)
        loss += (now[i] - image[i]) * (now[i] - image[i]) / (Real)pixels;
    free(now);
    return loss;
}

/* The weights that a direction varies: tensors first ... last. */
static const struct {
    const char *layer;
    size_t first, last;
} kLayers[] = {{"convolution", 0, 7}, {"latent", 8, 9}, {"expand", 10, 11}, {"deconvolution", 12, 19}};

static void check_layout(int layout) {
    static float weights[kMostWeights], image[kMostPixels], gradient[kMostWeights];
    static Real exact[kMostWeights], moved[kMostWeights], picture[kMostPixels];
    const size_t pixels = side_of(layout) * side_of(layout);
    for (size_t t = 0; t < kTensors; t++) {
        size_t count;
        const size_t offset = shim_tensor((uint32_t)layout, t, &count);
        const size_t stage = t < 8 ? t / 2 : kStages - 1 - (t - 12) / 2;
        const double inputs = t == 8    ? (double)pixels / 4
                              : t == 10 ? 1
                              : t % 2   ? 16 /* biases */
                                        : 9.0 * (double)kChannels[t < 8 ? stage : stage + 1];
        for (size_t i = 0; i < count; i++)
            exact[offset + i] = weights[offset + i] = (float)(uniform_signed(&state) * sqrt(3 / inputs));
    }
    for (size_t i = 0; i < pixels; i++)
        picture[i] = image[i] = (float)(uniform_signed(&state) + sin(0.05 * (double)i));

    const double loss = shim_loss_and_gradient((uint32_t)layout, weights, image, gradient);
    Real latent;
    const Real exact_loss = slow_loss(layout, exact, picture, &latent);
    assert_close(loss, (double)exact_loss, 1e-5, 0);
    const double encoded = shim_latent((uint32_t)layout, weights, image);
    assert_close(encoded, (double)latent, 1e-5, 0);
    if (layout != kPaper)
        assert_true(shim_latent_by_rows((uint32_t)layout, weights, image) == encoded);
    for (size_t l = 0; l < sizeof kLayers / sizeof kLayers[0]; l++) {
        /* So small that the loss is linear and no maximum moves to another pixel; rounding is 1e-5 of the slope. */
        const Real step = 1e-9;
        double along = 0, length = 0;
        size_t last;
        const size_t begin = shim_tensor((uint32_t)layout, kLayers[l].first, &last);
        const size_t before_last = shim_tensor((uint32_t)layout, kLayers[l].last, &last), end = before_last + last;
        memcpy(moved, exact, sizeof moved);
        for (size_t i = begin; i < end; i++) {
            /* The direction has a component along the gradient, so that the slope is not small, and random
             * components elsewhere. */
            const double direction = uniform_signed(&state) + 3 * (gradient[i] > 0 ? 1 : -1);
            moved[i] += step * (Real)direction;
            along += gradient[i] * direction;
            length += gradient[i] * gradient[i];
        }
        assert_true(length > 0);
        assert_close(along, (double)((slow_loss(layout, moved, picture, &latent) - exact_loss) / step), 2e-4, 0);
    }
}

TEST(test_flight) {
    check_layout(kFlight);
}

TEST(test_paper) {
    check_layout(kPaper);
}

TEST(test_core) {
    check_layout(kCore);
}

RUN_TESTS(NULL, NULL)
