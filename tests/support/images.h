/* Frames in memory as the library's functions expect them. */
#ifndef TOLIMAN_TESTS_IMAGES_H
#define TOLIMAN_TESTS_IMAGES_H

#include <toliman/image.h>

/* Doubles without gaps. */
#define PLAIN_IMAGE(frames) (&(const toliman_image){.struct_size = sizeof(toliman_image), .pixels = (frames)})

/* Frames of another pixel type, one after the other. */
#define IMAGE_OF(kind, frames)                                                                                         \
    (&(const toliman_image){.struct_size = sizeof(toliman_image), .pixel = (kind), .pixels = (frames)})

#endif
