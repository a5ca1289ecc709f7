// Tests messages: the same text as printf's for the same formats, with a decimal point in every locale, truncated to
// fit. Other locales are tested by abi/test_conventions.py; this test compares with printf in the C locale.
#include "base/text.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>

#pragma GCC diagnostic ignored "-Wformat-security" // formats are arguments of same()

namespace {

template <class... Values> void same(const char *format, Values... values) {
    for (const size_t size : {size_t{1}, size_t{2}, size_t{9}, size_t{30}, size_t{700}}) {
        char expected[700], text[700];
        std::memset(text, 'x', sizeof text);
        std::snprintf(expected, size, format, values...);
        const size_t length = toliman::print_text(text, size, format, values...);
        if (std::strcmp(text, expected) != 0 || length != std::strlen(expected) || (size < 700 && text[size] != 'x')) {
            std::printf("%s, size %zu: \"%s\", expected \"%s\"\n", format, size, text, expected);
            std::exit(1);
        }
    }
}

} // namespace

int main() {
    same("");
    same("100 %% of %s, and \"%.40s\"", "it",
         "a text, with a comma, that is longer than the forty letters it may have");
    same("%d %u %x 0x%x %c", -2147483647 - 1, 4294967295u, 48879u, 1u, 'q');
    same("%lld %llu %016llx", -9223372036854775807ll - 1, 18446744073709551615ull, 255ull);
    same("%zu of %5zu", size_t{18446744073709551615u}, size_t{7});
    same("%g %.17g %.0f %.3g %9.2f %-9.1f|%+g", 0.1, 0.1, 1e308, 1e-300, 3.14159, 2.5, 0.5);
    same("%g %g %g", 1.0 / 0.0, -1.0 / 0.0, 1e22);
    same("%.*s and %*d", 3, "abcdef", 6, 42);
    same("[%g, %g] px: %s", -0.5, 0.5, "1,5 stays as it came");
    std::puts("ok");
}
