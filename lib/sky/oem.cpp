// Method: the file is read once, line by line, and a keyword decides which part of the message follows. Everything that
// changes the meaning of the numbers is refused by name instead of being converted: a centre other than the Earth, axes
// other than those of the ICRS, and time systems that need tables of the Earth's rotation. The axes of EME2000, also
// called J2000, differ from those of the ICRS by 23 mas, 1 mm/s. The standard forbids units in the file; numbers are in
// km, km/s and km/s^2. Keywords may be in any order; accelerations, covariances and the recommended interpolation are
// not used. Reference: CCSDS 502.0-B-3, Orbit Data Messages, ch. 5 and 7.
#include "sky/oem.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "base/nearest_word.hpp"
#include "ingest/epoch.hpp"
#include "ingest/time_text.hpp"
#include "sky/segment_builder.hpp"

namespace toliman::sky {

namespace {

using ingest::Scale;
using ingest::TextLines;

constexpr Units kUnits = {"km", "km/s"};

// The value of a keyword; line 0: absent.
struct Value {
    std::string text;
    int line = 0;
};

struct Keyword {
    const char *name;
    bool is_mandatory;
};

enum Header { kCreationDate, kOriginator, kClassification, kMessageId, kHeaderKeywords };
constexpr Keyword kHeader[kHeaderKeywords] = {
    {"CREATION_DATE", true}, {"ORIGINATOR", true}, {"CLASSIFICATION", false}, {"MESSAGE_ID", false}};

enum Metadata {
    kObjectName,
    kObjectId,
    kCenterName,
    kRefFrame,
    kTimeSystem,
    kStartTime,
    kStopTime,
    kRefFrameEpoch,
    kUseableStartTime,
    kUseableStopTime,
    kInterpolation,
    kInterpolationDegree,
    kMetadataKeywords
};
constexpr Keyword kMetadata[kMetadataKeywords] = {
    {"OBJECT_NAME", true},        {"OBJECT_ID", true},        {"CENTER_NAME", true},
    {"REF_FRAME", true},          {"TIME_SYSTEM", true},      {"START_TIME", true},
    {"STOP_TIME", true},          {"REF_FRAME_EPOCH", false}, {"USEABLE_START_TIME", false},
    {"USEABLE_STOP_TIME", false}, {"INTERPOLATION", false},   {"INTERPOLATION_DEGREE", false}};

// Names that begin so are refused for this reason.
struct Refused {
    const char *begin, *reason;
};

constexpr const char *kOfDate =
    "axes of date differ from those of the ICRS by up to 32 m/s, 1.06 uas: convert the states to GCRF";
constexpr const char *kRotating =
    "axes that rotate with the Earth make velocities wrong by 500 m/s, 17 uas: convert the "
    "states to GCRF";
constexpr const char *kElsewhere = "its origin is not the Earth's centre: convert the states to GCRF";
constexpr Refused kRefusedFrames[] = {
    {"TEME", kOfDate},   {"TOD", kOfDate},   {"MOD", kOfDate},    {"TDR", kRotating},
    {"ITRF", kRotating}, {"GRC", kRotating}, {"WGS", kRotating},  {"ECEF", kRotating},
    {"ECF", kRotating},  {"EFG", kRotating}, {"GTOD", kRotating}, {"MCI", kElsewhere},
};
constexpr const char *kAxes[] = {"ICRF", "GCRF", "EME2000", "J2000"};

constexpr const char *kOnboard = "a clock on board has no known relation to TAI";
constexpr const char *kEarthRotation = "it follows the rotation of the Earth, within 0.9 s of UTC: 0.9 s are 7 m/s";
constexpr const char *kOtherRate = "it has another rate, and has advanced by more than 1 s against TT";
constexpr Refused kRefusedTimes[] = {
    {"UT1", kEarthRotation}, {"GMST", kEarthRotation}, {"MET", kOnboard},   {"MRT", kOnboard},
    {"SCLK", kOnboard},      {"TCB", kOtherRate},      {"TCG", kOtherRate},
};
constexpr const char *kTimeSystems[] = {"UTC", "TAI", "TT", "TDB", "GPS"}; // in the order of Scale

std::string upper(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
    return out;
}

// Why a name is refused; NULL if it is unknown.
template <size_t kCount> const char *reason_of(const Refused (&table)[kCount], const std::string &name) noexcept {
    for (const Refused &row : table)
        if (name.compare(0, std::string_view(row.begin).size(), row.begin) == 0)
            return row.reason;
    return nullptr;
}

// "reason; ", or nothing.
std::string before_rule(const char *reason) {
    return reason == nullptr ? "" : std::string(reason) + "; ";
}

class OemReader {
  public:
    OemReader(TextLines &lines, const ingest::LeapSeconds &leap_seconds, const Log &log)
        : lines_(lines), leap_seconds_(leap_seconds), log_(log) {}

