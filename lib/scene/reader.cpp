#include "scene/reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdarg>

#include "backend/file.hpp"
#include "base/nearest_word.hpp"
#include "base/text.hpp"
#include "scene/table.hpp"

namespace toliman::scene {

namespace {

using Kind = json::Value::Kind;

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

std::vector<std::string> split(const std::string &words) {
    std::vector<std::string> list;
    for (size_t start = 0, stop; start < words.size(); start = stop + 1) {
        stop = std::min(words.find(' ', start), words.size());
        list.push_back(words.substr(start, stop - start));
    }
    return list;
}

std::string join(const std::vector<std::string> &words, const char *quote, const char *separator) {
    std::string list;
    for (const std::string &word : words)
        list += (list.empty() ? "" : separator) + (quote + word + quote);
    return list;
}

Reader::Reader(const json::Value &value, std::string path, const Context &context)
    : value_(value), path_(std::move(path)), context_(context) {
    if (value.kind != Kind::object)
        fail(Status::scene, "%s: {%s} = %s: must be an object", context.source.c_str(),
             path_.empty() ? context.whole : path_.c_str(), format_value(value).c_str());
}

void Reader::refuse(Status status, const char *key, const char *format, ...) const {
    char text[kErrorTextSize];
    va_list arguments;
    va_start(arguments, format);
    print_text(text, sizeof text, format, arguments);
    va_end(arguments);
    fail(status, "%s: {%s}%s", context_.source.c_str(), full_key(key).c_str(), text);
}

bool Reader::has_object(const char *key) const {
    return has(key) && require(key).kind == Kind::object;
}

bool Reader::has_text(const char *key) const {
    return has(key) && require(key).kind == Kind::text;
}

bool Reader::has_any(const char *keys) const {
    const std::vector<std::string> list = split(keys);
    return std::any_of(list.begin(), list.end(), [&](const std::string &key) { return has(key.c_str()); });
}

void Reader::allow(const std::vector<std::string> &known) const {
    for (const std::string &name : value_.names) {
        if (std::find(known.begin(), known.end(), name) != known.end())
            continue;
        const std::string suggestion = nearest_word(name, known);
        if (!suggestion.empty())
            refuse(Status::scene, name.c_str(), ": unknown key; did you mean \"%s\"?", suggestion.c_str());
        refuse(Status::scene, name.c_str(), ": unknown key; allowed keys: %s", join(known, "", ", ").c_str());
    }
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

const json::Value &Reader::array(const Row &row, const char *what, const char *entries) const {
    const json::Value &array = require(row.key, Kind::array, what);
    if (array.items.size() < row.least || array.items.size() > row.most)
        refuse(Status::scene, row.key, ": has %zu %s: must have %zu to %zu", array.items.size(), entries, row.least,
               row.most);
    return array;
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

bool Reader::boolean(const char *key) const {
    return require(key, Kind::boolean, "true or false").boolean;
}

double Reader::number(const char *key, Range range) const {
    return checked(key, require(key), range);
}

double Reader::number(const Row &row) const {
    return number(row.key, row.range);
}

int64_t Reader::integer(const Row &row) const {
    const double value = number(row);
    if (value != std::floor(value))
        refuse(Status::scene, row.key, " = %s: must be a whole number", format_value(value).c_str());
    return static_cast<int64_t>(value);
}

std::vector<double> Reader::numbers(const Row &row) const {
    std::vector<double> numbers;
    for (const json::Value &item : array(row, "an array of numbers", "numbers").items)
        numbers.push_back(checked(row.key + ("[" + std::to_string(numbers.size()) + "]"), item, row.range));
    return numbers;
}

const std::string &Reader::text(const char *key) const {
    return require(key, Kind::text, "a string").text;
}

std::vector<std::string> Reader::texts(const Row &row) const {
    std::vector<std::string> texts;
    for (const json::Value &item : array(row, "an array of strings", "names").items) {
        if (item.kind != Kind::text)
            refuse(Status::scene, row.key, ": contains %s: must contain only strings", format_value(item).c_str());
        texts.push_back(item.text);
    }
    return texts;
}

size_t Reader::choice(const Row &row) const {
    const std::string &given = text(row.key);
    const std::vector<std::string> words = split(row.words);
    const auto found = std::find(words.begin(), words.end(), given);
    if (found != words.end())
        return static_cast<size_t>(found - words.begin());
    const std::string suggestion = nearest_word(given, words);
    refuse(Status::scene, row.key, " = \"%s\": must be one of %s%s", given.substr(0, 40).c_str(),
           join(words, "\"", ", ").c_str(),
           suggestion.empty() ? "" : ("; did you mean \"" + suggestion + "\"?").c_str());
}

std::string Reader::file_named(const std::string &key, const std::string &name) const {
    std::string path = !name.empty() && name[0] == '/' ? name : context_.folder + "/" + name;
    try {
        file::head(path, 1);
    } catch (const Error &error) {
        fail_within(error, error.status(), "%s: %s: %s", context_.source.c_str(), full_key(key).c_str(), error.what());
    }
    return path;
}

std::string Reader::file(const char *key) const {
    return file_named(key, text(key));
}

std::vector<NumberOrFile> Reader::numbers_and_files(const Row &row) const {
    std::vector<NumberOrFile> list;
    for (const json::Value &item : array(row, "an array of numbers and file names", "entries").items) {
        const std::string key = row.key + ("[" + std::to_string(list.size()) + "]");
        if (item.kind == Kind::text)
            list.push_back({0, file_named(key, item.text)});
        else
            list.push_back({checked(key, item, row.range), ""});
    }
    return list;
}

Reader Reader::object(const char *key) const {
    return Reader(require(key), full_key(key), context_);
}

std::vector<Reader> Reader::objects(const Row &row) const {
    std::vector<Reader> readers;
    for (const json::Value &item : array(row, "an array of objects", "entries").items)
        readers.emplace_back(item, full_key(row.key) + "[" + std::to_string(readers.size()) + "]", context_);
    return readers;
}

} // namespace toliman::scene
