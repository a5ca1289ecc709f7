/* Simulators of the scenes in examples/scenes, for programs that run in the folder of the project. */
#ifndef TOLIMAN_TESTS_SHIPPED_SCENE_H
#define TOLIMAN_TESTS_SHIPPED_SCENE_H

#include "scene_text.h"

/* The text of examples/scenes/<name>.json; the caller frees it. */
static inline char *shipped_scene(const char *name) {
    char path[80], text[8192];
    snprintf(path, sizeof path, "examples/scenes/%s.json", name);
    FILE *const file = fopen(path, "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    assert_int_equal(fclose(file), 0);
    char *const copy = malloc(strlen(text) + 1);
    assert_non_null(copy);
    return strcpy(copy, text);
}

/* The simulator of a scene on one thread; frees the text. */
static inline toliman_sim *one_core(char *text, int32_t engine) {
    toliman_sim_options options = TOLIMAN_SIM_OPTIONS_INIT;
    options.threads = 1;
    options.engine = engine;
    toliman_sim *sim = NULL;
    assert_ok(toliman_sim_create_json(text, strlen(text), "examples/scenes", &options, &sim));
    free(text);
    return sim;
}

#endif
