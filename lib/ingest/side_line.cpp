#include "ingest/side_line.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "backend/json.hpp"
#include "base/error.hpp"
#include "base/name.hpp"

namespace toliman::ingest {

namespace {

using json::Value;

constexpr const char *kKeys[] = {
    "frame_id",   "timestamp_ns", "host_time",  "nframes_dropped", "roi_label",  "n_rows",       "n_cols",
    "session_id", "on_target_s",  "exposure_s", "frames",          "jitter_px2", "cumulants_px", "dtype"};
constexpr double kMostFrames = 1e12, kMostVariance = 4; // of a sum of frames

const Value &member(const Value &object, const char *key) {
    const Value *const value = object.find(key);
    if (value == nullptr)
        fail(Status::format, "%s is missing", key);
    return *value;
}

int64_t integer(const Value &object, const char *key, int64_t least = INT64_MIN, int64_t most = INT64_MAX) {
    const Value &value = member(object, key);
    if (value.kind != Value::Kind::number)
        fail(Status::format, "%s must be an integer", key);
    if (!value.integer)
        fail(Status::format, "%s must be an integer of 64 bits, not %g", key, value.number);
    if (*value.integer < least || *value.integer > most)
        fail(Status::format, "%s must be in [%lld, %lld], not %lld", key, static_cast<long long>(least),
             static_cast<long long>(most), static_cast<long long>(*value.integer));
    return *value.integer;
}

const char *name(const Value &object, const char *key, std::set<std::string> &names) {
    const Value &value = member(object, key);
    if (value.kind != Value::Kind::text || !is_name(value.text))
        fail(Status::format, "%s %s", key, kNameRule);
    return names.insert(value.text).first->c_str();
}

// Checks what toliman_track_push requires of the intervals of a frame.
std::shared_ptr<const std::vector<double>> on_target(const Value &object, double exposure_s) {
    const Value *const list = object.find("on_target_s");
    if (list == nullptr)
        return {};
    if (list->kind != Value::Kind::array || list->items.size() % 2 != 0 || list->items.empty() ||
        list->items.size() > 2 * kMostIntervals)
        fail(Status::format, "on_target_s must be an array of 2 to %zu numbers, start and end of each interval in turn",
             2 * kMostIntervals);
    if (!(exposure_s > 0))
        fail(Status::format, "on_target_s needs the length of the exposure: exposure_s, or --exposure of toliman");
    std::vector<double> times;
    for (const Value &item : list->items) {
        const size_t i = times.size();
        if (item.kind != Value::Kind::number)
            fail(Status::format, "on_target_s[%zu] must be a number", i);
        const double least = i > 0 ? times.back() : 0, time = item.number;
        const bool is_end = i % 2 == 1;
        if (!(is_end ? time > least : time >= least))
            fail(Status::format, "on_target_s[%zu] must be %s %.9g s, not %.9g s", i, is_end ? "above" : "at least",
                 least, time);
        if (!(time <= exposure_s))
            fail(Status::format, "on_target_s[%zu] must be within the exposure of %.9g s, not %.9g s", i, exposure_s,
                 time);
        times.push_back(time);
    }
    return std::make_shared<const std::vector<double>>(std::move(times));
}

// For messages: short, in ASCII, as UTF-8 may be cut.
std::string printable(const std::string &key) {
    std::string text = key.substr(0, 64);
    for (char &byte : text)
        if (const auto code = static_cast<unsigned char>(byte); code < 0x20 || code >= 0x7f)
            byte = '?';
    return text;
}

// 0 without the key.
size_t pixel_bytes(const Value &object) {
    const Value *const type = object.find("dtype");
    if (type == nullptr)
        return 0;
    if (type->kind == Value::Kind::text && type->text == "u16le")
        return 2;
    if (type->kind == Value::Kind::text && type->text == "u32le")
        return 4;
    fail(Status::format, "dtype must be \"u16le\" or \"u32le\"");
}

double optional_number(const Value &object, const char *key, double least, double most) {
    const Value *const value = object.find(key);
    if (value == nullptr)
        return 0;
    if (value->kind != Value::Kind::number || !(value->number >= least && value->number <= most))
        fail(Status::format, "%s must be a number in [%g, %g]", key, least, most);
    return value->number;
}

// `count` numbers; false without the key.
bool numbers(const Value &object, const char *key, size_t count, double *out) {
    const Value *const list = object.find(key);
    if (list == nullptr)
        return false;
    if (list->kind != Value::Kind::array || list->items.size() != count)
        fail(Status::format, "%s must be an array of %zu numbers", key, count);
    for (size_t i = 0; i < count; i++) {
        if (list->items[i].kind != Value::Kind::number)
            fail(Status::format, "%s[%zu] must be a number", key, i);
        out[i] = list->items[i].number;
    }
    return true;
}

// Number, covariance and cumulants of the frames of a sum, within what toliman_track_push takes.
std::shared_ptr<const Spread> spread(const Value &object) {
    Spread made;
    double covariance[3] = {};
    const double frames = optional_number(object, "frames", 1, kMostFrames);
    const bool moves = numbers(object, "jitter_px2", 3, covariance),
               has_cumulants = numbers(object, "cumulants_px", kCumulants, made.cumulants.data());
    if (has_cumulants && !moves)
        fail(Status::format, "cumulants_px needs jitter_px2");
    made.frames = frames != 0 ? frames : 1;
    made.xx = covariance[0];
    made.yy = covariance[1];
    made.xy = covariance[2];
    if (!(made.xx >= 0 && made.xx <= kMostVariance && made.yy >= 0 && made.yy <= kMostVariance &&
          made.xy * made.xy <= made.xx * made.yy * (1 + 1e-9)))
        fail(Status::format,
             "jitter_px2 = [%g, %g, %g]: must be a covariance xx, yy, xy with xx and yy at most %g px^2", made.xx,
             made.yy, made.xy, kMostVariance);
    const auto is_zero = [](double cumulant) { return cumulant == 0; };
    if (made.xx + made.yy == 0 && !std::all_of(made.cumulants.begin(), made.cumulants.end(), is_zero))
        fail(Status::format, "cumulants_px must be 0 if jitter_px2 is");
    return made.any() ? std::make_shared<const Spread>(made) : nullptr;
}

void check_keys(const Value &object, std::set<std::string> &names, SideLine &line) {
    for (size_t i = 0; i < object.names.size(); i++) {
        const std::string &key = object.names[i];
        const bool is_known = std::find(std::begin(kKeys), std::end(kKeys), key) != std::end(kKeys);
        if (!is_known && line.unknown_key == nullptr)
            line.unknown_key = names.insert(printable(key)).first->c_str();
        if (object.find(key) != &object.items[i])
            fail(Status::format, "duplicate key \"%.64s\"", key.c_str());
    }
}

void parse(const std::string &text, double exposure_s, std::set<std::string> &names, SideLine &line) {
    if (text.size() > kLongestLine)
        fail(Status::format, "longer than %zu bytes", kLongestLine);
    const Value object = json::parse(text, "malformed JSON", json::Form::line);
    if (object.kind != Value::Kind::object)
        fail(Status::format, "not a JSON object");
    line.session = name(object, "session_id", names);
    line.roi = name(object, "roi_label", names);
    line.frame_id = integer(object, "frame_id");
    line.has_key = true;
    line.stamp_ns = integer(object, "timestamp_ns");
    line.dropped = integer(object, "nframes_dropped", 0);
    line.rows = static_cast<uint32_t>(integer(object, "n_rows", 1, kLargestSide));
    line.cols = static_cast<uint32_t>(integer(object, "n_cols", 1, kLargestSide));
    line.pixel_bytes = pixel_bytes(object);
    const Value &host = member(object, "host_time");
    if (host.kind != Value::Kind::number)
        fail(Status::format, "host_time must be a number");
    line.host_s = host.number;
    line.exposure_s = optional_number(object, "exposure_s", 0, kLongestExposure);
    line.on_target_s = on_target(object, line.exposure_s > 0 ? line.exposure_s : exposure_s);
    line.spread = spread(object);
    check_keys(object, names, line);
}

} // namespace

SideLine parse_side_line(const std::string &text, double exposure_s, std::set<std::string> &names) {
    SideLine line;
    try {
        parse(text, exposure_s, names, line);
    } catch (const Error &error) {
        if (error.status() != Status::format)
            throw;
        line.error = error.what();
    }
    return line;
}

} // namespace toliman::ingest
