#include "ingest/clock_table.hpp"

#include <cmath>
#include <optional>
#include <string_view>

#include "ingest/text_lines.hpp"

namespace toliman::ingest {

namespace {

constexpr size_t kLargestClockTable = size_t{1} << 30;
constexpr uint64_t kLargestPairStep = uint64_t{1}
                                      << 62; // ns from pair to pair, 146 years: the most that a tracker takes
constexpr double kMostDrift = 0.01;

struct TwoFields {
    std::string_view first, second; // trimmed
    bool two;                       // exactly one comma
};

TwoFields fields_of(std::string_view line) noexcept {
    const size_t comma = line.find(',');
    if (comma == std::string_view::npos)
        return {line, {}, false};
    const std::string_view second = line.substr(comma + 1);
    return {TextLines::trimmed(line.substr(0, comma)), TextLines::trimmed(second),
            second.find(',') == std::string_view::npos};
}

bool is_header(const TwoFields &fields) noexcept {
    return fields.first.find_first_of("-0123456789") != 0;
}

void check_header(const TwoFields &fields, const TextLines &lines) {
    if (!fields.two || fields.first != "camera_ns" || fields.second != "tai_ns")
        fail(Status::format, "{%s}:%d: the header must be camera_ns,tai_ns, in this order", lines.path(),
             lines.number());
}

ClockPair pair_of(const TwoFields &fields, const TextLines &lines) {
    const std::optional<int64_t> camera_ns = integer_of(fields.first), tai_ns = integer_of(fields.second);
    if (!fields.two || !camera_ns || !tai_ns)
        fail(Status::format, "{%s}:%d: must be camera_ns,tai_ns, two integers of 64 bits", lines.path(),
             lines.number());
    return {*camera_ns, *tai_ns};
}

bool increases(int64_t before, int64_t after) noexcept {
    return after > before && static_cast<uint64_t>(after) - static_cast<uint64_t>(before) <= kLargestPairStep;
}

void check_increasing(const ClockPair &before, const ClockPair &after, const TextLines &lines) {
    if (!increases(before.camera_ns, after.camera_ns) || !increases(before.tai_ns, after.tai_ns))
        fail(Status::format,
             "{%s}:%d: %lld,%lld: must exceed the pair before, %lld,%lld, in both columns, by 2^62 ns at most",
             lines.path(), lines.number(), static_cast<long long>(after.camera_ns),
             static_cast<long long>(after.tai_ns), static_cast<long long>(before.camera_ns),
             static_cast<long long>(before.tai_ns));
}

// TAI per camera time between two pairs.
double rate(const ClockPair &before, const ClockPair &after) noexcept {
    return static_cast<double>(after.tai_ns - before.tai_ns) / static_cast<double>(after.camera_ns - before.camera_ns);
}

// False if the rate is as expected.
bool warn_of_rate(const ClockPair &before, const ClockPair &after, const TextLines &lines, const Log &log) {
    const double found = rate(before, after);
    if (std::fabs(found - 1) <= kMostDrift)
        return false;
    log.warn("%s:%d: TAI advances by %.6g ns per ns of camera time since the pair before: both columns must be in ns, "
             "the camera's first",
             lines.path(), lines.number(), found);
    return true;
}

} // namespace

std::vector<ClockPair> read_clock_table(const std::string &path, const Log &log) {
    TextLines lines(path, kLargestClockTable);
    std::vector<ClockPair> pairs;
    bool begun = false, warned = false;
    for (std::string_view line; lines.next(line);) {
        line = TextLines::trimmed(line.substr(0, line.find('#')));
        if (line.empty())
            continue;
        const TwoFields fields = fields_of(line);
        const bool header = !begun && is_header(fields);
        begun = true;
        if (header) {
            check_header(fields, lines);
            continue;
        }
        const ClockPair pair = pair_of(fields, lines);
        if (!pairs.empty()) {
            check_increasing(pairs.back(), pair, lines);
            warned = warned || warn_of_rate(pairs.back(), pair, lines, log);
        }
        pairs.push_back(pair);
    }
    if (pairs.empty())
        fail(Status::format, "{%s}: contains no pair camera_ns,tai_ns", path.c_str());
    return pairs;
}

} // namespace toliman::ingest
