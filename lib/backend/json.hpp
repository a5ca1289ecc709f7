// Parser of JSON text to a tree of plain values: cJSON after a scan that rejects what cJSON accepts wrongly.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace toliman::json {

constexpr size_t kLargestText = size_t{256} * 1024;

struct Value {
    enum class Kind { null, boolean, number, text, array, object } kind = Kind::null;
    bool boolean = false;
    double number = 0;              // always finite
    std::optional<int64_t> integer; // exact value of a number that is written without fraction and exponent, if it fits
    std::string text;
    std::vector<Value> items;       // of an array or object
    std::vector<std::string> names; // keys of an object's items, all different in a document

    const Value *find(const std::string &name) const noexcept; // the first; nullptr if there is none
    Value &member(const std::string &name);                    // of an object; made as null if there is none
    void remove(const std::string &name);                      // of an object, if there is one
    static Value of(double number);
    static Value of(const std::string &text);
};

// document: duplicate keys are refused. line: a line of JSON Lines; duplicate keys are kept, and messages name no line.
enum class Form { document, line };

// Parses JSON text of at most kLargestText bytes, which callers check. The text must be valid UTF-8 without U+0000,
// with at most 16 nested levels and 4096 values, and numbers within the range of double. Status::format otherwise; the
// message starts with `source` and, except for duplicate keys, names line and column.
Value parse(const std::string &text, const std::string &source, Form form = Form::document);

// JSON text of a value, indented, with a newline at the end; numbers have all digits.
std::string print(const Value &value);

} // namespace toliman::json
