/* Floating-point assertions for CMocka, which has none for double. */
#ifndef TOLIMAN_TESTS_ASSERT_CLOSE_H
#define TOLIMAN_TESTS_ASSERT_CLOSE_H

#include <math.h>
#include <string.h>

#include "test_list.h"

#include <toliman/base.h>

/* |actual - expected| <= atol + rtol |expected|; NaN fails. */
#define assert_close(actual, expected, rtol, atol)                                                                     \
    do {                                                                                                               \
        const double close_actual_ = (actual), close_expected_ = (expected);                                           \
        if (!(fabs(close_actual_ - close_expected_) <= (atol) + (rtol)*fabs(close_expected_)))                         \
            fail_msg("%s = %.17g, expected %.17g within rtol %g, atol %g", #actual, close_actual_, close_expected_,    \
                     (double)(rtol), (double)(atol));                                                                  \
    } while (0)

/* value <= limit; NaN fails. */
#define assert_at_most(value, limit)                                                                                   \
    do {                                                                                                               \
        const double most_value_ = (value), most_limit_ = (limit);                                                     \
        if (!(most_value_ <= most_limit_))                                                                             \
            fail_msg("%s = %.6g, must be at most %.6g", #value, most_value_, most_limit_);                             \
    } while (0)

/* The call succeeds; otherwise shows its code and message. */
#define assert_ok(call)                                                                                                \
    do {                                                                                                               \
        const toliman_status ok_status_ = (call);                                                                      \
        if (ok_status_ != TOLIMAN_OK)                                                                                  \
            fail_msg("%s: %s: %s", #call, toliman_constant_name(ok_status_), toliman_last_error());                    \
    } while (0)

/* The call, with capacity 0, asks for the number of results; there are some. */
#define assert_asks(call) assert_int_equal((call), TOLIMAN_E_CAPACITY)

/* The field of the last error occurs in its message, and is not "" for a status that always has one. The message is one
 * line without control characters, and has no full stop at its end. */
static inline void assert_field_fits(toliman_status status, const char *call) {
    const char *const field = toliman_last_error_field(), *const text = toliman_last_error();
    const size_t size = strlen(text);
    for (const char *at = text; *at != '\0'; at++)
        if ((unsigned char)*at < ' ' || *at == '\x7f')
            fail_msg("%s: message \"%s\" has a control character", call, text);
    if (size == 0 || strchr(":, ", text[size - 1]) != NULL || (text[size - 1] == '.' && text[size - 2] != '.'))
        fail_msg("%s: message \"%s\" is empty, or ends like no message", call, text);
    if (strstr(text, field) == NULL)
        fail_msg("%s: message \"%s\" does not contain its field \"%s\"", call, text, field);
    const int has_field = status == TOLIMAN_E_ARGUMENT || status == TOLIMAN_E_NOT_FOUND || status == TOLIMAN_E_WRITE ||
                          status == TOLIMAN_E_LOST || strstr(text, " is NULL") != NULL;
    if (has_field && field[0] == '\0')
        fail_msg("%s: message \"%s\" has no field", call, text);
}

/* The call fails with this code, a message that contains the text, and a matching field. */
#define assert_fails(call, code, text)                                                                                 \
    do {                                                                                                               \
        const toliman_status fails_status_ = (call);                                                                   \
        if (fails_status_ != (code))                                                                                   \
            fail_msg("%s: %s, expected %s", #call, toliman_constant_name(fails_status_), #code);                       \
        if (strstr(toliman_last_error(), (text)) == NULL)                                                              \
            fail_msg("%s: message \"%s\" does not contain \"%s\"", #call, toliman_last_error(), (text));               \
        assert_field_fits(fails_status_, #call);                                                                       \
    } while (0)

// The same for the field of the error: the exact name of the argument or member, "" if it names none.
#define assert_refused(call, code, field)                                                                              \
    do {                                                                                                               \
        const toliman_status refused_status_ = (call);                                                                 \
        if (refused_status_ != (code))                                                                                 \
            fail_msg("%s: %s, expected %s", #call, toliman_constant_name(refused_status_), #code);                     \
        if (strcmp(toliman_last_error_field(), (field)) != 0)                                                          \
            fail_msg("%s: field \"%s\", expected \"%s\": %s", #call, toliman_last_error_field(), (field),              \
                     toliman_last_error());                                                                            \
        assert_field_fits(refused_status_, #call);                                                                     \
    } while (0)

/* The same with TOLIMAN_E_ARGUMENT. */
#define assert_invalid(call, field) assert_refused(call, TOLIMAN_E_ARGUMENT, field)

#endif
