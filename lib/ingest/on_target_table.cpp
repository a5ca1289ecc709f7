#include "ingest/on_target_table.hpp"

#include <iterator>
#include <string_view>

#include "base/error.hpp"
#include "ingest/csv_table.hpp"
#include "ingest/epoch.hpp"

namespace toliman::ingest {

namespace {

constexpr size_t kLargestWindowTable = size_t{1} << 28, kColumns = 2, kShown = 60;
constexpr const char *kAllowed =
    "start_tai_ns and end_tai_ns (integers), or start_utc and end_utc, or the same with tai, "
    "tt, tdb or gps instead of utc (dates)";

struct Columns {
    size_t start, end, kind;
    std::string start_name, end_name;
};

Columns columns_of(std::string_view line, const TextLines &lines) {
    Fields header;
    if (split_fields(line, header) == kColumns)
        for (size_t kind = 0; kind < std::size(kTimeKinds); kind++) {
            Columns columns = {0, 0, kind, std::string("start_") + kTimeKinds[kind],
                               std::string("end_") + kTimeKinds[kind]};
            columns.start = column_of(columns.start_name, header, kColumns);
            columns.end = column_of(columns.end_name, header, kColumns);
            if (columns.start != kNoColumn && columns.end != kNoColumn)
                return columns;
        }
    fail(Status::format, "{%s}:%d: \"%s\": the header must name exactly two columns: %s", lines.path(), lines.number(),
         std::string(line.substr(0, kShown)).c_str(), kAllowed);
}

OnTargetWindow window_of(std::string_view line, const Columns &columns, const LeapSeconds &leap_seconds,
                         const TextLines &lines) {
    Fields fields;
    const size_t count = split_fields(line, fields);
    if (count != kColumns)
        fail(Status::format, "{%s}:%d: %zu fields: must be exactly two columns, as in the header", lines.path(),
             lines.number(), count);
    const OnTargetWindow window = {
        time_of(fields[columns.start], columns.kind, columns.start_name.c_str(), leap_seconds, lines),
        time_of(fields[columns.end], columns.kind, columns.end_name.c_str(), leap_seconds, lines)};
    if (window.start_ns >= window.end_ns)
        fail(Status::format, "{%s}:%d: %s = %s: must be after %s = %s", lines.path(), lines.number(),
             columns.end_name.c_str(), std::string(fields[columns.end]).c_str(), columns.start_name.c_str(),
             std::string(fields[columns.start]).c_str());
    return window;
}

} // namespace

std::vector<OnTargetWindow> read_on_target(const std::string &path, const LeapSeconds &leap_seconds) {
    TextLines lines(path, kLargestWindowTable);
    std::vector<OnTargetWindow> windows;
    std::optional<Columns> columns;
    for (std::string_view line; lines.next(line);) {
        line = without_comment(line);
        if (line.empty())
            continue;
        if (!columns) {
            columns = columns_of(line, lines);
            continue;
        }
        const OnTargetWindow window = window_of(line, *columns, leap_seconds, lines);
        if (!windows.empty() && window.start_ns < windows.back().end_ns)
            fail(Status::format,
                 "{%s}:%d: %s: begins at %s TAI: must not begin before the end of the window before, %s TAI",
                 lines.path(), lines.number(), columns->start_name.c_str(), date_text(window.start_ns).c_str(),
                 date_text(windows.back().end_ns).c_str());
        windows.push_back(window);
    }
    if (windows.empty())
        fail(Status::format, "{%s}: contains no window: must be a table whose header names %s", path.c_str(), kAllowed);
    return windows;
}

} // namespace toliman::ingest
