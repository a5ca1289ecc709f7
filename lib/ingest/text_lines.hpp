// The lines of a text file, with its path and their numbers for messages.
#pragma once
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace toliman::ingest {

class TextLines {
  public:
    // Reads the file, of at most `limit` bytes, as file::read; a gzip file is unpacked. A byte order mark at its
    // beginning is skipped. Status::format if it is not text.
    TextLines(const std::string &path, size_t limit);
    // The lines of a text that was made from the file, and the lines of the file from which they come.
    TextLines(std::string path, const std::string &text, std::vector<int> numbers);

    // The next line without its end and without blanks at its ends; false at the end of the file.
    bool next(std::string_view &line) noexcept;
    // All that follows.
    std::string_view rest() const noexcept {
        const std::string_view text(reinterpret_cast<const char *>(bytes_.data()), bytes_.size());
        return text.substr(std::min(at_, text.size()));
    }

    const char *path() const noexcept { return path_.c_str(); }
    int number() const noexcept { // of the line, from 1
        return numbers_.empty() || count_ == 0 ? count_ : numbers_[static_cast<size_t>(count_) - 1];
    }

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
    std::vector<int> numbers_; // of the lines; empty: 1, 2, ...
    size_t at_ = 0;
    int count_ = 0; // lines so far
};

// The integer that is the whole text; empty for other texts and beyond 64 bits.
inline std::optional<int64_t> integer_of(std::string_view text) noexcept {
    int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole ? std::optional<int64_t>(value) : std::nullopt;
}

} // namespace toliman::ingest
