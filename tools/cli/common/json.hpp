// Writes JSON results; reads JSON by cJSON.
#pragma once
#include <cjson/cJSON.h>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace cli {

struct FreeJson {
    void operator()(cJSON *item) const noexcept { cJSON_Delete(item); }
};
using JsonTree = std::unique_ptr<cJSON, FreeJson>;

// The tree as indented text with a newline at the end, and on one line without one.
std::string text_of(const JsonTree &tree);
std::string line_of(const cJSON *item);

template <class> inline constexpr bool is_optional = false;
template <class Value> inline constexpr bool is_optional<std::optional<Value>> = true;

// For set(): a number with 17 digits, so that the same bits are read again; null if not finite.
struct Exact {
    double value;
};

// An object, as the text of its members: lines of many results are written without a tree.
class Json {
  public:
    // The members as in set: name, value, name, value, ...
    template <class... Members> explicit Json(const Members &...members) {
        if constexpr (sizeof...(members) > 0)
            set(members...);
    }
    // Values: bool, integers (with all digits), double (15 digits, 17 if 15 are another number; null if not finite),
    // Exact, text, Json, JsonTree (null if empty), and optional values (null if empty) and vectors of these.
    template <class Value, class... More> Json &set(const char *name, const Value &value, const More &...more) {
        if (!members_.empty())
            members_ += ',';
        add_text(name);
        members_ += ':';
        add(value);
        if constexpr (sizeof...(more) > 0)
            set(more...);
        return *this;
    }
    std::string text() const; // indented
    std::string line() const { return "{" + members_ + "}\n"; }

  private:
    template <class Value> void add(const Value &value) {
        if constexpr (std::is_same_v<Value, bool>)
            members_ += value ? "true" : "false";
        else if constexpr (std::is_integral_v<Value>)
            members_ += std::to_string(value);
        else if constexpr (std::is_floating_point_v<Value>)
            add_number(value);
        else if constexpr (std::is_same_v<Value, Exact>)
            add_exact(value.value);
        else if constexpr (std::is_same_v<Value, Json>)
            (members_ += '{').append(value.members_) += '}';
        else if constexpr (std::is_same_v<Value, JsonTree>)
            members_ += value ? line_of(value.get()) : "null";
        else if constexpr (std::is_convertible_v<Value, std::string_view>)
            add_text(value);
        else if constexpr (is_optional<Value>)
            value ? add(*value) : static_cast<void>(members_ += "null");
        else
            add_array(value);
    }
    template <class Array> void add_array(const Array &array) {
        members_ += '[';
        const char *separator = "";
        for (const auto &element : array) {
            members_ += std::exchange(separator, ",");
            add(element);
        }
        members_ += ']';
    }
    void add_text(std::string_view text);
    void add_number(double value);
    void add_exact(double value);

    std::string members_;
};

// For set().
inline std::optional<std::string> text_or_null(const std::string &text) {
    return text.empty() ? std::nullopt : std::optional(text);
}

// For set(): the value, or null if it is not known.
template <class Value> std::optional<std::decay_t<const Value &>> if_known(bool is_known, const Value &value) {
    return is_known ? std::optional<std::decay_t<const Value &>>(value) : std::nullopt;
}

// The JSON of every item, for set().
template <class Items, class Work> std::vector<Json> array_of(const Items &items, Work json_of) {
    std::vector<Json> array;
    array.reserve(items.size());
    for (const auto &item : items)
        array.push_back(json_of(item));
    return array;
}

// The model name that Linux reports, "unknown" if there is none.
std::string processor_name();

// Keys command (the words of this process's command line, quoted for a shell where necessary), date (UTC,
// YYYY-MM-DDThh:mm:ssZ) and processor.
Json provenance();

} // namespace cli
