// Copies text to a member of a caller's struct.
#pragma once
#include <string>

namespace toliman::api {

// Truncated to fit, at the end of a character of UTF-8, and terminated by a zero byte.
template <size_t capacity> void put_text(const std::string &text, char (&out)[capacity]) noexcept {
    size_t length = text.size() < capacity ? text.size() : capacity - 1;
    while (length < text.size() && length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80)
        length--;
    text.copy(out, length);
    out[length] = '\0';
}

} // namespace toliman::api
