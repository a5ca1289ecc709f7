// Method: the states are the lines between $$SOE and $$EOE; the line of column names is the last one before $$SOE that
// is neither blank nor of asterisks. Horizons also writes tables of other centres, axes, units and kinds of states,
// which its text before the table states: such a line, if it is there, must have the value that an observer needs.
// Reference: https://ssd.jpl.nasa.gov/horizons/manual.html, "Vector Table Output".
#include "sky/horizons.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>

#include "base/error.hpp"
#include "ingest/csv_table.hpp"
#include "ingest/epoch.hpp"
#include "ingest/time_text.hpp"
#include "sky/segment_builder.hpp"

namespace toliman::sky {

namespace {

using ingest::Fields;
using ingest::kMostFields;
using ingest::TextLines;

constexpr std::string_view kStart = "$$SOE", kEnd = "$$EOE";
constexpr const char *kColumnNames[] = {"JDTDB", "X", "Y", "Z", "VX", "VY", "VZ"};
constexpr size_t kTableColumns = std::size(kColumnNames);
constexpr const char *kRules =
    "must be a CSV table of geometric states, from the Earth's centre, on axes of the ICRF, in km and km/s";

// Lines of the text before the table, and a part that their value must have.
struct Statement {
    std::string_view key, value;
};
constexpr Statement kStatements[] = {{"Center body name", "(399)"},
                                     {"Center-site name", "BODY CENTER"},
                                     {"Output units", "KM-S"},
                                     {"Output type", "GEOMETRIC"},
                                     {"Reference frame", "ICRF"}};

using TableColumns = std::array<size_t, kTableColumns>;

[[noreturn]] void refuse(const TextLines &lines, const std::string &what) {
    fail(Status::format, "{%s}:%d: %.140s: a table of Horizons %s", lines.path(), lines.number(), what.c_str(), kRules);
}

void check_statement(const TextLines &lines, std::string_view line) {
    for (const auto &[key, value] : kStatements) {
        const std::string_view stated = line.substr(std::min(line.find(':'), line.size()));
        if (line.substr(0, key.size()) == key && stated.find(value) == std::string_view::npos)
            refuse(lines, "\"" + std::string(line.substr(0, 60)) + "\"");
    }
}

TableColumns columns_of(const TextLines &lines, std::string_view header) {
    Fields fields;
    const size_t count = std::min(ingest::split_fields(header, fields), kMostFields);
    TableColumns columns;
    for (size_t k = 0; k < kTableColumns; k++) {
        columns[k] = ingest::column_of(kColumnNames[k], fields, count);
        if (columns[k] == ingest::kNoColumn)
            refuse(lines, std::string("no column ") + kColumnNames[k] + " before $$SOE");
    }
    return columns;
}

int64_t time_of(const TextLines &lines, std::string_view text, const ingest::LeapSeconds &leap_seconds) {
    try {
        return ingest::parse_time(std::string(text).c_str(), ingest::TimeFormat::jd, ingest::Scale::tdb, leap_seconds);
    } catch (const Error &error) {
        if (error.status() != Status::format && error.status() != Status::range)
            throw;
        refuse(lines, "JDTDB = \"" + std::string(text.substr(0, 40)) + "\": must be a Julian Day of 1958 to 2099");
    }
}

} // namespace

bool is_horizons(std::string_view text) noexcept {
    for (size_t at = text.find(kStart); at != std::string_view::npos; at = text.find(kStart, at + 1))
        if (at == 0 || text[at - 1] == '\n')
            return true;
    return false;
}

std::vector<Segment> read_horizons(TextLines &lines, std::string_view first, const ingest::LeapSeconds &leap_seconds,
                                   const Log &log) {
    std::string_view line = first, header;
    for (bool more = true; line != kStart; more = lines.next(line)) {
        if (!more)
            refuse(lines, "$$SOE is missing");
        check_statement(lines, line);
        if (line.find_first_not_of("* ") != std::string_view::npos)
            header = line;
    }
    const TableColumns columns = columns_of(lines, header);
    SegmentBuilder builder(lines.path(), lines.number(), {"km", "km/s"});
    for (;;) {
        if (!lines.next(line))
            refuse(lines, "the file ends before $$EOE");
        if (line == kEnd)
            break;
        Fields fields;
        const size_t count = std::min(ingest::split_fields(line, fields), kMostFields);
        std::array<double, kTableColumns> numbers = {};
        for (size_t k = 1; k < kTableColumns; k++) {
            numbers[k] = columns[k] < count ? number_of(fields[columns[k]]) * 1000 : NAN;
            if (!(numbers[k] == numbers[k]))
                refuse(lines, std::string(kColumnNames[k]) + " is not a finite number");
        }
        builder.add(time_of(lines, columns[0] < count ? fields[columns[0]] : "", leap_seconds),
                    {{numbers[1], numbers[2], numbers[3]}, {numbers[4], numbers[5], numbers[6]}}, lines.number());
    }
    while (lines.next(line))
        if (line == kStart)
            fail(Status::format, "{%s}:%d: a second $$SOE: must have one table of states", lines.path(),
                 lines.number());
    std::vector<Segment> segments;
    segments.push_back(builder.finish(log));
    return segments;
}

} // namespace toliman::sky