    std::vector<Segment> read(std::string_view first) {
        check_version(first);
        std::array<Value, kHeaderKeywords> header;
        read_keywords(kHeader, header, "META_START");
        std::vector<Segment> segments;
        while (line_ == "META_START")
            read_segment(segments);
        return segments;
    }

  private:
    ingest::TextPlace place() const noexcept { return {lines_.path(), lines_.number()}; }
    ingest::TextPlace place(const Value &value) const noexcept { return {lines_.path(), value.line}; }

    // The next line with content; comments are skipped.
    bool next() {
        do
            if (!lines_.next(line_)) {
                line_ = {};
                return false;
            }
        while (line_.empty() || line_ == "COMMENT" || line_.substr(0, 8) == "COMMENT ");
        return true;
    }

    void check_version(std::string_view first) const {
        constexpr std::string_view kKeyword = "CCSDS_OEM_VERS";
        const std::string shown(first.substr(0, 60));
        if (first.substr(0, kKeyword.size()) != kKeyword)
            fail(Status::format, "{%s}:%d: \"%s\": must be an Orbit Ephemeris Message, CCSDS_OEM_VERS = 2.0",
                 lines_.path(), lines_.number(), shown.c_str());
        const size_t equals = first.find('=');
        const std::string_view version =
            equals == std::string_view::npos ? "" : TextLines::trimmed(first.substr(equals + 1));
        const bool alone = TextLines::trimmed(first.substr(0, equals)) == kKeyword;
        if (!alone || (version != "1.0" && version != "2.0" && version != "3.0"))
            fail(Status::format, "{%s}:%d: \"%s\": CCSDS_OEM_VERS must be 1.0, 2.0 or 3.0", lines_.path(),
                 lines_.number(), shown.c_str());
    }

    // Reads KEYWORD = value up to the line `end`.
    template <size_t kCount>
    void read_keywords(const Keyword (&keywords)[kCount], std::array<Value, kCount> &values, const char *end) {
        while (next() && line_ != end)
            read_keyword(keywords, values, end);
        if (line_ != end)
            fail(Status::format, "{%s}:%d: the file ends before %s", lines_.path(), lines_.number(), end);
        for (size_t i = 0; i < kCount; i++)
            if (keywords[i].is_mandatory && values[i].line == 0)
                fail(Status::format, "{%s}:%d: %s is missing before %s", lines_.path(), lines_.number(),
                     keywords[i].name, end);
    }

    template <size_t kCount>
    void read_keyword(const Keyword (&keywords)[kCount], std::array<Value, kCount> &values, const char *end) {
        const size_t equals = line_.find('=');
        const std::string name(TextLines::trimmed(line_.substr(0, equals)).substr(0, 60));
        if (equals == std::string_view::npos)
            fail(Status::format, "{%s}:%d: \"%s\": must be KEYWORD = value or %s", lines_.path(), lines_.number(),
                 name.c_str(), end);
        const auto *const keyword = std::find_if(std::begin(keywords), std::end(keywords),
                                                 [&](const Keyword &known) { return known.name == name; });
        if (keyword == std::end(keywords))
            fail_keyword(keywords, name);
        Value &value = values[static_cast<size_t>(keyword - keywords)];
        if (value.line != 0)
            fail(Status::format, "{%s}:%d: %s: duplicate keyword, first in line %d", lines_.path(), lines_.number(),
                 name.c_str(), value.line);
        value = {std::string(TextLines::trimmed(line_.substr(equals + 1))), lines_.number()};
        if (value.text.empty())
            fail(Status::format, "{%s}:%d: %s has no value", lines_.path(), lines_.number(), name.c_str());
    }

