/* Frames in memory as the library's functions expect them. */
#ifndef TOLIMAN_TESTS_IMAGES_H
#define TOLIMAN_TESTS_IMAGES_H

#include <math.h>
#include <stddef.h>

#include <toliman/image.h>

/* Doubles without gaps. */
#define PLAIN_IMAGE(frames) (&(const toliman_image){.struct_size = sizeof(toliman_image), .pixels = (frames)})

/* Frames of another pixel type, one after the other. */
#define IMAGE_OF(kind, frames)                                                                                         \
    (&(const toliman_image){.struct_size = sizeof(toliman_image), .pixel = (kind), .pixels = (frames)})

/* The largest difference of two images, relative to the peak of the second. */
static inline double peak_difference(const double *image, const double *expected, size_t pixels) {
    double most = 0, peak = 0;
    for (size_t i = 0; i < pixels; i++) {
        most = fmax(most, fabs(image[i] - expected[i]));
        peak = fmax(peak, fabs(expected[i]));
    }
    return most / peak;
}

#endif
