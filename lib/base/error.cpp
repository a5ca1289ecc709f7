#include "base/error.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "base/text.hpp"

namespace toliman {

namespace {
thread_local char last_text[kErrorTextSize] = "";

// Names and values off the wire may hold bytes that a terminal obeys.
char harmless(char byte) noexcept {
    return (byte >= 0 && byte < ' ') || byte == '\x7f' ? '?' : byte;
}
} // namespace

Error::Error(Status status, const char *text) noexcept : status_(status) {
    std::snprintf(text_, sizeof text_, "%s", text);
    std::transform(text_, text_ + std::strlen(text_), text_, harmless);
}

void fail(Status status, const char *format, ...) {
    char text[kErrorTextSize];
    va_list arguments;
    va_start(arguments, format);
    print_text(text, sizeof text, format, arguments);
    va_end(arguments);
    throw Error(status, text);
}

void set_last_error(const char *text) noexcept {
    std::snprintf(last_text, sizeof last_text, "%s", text);
}

const char *last_error() noexcept {
    return last_text;
}

} // namespace toliman
