#include "ingest/csv_table.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "base/error.hpp"
#include "ingest/epoch.hpp"

namespace toliman::ingest {

size_t split_fields(std::string_view line, Fields &fields) noexcept {
    size_t count = 0, at = 0;
    while (at <= line.size()) {
        const size_t end = std::min(line.find(',', at), line.size());
        if (count < kMostFields)
            fields[count] = TextLines::trimmed(line.substr(at, end - at));
        count++;
        at = end + 1;
    }
    return count;
}

std::string_view without_comment(std::string_view line) noexcept {
    return TextLines::trimmed(line.substr(0, line.find('#')));
}

size_t column_of(std::string_view name, const Fields &header, size_t count) noexcept {
    const auto *const found = std::find(header.begin(), header.begin() + count, name);
    return found == header.begin() + count ? kNoColumn : static_cast<size_t>(found - header.begin());
}

int64_t time_of(std::string_view text, size_t kind, const char *name, const LeapSeconds &leap_seconds,
                const TextLines &lines) {
    constexpr size_t kNanoseconds = std::size(kTimeKinds) - 1;
    if (kind != kNanoseconds)
        return parse_epoch(text, static_cast<Scale>(kind), leap_seconds, {lines.path(), lines.number()}, name);
    const std::optional<int64_t> ns = integer_of(text);
    if (!ns || !to_tai(*ns, Scale::tai, leap_seconds))
        fail(
            Status::format,
            "{%s}:%d: %s = \"%s\": must be an integer, nanoseconds since 1970-01-01T00:00:00 TAI, of the years 1958 to "
            "2099",
            lines.path(), lines.number(), name, std::string(text.substr(0, 60)).c_str());
    return *ns;
}

} // namespace toliman::ingest
