// Reads one object of a scene, key by key: type, range and spelling are checked, and every complaint names the file,
// the key with its path, the value and what is allowed.
#pragma once
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "backend/json.hpp"
#include "base/error.hpp"

namespace toliman::optics {

// Allowed numbers: low ... high, low itself only when it is not excluded.
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
    // value must be an object; path is "" for the scene itself. Both live as long as the reader.
    Reader(const json::Value &value, std::string path, const std::string &source);

    // Complains about a key that is neither in known nor in later; one in later is valid but not built yet.
    void allow(std::initializer_list<const char *> known, std::initializer_list<const char *> later = {}) const;

    // Complains about keys that only another variant of the object has: "<key>: <why>".
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
    // Index of the text among the choices.
    size_t choice(const char *key, std::initializer_list<const char *> choices) const;
    // A file's name, from `folder` on unless absolute; the file is there and can be read.
    std::string file(const char *key, const std::string &folder) const;
    Reader object(const char *key) const;
    std::vector<Reader> objects(const char *key, size_t least, size_t most) const;

    // "<source>: <path>.<key>: <text>"
    [[noreturn]] void refuse(Status status, const char *key, const char *format, ...) const
        __attribute__((format(printf, 4, 5)));

  private:
    const json::Value &need(const char *key) const;
    const json::Value &need(const char *key, json::Value::Kind kind, const char *kind_name) const;
    double checked(const std::string &key, const json::Value &value, Range range) const;
    std::string full(const std::string &key) const { return path_.empty() ? key : path_ + "." + key; }

    const json::Value &value_;
    std::string path_;
    const std::string &source_;
};

} // namespace toliman::optics
