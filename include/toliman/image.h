/* libtoliman, images: frames in the caller's memory, of any kind of pixels.
 *
 * Data flow
 *
 *   frames in memory -> toliman_image -> cae.h, linear.h, components.h (..._many)
 *   frames off a downlink -> toliman_frame, whose pixels are of the same kinds -> track.h
 */
#ifndef TOLIMAN_IMAGE_H
#define TOLIMAN_IMAGE_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* Kinds of pixels: unsigned, signed and floating-point numbers. Those without a suffix have the byte order of the
 * machine, which is little-endian; those ending in BE are big-endian (most significant byte first, as telemetry is). */
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

/* One frame or several in memory, which functions read and never write: pixel (r, c) of frame k is the element k
 * frame_stride + r stride + c of pixels. Since 0.2. */
typedef struct toliman_image {
    uint32_t struct_size; /* sizeof(toliman_image) */
    int32_t pixel;        /* TOLIMAN_PIXEL_..., 0 = F64 */
    const void *pixels;   /* aligned to the size of a pixel */
    int64_t rows, cols;   /* of a frame; must be those that the object takes, 0 = those */
    int64_t stride;       /* pixels from row to row, at least cols; 0 = cols */
    int64_t frame_stride; /* pixels from frame to frame, at least 1; 0 = rows times stride */
} toliman_image;
#define TOLIMAN_IMAGE_INIT TOLIMAN_INIT(toliman_image)

TOLIMAN_END_DECLS

#endif
