#include "base/error.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "base/text.hpp"

namespace toliman {

namespace {
thread_local char last_text[kErrorTextSize] = "", last_field[kErrorTextSize] = "";

// Names and values off the wire may hold bytes that a terminal obeys.
char harmless(char byte) noexcept {
    return (byte >= 0 && byte < ' ') || byte == '\x7f' ? '?' : byte;
}

void copy_harmless(char (&copy)[kErrorTextSize], const char *text) noexcept {
    std::snprintf(copy, sizeof copy, "%s", text);
    std::transform(copy, copy + std::strlen(copy), copy, harmless);
}

// inner_field: "" for the piece that the format marks.
Error error_of(Status status, const char *inner_field, const char *format, va_list arguments) noexcept {
    char text[kErrorTextSize], field[kErrorTextSize];
    const Piece marked = print_marked(text, sizeof text, format, arguments);
    std::snprintf(field, sizeof field, "%.*s", static_cast<int>(marked.end - marked.begin), text + marked.begin);
    return Error(status, text, inner_field[0] != '\0' ? inner_field : field);
}

} // namespace

Error::Error(Status status, const char *text, const char *field) noexcept : status_(status) {
    copy_harmless(text_, text);
    copy_harmless(field_, field);
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
