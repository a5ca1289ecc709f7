// Method: one exception type with its texts in fixed arrays, so that throwing and reporting allocate no text, also when
// memory is exhausted. The name of what was wrong is marked in the format itself ("{sigma} = %g: ..."): message and
// field cannot disagree, and no caller needs to parse messages.
#include "base/error.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "base/text.hpp"

namespace toliman {

namespace {
thread_local char last_text[kErrorTextSize] = "", last_field[kErrorTextSize] = "";

// Names and values in input files may contain control bytes, such as escape sequences of a terminal; they become '?'.
char printable(char byte) noexcept {
    return static_cast<unsigned char>(byte) < ' ' || byte == '\x7f' ? '?' : byte;
}

void copy_printable(char (&copy)[kErrorTextSize], const char *text) noexcept {
    std::snprintf(copy, sizeof copy, "%s", text);
    std::transform(copy, copy + std::strlen(copy), copy, printable);
}

// inner_field: the field; "" takes the piece in braces.
Error error_of(Status status, const char *inner_field, const char *format, va_list arguments) noexcept {
    char text[kErrorTextSize], field[kErrorTextSize];
    const Piece marked = print_marked(text, sizeof text, format, arguments);
    std::snprintf(field, sizeof field, "%.*s", static_cast<int>(marked.end - marked.begin), text + marked.begin);
    return Error(status, text, inner_field[0] != '\0' ? inner_field : field);
}

} // namespace

Error::Error(Status status, const char *text, const char *field) noexcept : status_(status) {
    copy_printable(text_, text);
    copy_printable(field_, field);
}

Error Error::of_member(const char *prefix) const noexcept {
    Error whole = *this;
    std::snprintf(whole.text_, sizeof whole.text_, "%s%s", prefix, text_);
    std::snprintf(whole.field_, sizeof whole.field_, "%s%s", prefix, field_);
    return whole;
}

void fail(Status status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const Error error = error_of(status, "", format, arguments);
    va_end(arguments);
    throw error;
}

void fail_within(const Error &inner, Status status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const Error error = error_of(status, inner.field(), format, arguments);
    va_end(arguments);
    throw error;
}

void set_last_error(const char *text, const char *field) noexcept {
    std::snprintf(last_text, sizeof last_text, "%s", text);
    std::snprintf(last_field, sizeof last_field, "%s", field);
}

const char *last_error() noexcept {
    return last_text;
}

const char *last_error_field() noexcept {
    return last_field;
}

} // namespace toliman
