/* Stands between the libraries of a program and what they must not call. */
#ifndef TOLIMAN_TESTS_WATCH_H
#define TOLIMAN_TESTS_WATCH_H

/* From here on every unwanted call is one line of the file: what was called, and from which file. A library's last call
 * in a function may look like its caller's, so the program's own count as well. */
void watch_into(const char *path);

/* Ends that. */
void watch_no_more(void);

#endif
