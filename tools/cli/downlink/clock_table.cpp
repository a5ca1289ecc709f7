#include "downlink/clock_table.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>

#include "common/failure.hpp"
#include "common/lines.hpp"
#include "series/columns.hpp"

namespace cli {

namespace {

constexpr uint64_t kLongest = uint64_t{1} << 62; // ns from pair to pair, 146 years: the most that a tracker takes
constexpr double kMostDrift = 0.01;

struct Point {
    int line;
    int64_t camera_ns, tai_ns;
};

int64_t whole_of(const std::string &field, const LinePlace &where) {
    int64_t value = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size())
        malformed(where.text(), "must be camera_ns,tai_ns, two whole numbers of 64 bits");
    return value;
}

Point point_of(const std::vector<std::string> &fields, const LinePlace &where) {
    if (fields.size() != 2)
        malformed(where.text(), "must be camera_ns,tai_ns, two whole numbers of 64 bits");
    return {where.number, whole_of(fields[0], where), whole_of(fields[1], where)};
}

bool is_header(const std::vector<std::string> &fields) {
    return fields.front().find_first_of("-0123456789") != 0;
}

struct Table {
    std::string file; // as messages call it
    std::vector<Point> points;
};

Table read_table(const std::string &path) {
    LineSource lines(path, stop_if_asked);
    Table table = {lines.name(), {}};
    bool begun = false;
    int number = 0;
    for (std::string line; lines.next(line);) {
        const LinePlace where = {lines.name(), ++number};
        if (line.size() > LineSource::kLongest)
            malformed(where.text(), "is longer than " + std::to_string(LineSource::kLongest) + " bytes");
        const std::vector<std::string> fields = split(line.substr(0, line.find('#')), ',');
        if (fields.size() == 1 && fields.front().empty()) // blank, or a remark
            continue;
        if (begun || !is_header(fields))
            table.points.push_back(point_of(fields, where));
        else if (fields != std::vector<std::string>{"camera_ns", "tai_ns"})
            malformed(where.text(), "the header must be camera_ns,tai_ns, in this order");
        begun = true;
    }
    if (table.points.empty())
        malformed(lines.name(), "holds no pair camera_ns,tai_ns");
    return table;
}

bool rises(int64_t before, int64_t after) noexcept {
    return after > before && static_cast<uint64_t>(after) - static_cast<uint64_t>(before) <= kLongest;
}

void check_rising(const std::string &file, const Point &before, const Point &after) {
    if (!rises(before.camera_ns, after.camera_ns) || !rises(before.tai_ns, after.tai_ns))
        malformed(LinePlace{file, after.line}.text(),
                  std::to_string(after.camera_ns) + "," + std::to_string(after.tai_ns) +
                      ": must lie after the pair before, " + std::to_string(before.camera_ns) + "," +
                      std::to_string(before.tai_ns) + ", in both columns, by 2^62 ns at most");
}

// Of TAI in the camera's time, from pair to pair.
double rate(const Point &before, const Point &after) noexcept {
    return static_cast<double>(after.tai_ns - before.tai_ns) / static_cast<double>(after.camera_ns - before.camera_ns);
}

} // namespace

std::vector<int64_t> read_clock(const std::string &path, Progress &progress) {
    if (path.empty())
        return {};
    if (path == "camera")
        return {0, 0};
    std::vector<int64_t> clock;
    const Table table = read_table(path);
    const std::vector<Point> &points = table.points;
    clock.reserve(2 * points.size());
    const Point *odd = nullptr;
    for (size_t i = 0; i < points.size(); i++) {
        clock.insert(clock.end(), {points[i].camera_ns, points[i].tai_ns});
        if (i == 0)
            continue;
        check_rising(table.file, points[i - 1], points[i]);
        if (odd == nullptr && std::fabs(rate(points[i - 1], points[i]) - 1) > kMostDrift)
            odd = &points[i];
    }
    if (odd != nullptr) {
        char text[160];
        std::snprintf(text, sizeof text,
                      ": from the pair before TAI goes on by %.6g ns a ns of the camera's clock: are both columns in "
                      "ns, the camera's first?",
                      rate(odd[-1], *odd));
        progress.warn(LinePlace{table.file, odd->line}.text() + text);
    }
    return clock;
}

} // namespace cli
