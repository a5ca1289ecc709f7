/* Weights blobs assembled from the format's specification (tools/docs/formats.md), without the library. */
#ifndef TOLIMAN_TESTS_TLMW_H
#define TOLIMAN_TESTS_TLMW_H

#include "cae_scene.h"
#include "crc32.h"

enum { kHeader = 104, kParameters = 97858, kTensors = 20, kMaxPlanes = 36 };
enum {
    kAtVersion = 4,
    kAtSize = 8,
    kAtProjected = 64,
    kAtWeightsEncoding = 68,
    kAtPlanesEncoding = 70,
    kAtWeights = 96,
    kAtPlanes = 100
};
static const size_t kTensorSizes[kTensors] = {72,    8,     1152,  16, 4608, 32, 18432, 64, 16384, 1,
                                              16384, 16384, 18432, 32, 4608, 16, 1152,  8,  72,    1};
enum { kLatentBias = 72 + 8 + 1152 + 16 + 4608 + 32 + 18432 + 64 + 16384 };

static inline void put(uint8_t *at, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> (8 * i));
}

static inline uint64_t get(const uint8_t *at, int bytes) {
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++)
        value |= (uint64_t)at[i] << (8 * i);
    return value;
}

/* Writes the checksum. */
static inline void seal(uint8_t *blob, size_t size) {
    put(blob + size - 4, crc32_of(blob, size - 4), 4);
}

static inline uint32_t adler32_of(const uint8_t *bytes, size_t size) {
    uint32_t a = 1, b = 0;
    for (size_t i = 0; i < size; i++) {
        a = (a + bytes[i]) % 65521;
        b = (b + a) % 65521;
    }
    return b << 16 | a;
}

/* Writes bytes as a zlib stream of stored blocks; returns its size, at most size + size / 8192 + 16. */
static inline size_t store(const uint8_t *raw, size_t size, uint8_t *out) {
    uint8_t *next = out;
    *next++ = 0x78;
    *next++ = 0x01;
    for (size_t done = 0; done < size;) {
        const size_t left = size - done, block = left < 65535 ? left : 65535;
        *next++ = block == left;
        put(next, block | (~block & 0xffff) << 16, 4);
        memcpy(next + 4, raw + done, block);
        next += 4 + block;
        done += block;
    }
    const uint32_t sum = adler32_of(raw, size);
    for (int i = 3; i >= 0; i--)
        *next++ = (uint8_t)(sum >> (8 * i));
    return (size_t)(next - out);
}

/* Blocks of float32, each byte-shuffled. The caller frees the 4 bytes per float. */
static inline uint8_t *float32_blocks(const float *values, const size_t *blocks, size_t count) {
    size_t floats = 0;
    for (size_t k = 0; k < count; k++)
        floats += blocks[k];
    uint8_t *raw = malloc(4 * floats), *next = raw;
    assert_non_null(raw);
    for (size_t k = 0; k < count; k++) {
        for (size_t i = 0; i < 4 * blocks[k]; i++) {
            uint32_t bits;
            memcpy(&bits, &values[i % blocks[k]], 4);
            next[i] = (uint8_t)(bits >> (8 * (i / blocks[k])));
        }
        values += blocks[k];
        next += 4 * blocks[k];
    }
    return raw;
}

/* A blob with the header of another and these zlib streams, with matching sizes and checksum. The caller frees it. */
static inline uint8_t *assemble(const uint8_t *header, const uint8_t *weights, size_t weights_size,
                                const uint8_t *planes, size_t planes_size, size_t *size) {
    *size = kHeader + weights_size + planes_size + 4;
    uint8_t *out = malloc(*size);
    assert_non_null(out);
    memcpy(out, header, kHeader);
    memcpy(out + kHeader, weights, weights_size);
    memcpy(out + kHeader + weights_size, planes, planes_size);
    put(out + kAtSize, *size, 8);
    put(out + kAtWeights, weights_size, 4);
    put(out + kAtPlanes, planes_size, 4);
    seal(out, *size);
    return out;
}

/* The same from raw payloads; NULL takes the blob's own stream. */
static inline uint8_t *with_raw(const uint8_t *blob, const uint8_t *weights, size_t weights_size, const uint8_t *planes,
                                size_t planes_size, size_t *size) {
    const size_t old_weights = get(blob + kAtWeights, 4), old_planes = get(blob + kAtPlanes, 4);
    uint8_t *a = malloc(weights_size + weights_size / 8192 + 16), *b = malloc(planes_size + planes_size / 8192 + 16);
    assert_true(a != NULL && b != NULL);
    const size_t a_size = weights != NULL ? store(weights, weights_size, a) : old_weights;
    const size_t b_size = planes != NULL ? store(planes, planes_size, b) : old_planes;
    uint8_t *out = assemble(blob, weights != NULL ? a : blob + kHeader, a_size,
                            planes != NULL ? b : blob + kHeader + old_weights, b_size, size);
    free(a), free(b);
    return out;
}

/* The blob, of float32 payloads, with other weights (NULL = its own) or other planes. */
static inline uint8_t *with_payloads(const uint8_t *blob, const float *weights, const float *planes, size_t plane_count,
                                     size_t *size) {
    size_t plane_sizes[kMaxPlanes];
    for (size_t k = 0; k < kMaxPlanes; k++)
        plane_sizes[k] = kPixels;
    uint8_t *a = weights != NULL ? float32_blocks(weights, kTensorSizes, kTensors) : NULL;
    uint8_t *b = planes != NULL ? float32_blocks(planes, plane_sizes, plane_count) : NULL;
    uint8_t *out = with_raw(blob, a, 4 * kParameters, b, 4 * plane_count * kPixels, size);
    free(a), free(b);
    return out;
}

/* A refused load leaves *out unchanged. */
static inline void refused(const uint8_t *bytes, size_t size, const char *text) {
    toliman_cae *const mine = (toliman_cae *)(uintptr_t)8, *out = mine;
    assert_fails(toliman_cae_load(bytes, size, NULL, &out), TOLIMAN_E_FORMAT, text);
    assert_ptr_equal(out, mine);
}

#endif