    template <size_t kCount>
    [[noreturn]] void fail_keyword(const Keyword (&keywords)[kCount], const std::string &name) const {
        std::vector<std::string> names;
        for (const Keyword &keyword : keywords)
            names.emplace_back(keyword.name);
        const std::string near = nearest_word(name, names);
        std::string list;
        for (const std::string &known : names)
            list += (list.empty() ? "" : ", ") + known;
        fail(Status::format, "{%s}:%d: %s: unknown keyword%s%s%s: must be one of %s", lines_.path(), lines_.number(),
             name.c_str(), near.empty() ? "" : ", did you mean ", near.c_str(), near.empty() ? "" : "?", list.c_str());
    }

    void check_names(const std::array<Value, kMetadataKeywords> &values) {
        const Value &centre = values[kCenterName], &frame = values[kRefFrame], &object = values[kObjectId];
        if (upper(centre.text) != "EARTH")
            fail(Status::format, "{%s}:%d: CENTER_NAME = %.60s: must be EARTH", lines_.path(), centre.line,
                 centre.text.c_str());
        const std::string axes = upper(frame.text);
        if (std::find(std::begin(kAxes), std::end(kAxes), axes) == std::end(kAxes))
            fail(Status::format, "{%s}:%d: REF_FRAME = %.60s: %smust be ICRF, GCRF, EME2000 or J2000", lines_.path(),
                 frame.line, frame.text.c_str(), before_rule(reason_of(kRefusedFrames, axes)).c_str());
        if (!object_.empty() && object.text != object_)
            fail(Status::format, "{%s}:%d: OBJECT_ID = %.60s: must be %.60s in all segments", lines_.path(),
                 object.line, object.text.c_str(), object_.c_str());
        object_ = object.text;
    }

    Scale time_system(const Value &value) {
        const std::string name = upper(value.text);
        const auto *const found = std::find(std::begin(kTimeSystems), std::end(kTimeSystems), name);
        if (found == std::end(kTimeSystems))
            fail(Status::format, "{%s}:%d: TIME_SYSTEM = %.60s: %smust be UTC, TAI, TT, TDB or GPS", lines_.path(),
                 value.line, value.text.c_str(), before_rule(reason_of(kRefusedTimes, name)).c_str());
        const auto scale = static_cast<Scale>(found - kTimeSystems);
        if (scale_.value_or(scale) != scale)
            fail(Status::format, "{%s}:%d: TIME_SYSTEM = %.60s: must be %s in all segments", lines_.path(), value.line,
                 value.text.c_str(), kTimeSystems[static_cast<size_t>(*scale_)]);
        scale_ = scale;
        return scale;
    }

    int64_t time_of(const Value &value, const char *name) const {
        return ingest::parse_epoch(value.text, *scale_, leap_seconds_, place(value), name);
    }

    // From the line META_START to the next one or the end of the file.
    void read_segment(std::vector<Segment> &segments) {
        const ingest::TextPlace begin = place();
        std::array<Value, kMetadataKeywords> values;
        read_keywords(kMetadata, values, "META_STOP");
        check_names(values);
        time_system(values[kTimeSystem]);
        const int64_t start = time_of(values[kStartTime], "START_TIME"), stop = time_of(values[kStopTime], "STOP_TIME");
        if (start >= stop)
            fail(Status::format, "{%s}:%d: STOP_TIME = %s: must be after START_TIME", lines_.path(),
                 values[kStopTime].line, values[kStopTime].text.c_str());
        SegmentBuilder builder(lines_.path(), begin.line, kUnits);
        while (next() && line_ != "META_START") {
            if (line_ == "COVARIANCE_START")
                skip_covariance();
            else
                read_state(start, stop, builder);
        }
        Segment segment = builder.finish(log_);
        limit(values, start, stop, segment);
        append_segment(segments, std::move(segment), begin);
    }

