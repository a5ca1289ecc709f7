// Text by a printf format, for people: with a decimal point in every locale of the host, which the library must not
// change.
#pragma once
#include <cstdarg>
#include <cstddef>

namespace toliman {

// What snprintf and vsnprintf write into text[size], size > 0; conversions c d f g s u x and %, no n. Returns the
// length of what stands there. Allocates nothing.
size_t print_text(char *text, size_t size, const char *format, ...) noexcept __attribute__((format(printf, 3, 4)));
size_t print_text(char *text, size_t size, const char *format, va_list arguments) noexcept
    __attribute__((format(printf, 3, 0)));

// A piece of a text, from begin to end.
struct Piece {
    size_t begin = 0, end = 0;
};

// The same by a format that has one piece in braces, which are not written: where it is in the text.
Piece print_marked(char *text, size_t size, const char *format, va_list arguments) noexcept
    __attribute__((format(printf, 3, 0)));

} // namespace toliman
