/* Checksums of the formats, without the library. */
#ifndef TOLIMAN_TESTS_CRC32_H
#define TOLIMAN_TESTS_CRC32_H

#include <stddef.h>
#include <stdint.h>

/* CRC32 as in zlib and PNG. */
static inline uint32_t crc32_of(const uint8_t *bytes, size_t size) {
    static uint32_t table[256];
    for (uint32_t i = 0; table[255] == 0; i++) {
        table[i] = i;
        for (int bit = 0; bit < 8; bit++)
            table[i] = (table[i] >> 1) ^ (table[i] & 1 ? 0xedb88320u : 0);
    }
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++)
        crc = (crc >> 8) ^ table[(crc ^ bytes[i]) & 255];
    return ~crc;
}

#endif
