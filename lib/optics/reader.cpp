// Method: each key is read by the function of its type with its allowed interval; allow() refuses every other key.
// The nearest known key or word is suggested instead of an unknown one.
// Why: a mistyped optional key would otherwise switch a stage off without notice.
#include "optics/reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdarg>

#include "backend/file.hpp"
#include "base/nearest_word.hpp"
#include "base/text.hpp"

namespace toliman::optics {

namespace {

using Kind = json::Value::Kind;

bool is_one_of(const std::string &word, std::initializer_list<const char *> words) {
    return std::any_of(words.begin(), words.end(), [&](const char *other) { return word == other; });
}

std::string join(std::initializer_list<const char *> words) {
    std::string list;
    for (const char *word : words)
        list += (list.empty() ? "" : ", ") + std::string(word);
    return list;
}

std::string format_value(double value) {
    char text[40];
    const size_t length = print_text(text, sizeof text, "%.10g", value);
    double parsed = 0;
    std::from_chars(text, text + length, parsed);
    if (parsed != value) // print enough digits for the exact value
        print_text(text, sizeof text, "%.17g", value);
    return text;
}

std::string format_value(const json::Value &value) {
    switch (value.kind) {
    case Kind::null:
        return "null";
    case Kind::boolean:
        return value.boolean ? "true" : "false";
    case Kind::number:
        return format_value(value.number);
    case Kind::text:
        return '"' + value.text.substr(0, 40) + '"';
    case Kind::array:
        return "an array";
    case Kind::object:
        break;
    }
    return "an object";
}

std::string format_value(Range range) {
    const std::string interval =
        (range.low_excluded ? "(" : "[") + format_value(range.low) + ", " + format_value(range.high) + "]";
    return range.unit[0] != '\0' ? interval + " " + range.unit : interval;
}

} // namespace

Reader::Reader(const json::Value &value, std::string path, const std::string &source)
    : value_(value), path_(std::move(path)), source_(source) {
    if (value.kind != Kind::object)
        fail(Status::scene, "%s: {%s} = %s: must be an object", source_.c_str(),
             path_.empty() ? "the scene" : path_.c_str(), format_value(value).c_str());
}

void Reader::refuse(Status status, const char *key, const char *format, ...) const {
    char text[kErrorTextSize];
    va_list arguments;
    va_start(arguments, format);
    print_text(text, sizeof text, format, arguments);
    va_end(arguments);
    fail(status, "%s: {%s}%s", source_.c_str(), full_key(key).c_str(), text);
}

void Reader::allow(std::initializer_list<const char *> known, std::initializer_list<const char *> later) const {
    for (const std::string &name : value_.names) {
        if (is_one_of(name, known))
            continue;
        if (is_one_of(name, later))
            refuse(Status::unsupported, name.c_str(), ": not supported yet");
        const std::string suggestion = nearest_word(name, {known.begin(), known.end()});
        if (!suggestion.empty())
            refuse(Status::scene, name.c_str(), ": unknown key; did you mean \"%s\"?", suggestion.c_str());
        refuse(Status::scene, name.c_str(), ": unknown key; allowed keys: %s", join(known).c_str());
    }
}

void Reader::exclude(std::initializer_list<const char *> keys, const char *why) const {
    for (const char *key : keys)
        if (has(key))
            refuse(Status::scene, key, ": %s", why);
}

const json::Value &Reader::require(const char *key) const {
    const json::Value *value = value_.find(key);
    if (value == nullptr)
        refuse(Status::scene, key, ": is missing");
    return *value;
}

const json::Value &Reader::require(const char *key, Kind kind, const char *kind_name) const {
    const json::Value &value = require(key);
    if (value.kind != kind)
        refuse(Status::scene, key, " = %s: must be %s", format_value(value).c_str(), kind_name);
    return value;
}

double Reader::checked(const std::string &key, const json::Value &value, Range range) const {
    if (value.kind != Kind::number)
        refuse(Status::scene, key.c_str(), " = %s: must be a number in %s", format_value(value).c_str(),
               format_value(range).c_str());
    if (value.number < range.low || value.number > range.high || (range.low_excluded && value.number == range.low))
        refuse(Status::scene, key.c_str(), " = %s: must be in %s", format_value(value).c_str(),
               format_value(range).c_str());
    return value.number;
}

bool Reader::has_object(const char *key) const {
    return has(key) && require(key).kind == Kind::object;
}

bool Reader::has_text(const char *key) const {
    return has(key) && require(key).kind == Kind::text;
}

double Reader::number(const char *key, Range range) const {
    return checked(key, require(key), range);
}

double Reader::number_or(const char *key, double otherwise, Range range) const {
    return has(key) ? number(key, range) : otherwise;
}

std::optional<double> Reader::optional_number(const char *key, Range range) const {
    return has(key) ? std::optional<double>(number(key, range)) : std::nullopt;
}

std::vector<double> Reader::numbers(const char *key, size_t least, size_t most, Range range) const {
    const json::Value &array = require(key, Kind::array, "an array of numbers");
    if (array.items.size() < least || array.items.size() > most)
        refuse(Status::scene, key, ": has %zu numbers: must have %zu to %zu", array.items.size(), least, most);
    std::vector<double> numbers;
    for (size_t i = 0; i < array.items.size(); i++)
        numbers.push_back(checked(key + ("[" + std::to_string(i) + "]"), array.items[i], range));
    return numbers;
}

int64_t Reader::integer(const char *key, Range range) const {
    const double value = number(key, range);
    if (value != std::floor(value))
        refuse(Status::scene, key, " = %s: must be a whole number", format_value(value).c_str());
    return static_cast<int64_t>(value);
}

bool Reader::boolean_or(const char *key, bool otherwise) const {
    return has(key) ? require(key, Kind::boolean, "true or false").boolean : otherwise;
}

const std::string &Reader::text(const char *key) const {
    return require(key, Kind::text, "a string").text;
}

std::vector<std::string> Reader::texts(const char *key) const {
    std::vector<std::string> texts;
    for (const json::Value &item : require(key, Kind::array, "an array of strings").items) {
        if (item.kind != Kind::text)
            refuse(Status::scene, key, ": contains %s: must contain only strings", format_value(item).c_str());
        texts.push_back(item.text);
    }
    return texts;
}

size_t Reader::choice(const char *key, std::initializer_list<const char *> choices) const {
    const std::string &given = text(key);
    size_t index = 0;
    std::string list;
    for (const char *candidate : choices) {
        if (given == candidate)
            return index;
        list += (index++ == 0 ? "\"" : ", \"") + std::string(candidate) + '"';
    }
    const std::string suggestion = nearest_word(given, {choices.begin(), choices.end()});
    refuse(Status::scene, key, " = \"%s\": must be one of %s%s", given.substr(0, 40).c_str(), list.c_str(),
           suggestion.empty() ? "" : ("; did you mean \"" + suggestion + "\"?").c_str());
}

std::string Reader::file(const char *key, const std::string &folder) const {
    const std::string &name = text(key);
    std::string path = !name.empty() && name[0] == '/' ? name : folder + "/" + name;
    try {
        file::head(path, 1);
    } catch (const Error &error) {
        fail_within(error, error.status(), "%s: %s: %s", source_.c_str(), full_key(key).c_str(), error.what());
    }
    return path;
}

Reader Reader::object(const char *key) const {
    return Reader(require(key), full_key(key), source_);
}

std::vector<Reader> Reader::objects(const char *key, size_t least, size_t most) const {
    const json::Value &array = require(key, Kind::array, "an array of objects");
    if (array.items.size() < least || array.items.size() > most)
        refuse(Status::scene, key, ": has %zu entries: must have %zu to %zu", array.items.size(), least, most);
    std::vector<Reader> readers;
    for (size_t i = 0; i < array.items.size(); i++)
        readers.emplace_back(array.items[i], full_key(key) + "[" + std::to_string(i) + "]", source_);
    return readers;
}

} // namespace toliman::optics
