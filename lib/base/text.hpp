// printf-style formatting of messages, with a decimal point in every locale of the host.
#pragma once
#include <cstdarg>
#include <cstddef>
#include <string>

namespace toliman {

// Like snprintf and vsnprintf into text[size], size > 0, for the conversions c d f g s u x and %. Returns the length of
// the text written, truncated if need be. Allocates nothing.
size_t print_text(char *text, size_t size, const char *format, ...) noexcept __attribute__((format(printf, 3, 4)));
size_t print_text(char *text, size_t size, const char *format, va_list arguments) noexcept
    __attribute__((format(printf, 3, 0)));

// The same as a string of at most 1023 bytes.
template <class... Values> std::string formatted(const char *format, Values... values) {
    char text[1024];
    print_text(text, sizeof text, format, values...);
    return text;
}

// A piece of a text: indices [begin, end).
struct Piece {
    size_t begin = 0, end = 0;
};

// The same with one piece of the format in braces, which are not printed. Returns where the piece is in the text.
Piece print_marked(char *text, size_t size, const char *format, va_list arguments) noexcept
    __attribute__((format(printf, 3, 0)));

} // namespace toliman
