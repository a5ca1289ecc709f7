/* libtoliman, images: frames in the caller's memory, in any pixel type.
 *
 * Data flow
 *
 *   frames in memory -> toliman_image -> cae.h, linear.h, fit.h, bank.h, calibrate.h, components.h
 *   downlinked frames -> toliman_frame, with the same pixel types -> track.h
 */
#ifndef TOLIMAN_IMAGE_H
#define TOLIMAN_IMAGE_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* Pixel types: unsigned (U) and signed (I) integers and floating-point numbers (F) of 8 to 64 bits. Types without
 * suffix have the byte order of the machine, which is little-endian. BE is big-endian, the byte order of telemetry. */
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

/* View of one or more frames in memory, which the library only reads. Pixel (row, column) of frame k is pixels[k *
 * frame_stride + row * stride + column]. Frames of doubles without gaps, also a single one, are in C
 *
 *     &(toliman_image){.struct_size = sizeof(toliman_image), .pixels = counts}
 */
typedef struct toliman_image {
    uint32_t struct_size; /* sizeof(toliman_image) */
    int32_t pixel;        /* TOLIMAN_PIXEL_..., 0 = F64 */
    const void *pixels;   /* aligned to the size of a pixel */
    int64_t rows, cols;   /* shape of a frame, which must be the shape that the object expects; 0 = that shape */
    int64_t stride;       /* pixels from row to row, at least cols; 0 = cols */
    int64_t frame_stride; /* pixels from frame to frame, at least 1 (frames may overlap); 0 = rows * stride */
} toliman_image;
#define TOLIMAN_IMAGE_INIT TOLIMAN_INIT(toliman_image)

TOLIMAN_END_DECLS

#endif
