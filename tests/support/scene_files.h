/* Files named by a test's scene: a temporary folder, and .npy files. */
#ifndef TOLIMAN_TESTS_SCENE_FILES_H
#define TOLIMAN_TESTS_SCENE_FILES_H

#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scene_text.h"

/* The test's temporary folder, with the files that a scene names. */
static char folder[] = P_tmpdir "/toliman-files-XXXXXX";

static inline int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) == NULL;
}

static inline const char *path_of(const char *name) {
    static char path[100];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static inline void write_file(const char *name, const void *data, size_t size) {
    FILE *const file = fopen(path_of(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* A .npy file of version 1 with the type and shape of the header, followed by the data. */
static inline void write_npy(const char *name, const char *type, const char *shape, const void *data, size_t size) {
    unsigned char bytes[128 + 8 * 96 * 96];
    char header[118];
    memcpy(bytes, "\x93NUMPY\x01\x00\x76\x00", 10);
    const int length =
        snprintf(header, sizeof header, "{'descr': '%s', 'fortran_order': False, 'shape': %s, }", type, shape);
    memset(header + length, ' ', sizeof header - (size_t)length);
    memcpy(bytes + 10, header, sizeof header);
    memcpy(bytes + 128, data, size);
    write_file(name, bytes, 128 + size);
}

static inline int remove_folder(void **state) {
    (void)state;
    const char *const names[] = {"scene.json", "mask.npy", "amplitude.npy", "surface.npy", "other.npy", "star.csv"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        unlink(path_of(names[i]));
    return rmdir(folder);
}

/* Simulator of the scene, with its files in the folder. */
static inline toliman_status create_in_folder(const char *json, toliman_sim **sim) {
    return toliman_sim_create_json(json, strlen(json), folder, NULL, sim);
}

/* Simulator of the binary scene with one place replaced. */
static inline toliman_status create_with(const char *from, const char *to, toliman_sim **sim) {
    char *const text = replaced(kBinaryScene, from, to);
    const toliman_status status = create_in_folder(text, sim);
    free(text);
    return status;
}

#endif
