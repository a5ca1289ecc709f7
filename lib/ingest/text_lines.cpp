#include "ingest/text_lines.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "backend/file.hpp"
#include "backend/zip.hpp"
#include "base/error.hpp"

namespace toliman::ingest {

namespace {

constexpr size_t kLookedAt = 4096; // bytes that tell whether a file is text

// Binary content must not get into messages. UTF-8 is text.
void check_is_text(const std::vector<uint8_t> &bytes, const char *path) {
    const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(std::min(bytes.size(), kLookedAt));
    const auto binary = std::find_if(bytes.begin(), end, [](uint8_t byte) {
        constexpr uint8_t kFirstBlank = 0x09, kLastBlank = 0x0d; // tab to carriage return
        return byte < 0x20 && (byte < kFirstBlank || byte > kLastBlank);
    });
    const bool is_bzip2 = bytes.size() >= 3 && std::equal(bytes.begin(), bytes.begin() + 3, "BZh");
    if (binary != end || is_bzip2)
        fail(Status::format, "{%s}: is not a text file: must be text, also compressed with gzip", path);
}

} // namespace

TextLines::TextLines(const std::string &path, size_t limit) : path_(path), bytes_(file::read(path, limit)) {
    if (zip::is_gzip(bytes_))
        bytes_ = zip::gunzip(bytes_, limit, path.c_str());
    check_is_text(bytes_, path.c_str());
    constexpr unsigned char kByteOrderMark[] = {0xef, 0xbb, 0xbf};
    if (bytes_.size() >= 3 && std::equal(bytes_.begin(), bytes_.begin() + 3, kByteOrderMark))
        at_ = 3;
}

TextLines::TextLines(std::string path, const std::string &text, std::vector<int> numbers)
    : path_(std::move(path)), bytes_(text.begin(), text.end()), numbers_(std::move(numbers)) {}

bool TextLines::next(std::string_view &line) noexcept {
    const std::string_view text = rest();
    if (text.empty())
        return false;
    const size_t end = std::min(text.find('\n'), text.size());
    line = trimmed(text.substr(0, end));
    at_ += end + 1;
    count_++;
    return true;
}

} // namespace toliman::ingest
