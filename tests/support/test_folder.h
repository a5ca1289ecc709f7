/* Temporary folders. */
#ifndef TOLIMAN_TESTS_TEST_FOLDER_H
#define TOLIMAN_TESTS_TEST_FOLDER_H

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "assert_close.h"

/* Creates a new folder and writes its path; removes it with all files in it. */
static inline void make_folder(char *path, size_t capacity) {
    const char *above = getenv("TMPDIR");
    snprintf(path, capacity, "%s/toliman-track-XXXXXX", above != NULL ? above : "/tmp");
    assert_non_null(mkdtemp(path));
}

/* Copies a file, or a folder with its files to a new one. */
static inline void copy_file(const char *from, const char *to) {
    char command[700];
    snprintf(command, sizeof command, "cp -r %s %s", from, to);
    assert_int_equal(system(command), 0);
}

static inline void remove_folder(const char *path) {
    DIR *folder = opendir(path);
    assert_non_null(folder);
    for (const struct dirent *entry; (entry = readdir(folder)) != NULL;)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            assert_int_equal(unlinkat(dirfd(folder), entry->d_name, 0), 0);
    closedir(folder);
    assert_int_equal(rmdir(path), 0);
}

#endif
