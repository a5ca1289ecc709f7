// Method: chunks are read from the first line that was not given, so that position_ and too_long_ are the whole state.
// The bytes of an unterminated line, at most kLongestLine, are read again when the file has grown; those of a longer
// line are skipped up to its newline, so that memory is bounded.
#include "ingest/side_file.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

#include "ingest/side_line.hpp"

namespace toliman::ingest {

namespace {

constexpr uint64_t kChunk = 65536;

} // namespace

void SideFile::give(const char *text, size_t length, const Sink &sink) {
    const bool is_blank =
        std::all_of(text, text + length, [](char byte) { return byte == ' ' || byte == '\t' || byte == '\r'; });
    if (too_long_ || !is_blank)
        sink(too_long_ ? std::string(kLongestLine + 1, ' ') : std::string(text, length), lines_ + 1);
    lines_++;
    position_ += length;
    too_long_ = false;
}

// Gives the complete lines. Returns the start of the unterminated one.
const char *SideFile::split(const char *text, const char *end, const Sink &sink) {
    while (const void *const newline = std::memchr(text, '\n', static_cast<size_t>(end - text))) {
        const auto length = static_cast<size_t>(static_cast<const char *>(newline) - text);
        give(text, length, sink);
        position_++;
        text += length + 1;
    }
    return text;
}

void SideFile::read(const file::Reader &file, uint64_t size, bool complete, const Sink &sink) {
    std::vector<char> chunk(static_cast<size_t>(std::min(kChunk, size - std::min(position_, size))));
    while (position_ < size) {
        const auto count = static_cast<size_t>(std::min<uint64_t>(chunk.size(), size - position_));
        file.read_exactly(position_, chunk.data(), count);
        const char *const end = chunk.data() + count, *const last = split(chunk.data(), end, sink);
        const auto rest = static_cast<size_t>(end - last);
        if (rest > kLongestLine || (too_long_ && rest > 0)) {
            too_long_ = true;
            position_ += rest;
        } else if (position_ + rest == size) {
            if (complete && rest > 0)
                give(last, rest, sink);
            break;
        }
    }
    if (complete && too_long_)
        give("", 0, sink);
}

} // namespace toliman::ingest
