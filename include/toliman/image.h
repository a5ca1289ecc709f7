/* libtoliman, images: frames in the caller's memory, in any pixel type.
 *
 * Data flow
 *
 *   frames in memory -> toliman_image -> cae.h, linear.h, fit.h, bank.h, calibrate.h, components.h
 *   downlinked frames -> toliman_frame, with the same pixel types -> track.h
 *
 * Errors of these functions: TOLIMAN_E_ARGUMENT for another shape, and for a count that is not finite, naming frame,
 * row and column; TOLIMAN_E_RANGE for an image larger than the address space. A single frame is processed on the
 * calling thread. */
#ifndef TOLIMAN_IMAGE_H
#define TOLIMAN_IMAGE_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* Pixel types. BE is big-endian, as telemetry; others little-endian. */
#define TOLIMAN_PIXEL_U8 31
#define TOLIMAN_PIXEL_U16 32
#define TOLIMAN_PIXEL_U32 33
#define TOLIMAN_PIXEL_I16 34
#define TOLIMAN_PIXEL_I32 35
#define TOLIMAN_PIXEL_F32 36
#define TOLIMAN_PIXEL_F64 37
#define TOLIMAN_PIXEL_U16BE 38
#define TOLIMAN_PIXEL_U32BE 39
#define TOLIMAN_PIXEL_I16BE 40
#define TOLIMAN_PIXEL_F32BE 41

/* View of frames: pixel (row, column) of frame k is pixels[k * frame_stride + row * stride + column]. Doubles without
 * gaps, in C: &(toliman_image){.struct_size = sizeof(toliman_image), .pixels = counts} */
typedef struct toliman_image {
    uint32_t struct_size;
    int32_t pixel;          /* TOLIMAN_PIXEL_..., 0 = F64 */
    const void *pixels;     /* aligned to the size of a pixel */
    int64_t rows, cols;     /* 0 = the shape that the object expects */
    int64_t stride;         /* 0 = cols */
    int64_t frame_stride;   /* at least 1; 0 = rows * stride */
    const int64_t *windows; /* [count][2] row and column on the detector of each frame's first pixel, at most 2^31: if
                               the scene has detector.window, its bad pixels are left out at their places there
                               (promise: bad-pixels-stay-on-the-detector). If more than 30 move into a frame, its
                               goodness is POOR; calibrations refuse frames in which they move
                               (TOLIMAN_E_UNSUPPORTED), and fits those in which detector.response moves. NULL = the
                               scene's window */
} toliman_image;
#define TOLIMAN_IMAGE_INIT TOLIMAN_INIT(toliman_image)

TOLIMAN_END_DECLS

#endif
