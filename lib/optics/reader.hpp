// Reads one JSON object of a scene, key by key, and checks types, ranges and spelling. Every error names the file, the
// full key, the value and what is allowed: `scene.json: telescope.aperture_m = -0.125: must be in [0.001, 100] m`.
#pragma once
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "backend/json.hpp"
#include "base/error.hpp"

namespace toliman::optics {

// Allowed interval: [low, high], or (low, high] if low is excluded.
struct Range {
    double low, high;
    const char *unit; // "" for none
    bool low_excluded = false;
};
constexpr Range above(double low, double high, const char *unit) {
    return {low, high, unit, true};
}
constexpr Range within(double low, double high, const char *unit) {
    return {low, high, unit, false};
}

class Reader {
  public:
    // value must be an object; path is "" for the scene itself. value and source must outlive the reader.
    Reader(const json::Value &value, std::string path, const std::string &source);

    // Refuses keys that are not in `known`, suggesting the nearest one. Those in `later` are reserved: not supported
    // yet.
    void allow(std::initializer_list<const char *> known, std::initializer_list<const char *> later = {}) const;

    // Refuses keys that only another variant of the object allows, with the message "<key>: <why>".
    void exclude(std::initializer_list<const char *> keys, const char *why) const;

    const std::vector<std::string> &names() const { return value_.names; }
    bool has(const char *key) const { return value_.find(key) != nullptr; }
    bool has_object(const char *key) const;
    bool has_text(const char *key) const;
    double number(const char *key, Range range) const;
    double number_or(const char *key, double otherwise, Range range) const;
    std::optional<double> optional_number(const char *key, Range range) const;
    std::vector<double> numbers(const char *key, size_t least, size_t most, Range range) const;
    int64_t integer(const char *key, Range range) const;
    bool boolean_or(const char *key, bool otherwise) const;
    const std::string &text(const char *key) const;
    std::vector<std::string> texts(const char *key) const;
    // Index of the string in the list of choices.
    size_t choice(const char *key, std::initializer_list<const char *> choices) const;
    // A file name, relative to `folder` unless absolute; checks that the file exists and can be read.
    std::string file(const char *key, const std::string &folder) const;
    Reader object(const char *key) const;
    std::vector<Reader> objects(const char *key, size_t least, size_t most) const;

    // Fails with "<source>: <path>.<key><text>"; the format begins with ": " or " = ".
    [[noreturn]] void refuse(Status status, const char *key, const char *format, ...) const
        __attribute__((format(printf, 4, 5)));

  private:
    const json::Value &require(const char *key) const;
    const json::Value &require(const char *key, json::Value::Kind kind, const char *kind_name) const;
    double checked(const std::string &key, const json::Value &value, Range range) const;
    std::string full_key(const std::string &key) const { return path_.empty() ? key : path_ + "." + key; }

    const json::Value &value_;
    std::string path_;
    const std::string &source_;
};

} // namespace toliman::optics
