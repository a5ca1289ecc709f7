// Method: the header names the columns, and each name contains its unit, so that no number depends on a convention that
// the file does not state. Positions and velocities are along the axes of the ICRS, from the Earth's centre. Every
// field is converted by itself; a line costs no more at the end of a file than at its beginning.
#include "sky/ephemeris_table.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "base/error.hpp"
#include "base/nearest_word.hpp"
#include "ingest/csv_table.hpp"
#include "sky/segment_builder.hpp"

namespace toliman::sky {

namespace {

using ingest::column_of;
using ingest::Fields;
using ingest::kMostFields;
using ingest::split_fields;
using ingest::TextLines;
using ingest::without_comment;

constexpr const char *kTimes[] = {"t_utc", "t_tai", "t_tt", "t_tdb", "t_gps", "t_tai_ns"}; // as ingest::kTimeKinds
constexpr const char *kPositions[2][3] = {{"x_km", "y_km", "z_km"}, {"x_m", "y_m", "z_m"}};
constexpr const char *kVelocities[2][3] = {{"vx_km_s", "vy_km_s", "vz_km_s"}, {"vx_m_s", "vy_m_s", "vz_m_s"}};
constexpr double kFactors[2] = {1000, 1};
constexpr const char *kAllowed =
    "one of t_tai_ns (integers), t_utc, t_tai, t_tt, t_tdb, t_gps (dates), with x_km,y_km,z_km or x_m,y_m,z_m and "
    "vx_km_s,vy_km_s,vz_km_s or vx_m_s,vy_m_s,vz_m_s, in any order";
constexpr size_t kColumns = 7, kNone = ingest::kNoColumn;

// Columns of the numbers of a state.
struct Columns {
    size_t time = kNone, time_kind = 0;
    size_t position[3] = {kNone, kNone, kNone}, velocity[3] = {kNone, kNone, kNone};
    size_t position_unit = 0, velocity_unit = 0;

    Units units() const noexcept { return {position_unit == 0 ? "km" : "m", velocity_unit == 0 ? "km/s" : "m/s"}; }
};

[[noreturn]] void fail_header(const TextLines &lines, const std::string &what) {
    fail(Status::format, "{%s}:%d: %s: the header must name %s", lines.path(), lines.number(), what.c_str(), kAllowed);
}

std::vector<std::string> all_names() {
    std::vector<std::string> names(std::begin(kTimes), std::end(kTimes));
    for (const auto *table : {&kPositions, &kVelocities})
        for (const auto &unit : *table)
            names.insert(names.end(), std::begin(unit), std::end(unit));
    return names;
}

// Finds a triple in one of its units, that of most of its columns. Returns 0 for km, 1 for m.
size_t find_triple(const char *const (&names)[2][3], const Fields &header, size_t count, const TextLines &lines,
                   size_t columns[3]) {
    size_t found[2] = {};
    for (size_t unit = 0; unit < 2; unit++)
        for (const char *name : names[unit])
            found[unit] += column_of(name, header, count) != kNone ? 1 : 0;
    const size_t unit = found[1] > found[0] ? 1 : 0;
    for (size_t k = 0; k < 3; k++) {
        columns[k] = column_of(names[unit][k], header, count);
        if (columns[k] == kNone)
            fail_header(lines, std::string("there is no column ") + names[unit][k]);
    }
    return unit;
}

Columns columns_of(std::string_view line, const TextLines &lines) {
    Fields header;
    const size_t count = split_fields(without_comment(line), header);
    const size_t kept = std::min(count, kMostFields);
    const std::vector<std::string> names = all_names();
    for (size_t i = 0; i < kept; i++) {
        const std::string name(header[i].substr(0, 60));
        if (std::find(names.begin(), names.end(), name) == names.end()) {
            const std::string near = nearest_word(name, names);
            fail_header(lines,
                        "unknown column \"" + name + "\"" + (near.empty() ? "" : ", did you mean " + near + "?"));
        }
        if (std::find(header.begin(), header.begin() + i, header[i]) != header.begin() + i)
            fail_header(lines, "duplicate column " + name);
    }
    Columns columns;
    for (size_t kind = 0; kind < std::size(kTimes); kind++)
        for (size_t i = 0; i < kept; i++) {
            if (header[i] != kTimes[kind])
                continue;
            if (columns.time != kNone)
                fail_header(lines,
                            std::string("two columns of time, ") + kTimes[columns.time_kind] + " and " + kTimes[kind]);
            columns.time = i;
            columns.time_kind = kind;
        }
    if (columns.time == kNone)
        fail_header(lines, "there is no column of time");
    columns.position_unit = find_triple(kPositions, header, kept, lines, columns.position);
    columns.velocity_unit = find_triple(kVelocities, header, kept, lines, columns.velocity);
    if (count != kColumns)
        fail_header(lines, "there are " + std::to_string(count) + " columns, not 7");
    return columns;
}

double value_of(std::string_view text, double factor, const char *name, const TextLines &lines) {
    const double value = number_of(text);
    if (!(value == value))
        fail(Status::format, "{%s}:%d: %s = \"%s\": must be a finite number", lines.path(), lines.number(), name,
             std::string(text.substr(0, 60)).c_str());
    return value * factor;
}

State state_of(const Fields &fields, const Columns &columns, const TextLines &lines) {
    State state;
    for (size_t k = 0; k < 3; k++) {
        state.position_m[k] = value_of(fields[columns.position[k]], kFactors[columns.position_unit],
                                       kPositions[columns.position_unit][k], lines);
        state.velocity_m_s[k] = value_of(fields[columns.velocity[k]], kFactors[columns.velocity_unit],
                                         kVelocities[columns.velocity_unit][k], lines);
    }
    return state;
}

} // namespace

std::vector<Segment> read_ephemeris_table(ingest::TextLines &lines, std::string_view first,
                                          const ingest::LeapSeconds &leap_seconds, const Log &log) {
    std::string_view line = first;
    while (without_comment(line).empty())
        if (!lines.next(line))
            fail(Status::format,
                 "{%s}: contains no states: must be a CCSDS Orbit Ephemeris Message, or a table whose "
                 "header names %s",
                 lines.path(), kAllowed);
    const Columns columns = columns_of(line, lines);
    SegmentBuilder builder(lines.path(), lines.number(), columns.units());
    while (lines.next(line)) {
        line = without_comment(line);
        if (line.empty())
            continue;
        Fields fields;
        const size_t count = split_fields(line, fields);
        if (count != kColumns)
            fail(Status::format, "{%s}:%d: %zu fields: must be 7, as in the header", lines.path(), lines.number(),
                 count);
        const int64_t tai_ns =
            ingest::time_of(fields[columns.time], columns.time_kind, kTimes[columns.time_kind], leap_seconds, lines);
        builder.add(tai_ns, state_of(fields, columns, lines), lines.number());
    }
    std::vector<Segment> segments;
    segments.push_back(builder.finish(log));
    return segments;
}

} // namespace toliman::sky
