/* Tests the warnings about projected images that depend on each other, on images made of orthogonal ones by hand. */
#include <string.h>

#include "assert_close.h"

void shim_dependence(const char *names, size_t pixels, const double *images, const double *variance, char *lines);

enum { kMost = 32, kPixels = 10 * (kMost + 1), kParts = 5 };

/* An image: the sum of part[k] times the orthogonal image k, of norm 1 over sigma; then times `scale`. */
typedef struct {
    double part[kParts], scale;
} mixture;

static double variance[kPixels], images[kMost][kPixels];
static char lines[4096];

static int set_up(void **unused) {
    for (int i = 0; i < kPixels; i++)
        variance[i] = 1 + i % 7;
    return 0;
}

/* Adds part times the orthogonal image k, which is not zero in every 33rd pixel. */
static void add(double *image, int k, double part) {
    for (int i = k; i < kPixels; i += kMost + 1)
        image[i] += part * sqrt(variance[i] / 10);
}

static void warned(const char *names, const mixture *mixtures, const char *expected) {
    memset(images, 0, sizeof images);
    for (size_t j = 0; j < strlen(names); j++)
        for (int k = 0; k < kParts; k++)
            add(images[j], k, mixtures[j].scale * mixtures[j].part[k]);
    shim_dependence(names, kPixels, images[0], variance, lines);
    assert_string_equal(lines, expected);
}

TEST(independent_images) {
    warned("", NULL, "");
    warned("a", (mixture[]){{{1}, 1e9}}, "");
    warned("abc", (mixture[]){{{1}, 1e9}, {{0.6, 0.8}, 1e-9}, {{0.3, -0.2, 0.9}, 7}}, "");
    const double far = sqrt(1 - 0.0101 * 0.0101);
    warned("abc", (mixture[]){{{1}, 1}, {{0, 1}, 1}, {{0.6 * far, 0.8 * far, 0.0101}, 1}}, "");
}

TEST(dropped_images) {
    const mixture a = {{1}, 1e9}, b = {{0, 1}, 1e-9}, c = {{0.6, -0.8}, 3}, zeros = {{0}, 0};
    warned("ab", (mixture[]){a, {{1}, -2}}, "b is a combination of a (-1.00): it is dropped\n");
    warned("abc", (mixture[]){a, b, c}, "c is a combination of b (-0.80), a (0.60): it is dropped\n");
    warned("cab", (mixture[]){c, a, b}, "b is a combination of c (-1.25), a (0.75): it is dropped\n");
    warned("zaybx", (mixture[]){zeros, a, a, b, c},
           "z changes no pixel: it is dropped\n"
           "y is a combination of a (1.00): it is dropped\n"
           "x is a combination of b (-0.80), a (0.60): it is dropped\n");
}

/* The image that the others explain best is named, wherever it is in the list, and only it. */
TEST(nearly_dependent_images) {
    const double near = sqrt(1 - 0.0099 * 0.0099);
    const mixture a = {{1}, 1e9}, b = {{0, 1}, 1e-9}, c = {{0.6 * near, -0.8 * near, 0.0099}, 3};
    const char *const expected = "c is nearly a combination of b (-0.80), a (0.60): 0.0099 of its norm remains\n";
    warned("abc", (mixture[]){a, b, c}, expected);
    warned("cab", (mixture[]){c, a, b}, expected);
    warned("ab", (mixture[]){a, {{1, 1e-6}, 1}}, "b is nearly a combination of a (1.00): 1e-06 of its norm remains\n");
    warned("abxy", (mixture[]){a, b, {{0, 1, 0, 1e-3}, 1}, {{1, 0, 1e-4}, -1}},
           "y is nearly a combination of a (-1.00): 0.0001 of its norm remains\n"
           "x is nearly a combination of b (1.00): 0.001 of its norm remains\n");
    warned("aby", (mixture[]){a, a, {{1, 1e-3}, 1}},
           "b is a combination of a (1.00): it is dropped\n"
           "y is nearly a combination of a (1.00): 0.001 of its norm remains\n");
}

TEST(the_largest_parts) {
    const mixture e[] = {{{0.3, 0.5, 0.7, 0.4, 1e-3}, 1}, {{1}, 1}, {{0, 1}, 1}, {{0, 0, 1}, 1}, {{0, 0, 0, 1}, 1}};
    warned("xabcd", (mixture[]){e[1], e[2], e[3], e[4], e[0]}, /* of norm 0.995 */
           "d is nearly a combination of b (0.70), a (0.50), c (0.40), ...: 0.001 of its norm "
           "remains\n");
}

/* As many as a scene may name, one of them the mean of the others and a remainder. */
TEST(many_images) {
    const char names[] = "abcdefghijklmnopqrstuvwxyzABCDEF";
    memset(images, 0, sizeof images);
    for (int k = 1; k < kMost; k++) {
        add(images[k], k, 1);
        add(images[0], k, 1 / sqrt(kMost - 1));
    }
    shim_dependence(names, kPixels, images[0], variance, lines);
    const char expected[] = "F is a combination of a (5.57), ";
    assert_memory_equal(lines, expected, sizeof expected - 1);
    add(images[0], 0, 0.002);
    shim_dependence(names, kPixels, images[0], variance, lines);
    assert_non_null(strstr(lines, "a is nearly a combination of "));
    assert_non_null(strstr(lines, "(0.18), ...: 0.002 of its norm remains\n"));
    assert_ptr_equal(strchr(lines, '\n') + 1, lines + strlen(lines));
}

RUN_TESTS(set_up, NULL)
