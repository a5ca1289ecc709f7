// JSON text to a tree of plain values; cJSON behind a scan that refuses what it would let through.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace toliman::json {

constexpr size_t kLargestText = size_t{256} * 1024;

struct Value {
    enum class Kind { null, boolean, number, text, array, object } kind = Kind::null;
    bool boolean = false;
    double number = 0; // finite
    std::string text;
    std::vector<Value> items;       // of an array or object
    std::vector<std::string> names; // of an object's items, all different

    const Value *find(const std::string &name) const noexcept; // nullptr if there is none
};

// The value of JSON text, which callers keep to kLargestText: at most 16 levels and 4096 values, valid UTF-8 without
// U+0000, numbers within the range of double, no key twice in an object. Status::format otherwise; the message starts
// with source and names line and column.
Value parse(const std::string &text, const std::string &source);

} // namespace toliman::json
