// The lines of a text file, with its path and their numbers for messages.
#pragma once
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "backend/file.hpp"

namespace toliman::ingest {

class TextLines {
  public:
    // Reads the file, of at most `limit` bytes, as file::read. A byte order mark at its beginning is skipped.
    TextLines(const std::string &path, size_t limit) : path_(path), bytes_(file::read(path, limit)) {
        constexpr unsigned char kByteOrderMark[] = {0xef, 0xbb, 0xbf};
        if (bytes_.size() >= 3 && std::equal(bytes_.begin(), bytes_.begin() + 3, kByteOrderMark))
            at_ = 3;
    }

    // The next line without its end and without blanks at its ends; false at the end of the file.
    bool next(std::string_view &line) noexcept {
        const std::string_view text(reinterpret_cast<const char *>(bytes_.data()), bytes_.size());
        if (at_ >= text.size())
            return false;
        const size_t end = std::min(text.find('\n', at_), text.size());
        line = trimmed(text.substr(at_, end - at_));
        at_ = end + 1;
        number_++;
        return true;
    }

    const char *path() const noexcept { return path_.c_str(); }
    int number() const noexcept { return number_; } // of the line, from 1

    static std::string_view trimmed(std::string_view text) noexcept {
        constexpr const char *kBlanks = " \t\r\v\f";
        const size_t first = text.find_first_not_of(kBlanks);
        if (first == std::string_view::npos)
            return {};
        return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
    }

  private:
    std::string path_;
    std::vector<uint8_t> bytes_;
    size_t at_ = 0;
    int number_ = 0;
};

// The integer that is the whole text; empty for other texts and beyond 64 bits.
inline std::optional<int64_t> integer_of(std::string_view text) noexcept {
    int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole ? std::optional<int64_t>(value) : std::nullopt;
}

} // namespace toliman::ingest
