// Builds JSON results from owned cJSON objects.
#pragma once
#include <cjson/cJSON.h>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
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

class Json {
  public:
    // The members as in set: name, value, name, value, ...
    template <class... Members> explicit Json(Members &&...members) : object_(cJSON_CreateObject()) {
        if constexpr (sizeof...(members) > 0)
            set(std::forward<Members>(members)...);
    }
    // Values: bool, integers (with all digits), double (15 digits; null if not finite), text, Json, JsonTree (null if
    // empty), and optional values (null if empty) and vectors of these.
    template <class Value, class... More> Json &set(const char *name, Value &&value, More &&...more) {
        cJSON_AddItemToObject(object_.get(), name, item_of(std::forward<Value>(value)));
        if constexpr (sizeof...(more) > 0)
            set(std::forward<More>(more)...);
        return *this;
    }
    std::string text() const { return text_of(object_); }
    std::string line() const { return line_of(object_.get()) + "\n"; }
    const cJSON *tree() const noexcept { return object_.get(); }
    JsonTree release() { return std::move(object_); }

  private:
    template <class Value> static cJSON *item_of(Value &&value) {
        using Plain = std::decay_t<Value>;
        if constexpr (std::is_same_v<Plain, bool>)
            return cJSON_CreateBool(value);
        else if constexpr (std::is_integral_v<Plain>)
            return cJSON_CreateRaw(std::to_string(value).c_str());
        else if constexpr (std::is_floating_point_v<Plain>)
            return std::isfinite(value) ? cJSON_CreateNumber(value) : cJSON_CreateNull();
        else if constexpr (std::is_same_v<Plain, Json>)
            return value.object_.release();
        else if constexpr (std::is_same_v<Plain, JsonTree>)
            return value ? value.release() : cJSON_CreateNull();
        else if constexpr (std::is_convertible_v<Plain, std::string>)
            return cJSON_CreateString(std::string(value).c_str());
        else if constexpr (is_optional<Plain>)
            return value ? item_of(*value) : cJSON_CreateNull();
        else {
            cJSON *array = cJSON_CreateArray();
            for (auto &element : value)
                cJSON_AddItemToArray(array, item_of(std::move(element)));
            return array;
        }
    }

    JsonTree object_;
};

// For set(): 17 digits, so that the same bits are read again; null if not finite.
JsonTree exact(double value);

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

} // namespace cli