    void skip_covariance() {
        const int begin = lines_.number();
        while (next() && line_ != "COVARIANCE_STOP")
            ;
        if (line_ != "COVARIANCE_STOP")
            fail(Status::format, "{%s}:%d: the file ends before COVARIANCE_STOP", lines_.path(), begin);
    }

    void read_state(int64_t start, int64_t stop, SegmentBuilder &builder) const {
        constexpr size_t kMostWords = 10;
        std::array<std::string_view, kMostWords> fields;
        size_t count = 0;
        for (std::string_view rest = line_; !rest.empty(); count++) {
            const size_t end = ingest::first_field(rest);
            if (count < kMostWords)
                fields[count] = rest.substr(0, end);
            rest = TextLines::trimmed(rest.substr(end));
        }
        std::array<double, kMostWords> numbers = {};
        bool good = count == 7 || count == kMostWords;
        for (size_t i = 1; good && i < count; i++) {
            numbers[i] = number_of(fields[i]);
            good = numbers[i] == numbers[i];
        }
        if (!good)
            fail(Status::format,
                 "{%s}:%d: \"%s\": must be a time and 6 or 9 finite numbers, META_START or COVARIANCE_START",
                 lines_.path(), lines_.number(), std::string(line_.substr(0, 60)).c_str());
        const int64_t tai_ns = ingest::parse_epoch(fields[0], *scale_, leap_seconds_, place(), "time");
        if (tai_ns < start || tai_ns > stop)
            fail(Status::format, "{%s}:%d: the time %s is outside START_TIME to STOP_TIME", lines_.path(),
                 lines_.number(), std::string(fields[0]).c_str());
        State state;
        for (size_t k = 0; k < 3; k++) {
            state.position_m[k] = numbers[1 + k] * 1000;
            state.velocity_m_s[k] = numbers[4 + k] * 1000;
        }
        builder.add(tai_ns, state, lines_.number());
    }

    // Restricts the segment to its usable times.
    void limit(const std::array<Value, kMetadataKeywords> &values, int64_t start, int64_t stop,
               Segment &segment) const {
        const Value &first = values[kUseableStartTime], &last = values[kUseableStopTime];
        const int64_t begin = segment.first_ns, end = segment.last_ns;
        if (first.line != 0)
            segment.first_ns = usable(first, kMetadata[kUseableStartTime].name, start, stop, begin, end);
        if (last.line != 0)
            segment.last_ns = usable(last, kMetadata[kUseableStopTime].name, start, stop, begin, end);
        if (segment.first_ns >= segment.last_ns)
            fail(Status::format, "{%s}:%d: USEABLE_STOP_TIME must be after USEABLE_START_TIME", lines_.path(),
                 std::max(first.line, last.line));
    }

    int64_t usable(const Value &value, const char *name, int64_t start, int64_t stop, int64_t begin,
                   int64_t end) const {
        const int64_t tai_ns = time_of(value, name);
        if (tai_ns < start || tai_ns > stop)
            fail(Status::format, "{%s}:%d: %s = %s: must be from START_TIME to STOP_TIME", lines_.path(), value.line,
                 name, value.text.c_str());
        if (tai_ns < begin || tai_ns > end)
            fail(Status::format, "{%s}:%d: %s = %s: must be from the first to the last state of the segment",
                 lines_.path(), value.line, name, value.text.c_str());
        return tai_ns;
    }

    TextLines &lines_;
    const ingest::LeapSeconds &leap_seconds_;
    const Log &log_;
    std::string_view line_; // the current one
    std::string object_;    // of the segments before
    std::optional<Scale> scale_;
};

} // namespace

std::vector<Segment> read_oem(ingest::TextLines &lines, std::string_view first, const ingest::LeapSeconds &leap_seconds,
                              const Log &log) {
    return OemReader(lines, leap_seconds, log).read(first);
}

} // namespace toliman::sky
