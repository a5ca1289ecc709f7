// Method: printf prints numbers with the decimal sign of the host's locale, which a library must not change (setlocale
// affects the whole process). The format is therefore split into conversions; each
// is printed by snprintf, and the locale's decimal sign in floating-point numbers is replaced by a point.
#include "base/text.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace toliman {

namespace {

struct Arguments {
    va_list list;
};

// One conversion of a format: its start ("%-8.3", with * replaced by the argument), length modifier and letter.
struct Conversion {
    char start[40] = "%";
    char length[3] = "";
    char letter = '\0';
};

void append(char *text, size_t size, const char *more, size_t count) noexcept {
    const size_t used = std::strlen(text), kept = std::min(count, size - 1 - used);
    std::memcpy(text + used, more, kept);
    text[used + kept] = '\0';
}

// Parses the conversion at format, which points to its %, and advances format past it.
Conversion conversion_at(const char *&format, Arguments &arguments) noexcept {
    Conversion found;
    for (format++; std::strchr("-+ #0123456789.*", *format) != nullptr && *format != '\0'; format++) {
        char number[16] = {*format, '\0'};
        if (*format == '*')
            std::snprintf(number, sizeof number, "%d", va_arg(arguments.list, int));
        append(found.start, sizeof found.start - sizeof found.length, number, std::strlen(number));
    }
    for (; *format == 'l' || *format == 'z'; format++)
        append(found.length, sizeof found.length, format, 1);
    found.letter = *format;
    if (*format != '\0')
        format++;
    return found;
}

// Replaces the locale's decimal sign, which may have several bytes, by a point.
void put_point(char *number) noexcept {
    char half[16];
    std::snprintf(half, sizeof half, "%.1f", 0.5);
    half[std::strlen(half) - 1] = '\0';
    const char *sign = half + 1;
    char *at = std::strstr(number, sign);
    if (at == nullptr || *sign == '\0')
        return;
    *at = '.';
    std::memmove(at + 1, at + std::strlen(sign), std::strlen(at + std::strlen(sign)) + 1);
}

class Printer {
  public:
    Printer(char *text, size_t size) noexcept : text_(text), size_(size) { text[0] = '\0'; }

    void put(const char *piece, size_t count) noexcept { append(text_, size_, piece, count); }

    void convert(const Conversion &one, Arguments &arguments) noexcept {
        const bool longer = one.length[0] == 'l', size = one.length[0] == 'z';
        switch (one.letter) {
        case '%':
            return put("%", 1);
        case 's':
            return print(one, va_arg(arguments.list, const char *));
        case 'f':
        case 'g':
            return print_double(one, va_arg(arguments.list, double));
        case 'c':
            return print(one, va_arg(arguments.list, int));
        case 'd':
            return longer ? print(one, va_arg(arguments.list, long long)) : print(one, va_arg(arguments.list, int));
        default: // u, x
            return longer ? print(one, va_arg(arguments.list, unsigned long long))
                   : size ? print(one, va_arg(arguments.list, size_t))
                          : print(one, va_arg(arguments.list, unsigned));
        }
    }

  private:
    template <class Value> void print(const Conversion &one, Value value) noexcept {
        char format[sizeof one.start + sizeof one.length];
        std::snprintf(format, sizeof format, "%s%s%c", one.start, one.length, one.letter);
        const size_t used = std::strlen(text_);
        std::snprintf(text_ + used, size_ - used, format, value);
    }
    void print_double(const Conversion &one, double value) noexcept {
        char number[400] = ""; // enough for %f of 1e308
        Printer(number, sizeof number).print(one, value);
        put_point(number);
        put(number, std::strlen(number));
    }
    char *text_;
    size_t size_;
};

void print(char *text, size_t size, const char *format, va_list arguments, Piece *marked) noexcept {
    Printer printer(text, size);
    Arguments left;
    va_copy(left.list, arguments);
    while (*format != '\0') {
        const size_t plain = std::strcspn(format, marked != nullptr ? "%{}" : "%");
        printer.put(format, plain);
        format += plain;
        if (*format == '%') {
            const Conversion one = conversion_at(format, left);
            printer.convert(one, left);
        } else if (marked != nullptr && *format != '\0') {
            (*format++ == '{' ? marked->begin : marked->end) = std::strlen(text);
        }
    }
    va_end(left.list);
}

} // namespace

size_t print_text(char *text, size_t size, const char *format, va_list arguments) noexcept {
    print(text, size, format, arguments, nullptr);
    return std::strlen(text);
}

Piece print_marked(char *text, size_t size, const char *format, va_list arguments) noexcept {
    Piece marked;
    print(text, size, format, arguments, &marked);
    return marked;
}

size_t print_text(char *text, size_t size, const char *format, ...) noexcept {
    va_list arguments;
    va_start(arguments, format);
    const size_t length = print_text(text, size, format, arguments);
    va_end(arguments);
    return length;
}

} // namespace toliman
