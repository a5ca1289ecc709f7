/* Watches the calls of libraries to functions that they must not call. */
#ifndef TOLIMAN_TESTS_WATCH_H
#define TOLIMAN_TESTS_WATCH_H

/* From here on every unwanted call adds a line to the file: the function, and the file of its caller. A tail call of a
 * library may look like its caller's, so the program's own calls are reported as well. */
void watch_into(const char *path);

/* Stops watching. */
void stop_watching(void);

#endif
