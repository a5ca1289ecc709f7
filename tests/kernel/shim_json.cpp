// C interface to the JSON parser, for the test.
#include "backend/json.hpp"

namespace json = toliman::json;

namespace {

const json::Value &at(const json::Value &tree, const char *path) {
    const json::Value *value = &tree;
    for (; *path != '\0'; path++)
        value = &value->items[static_cast<size_t>(*path - '0')];
    return *value;
}

} // namespace

extern "C" {

// The value at `path`, one digit per level: the index of an item.
double shim_json_number(const char *text, const char *path) {
    return at(json::parse(text, "text"), path).number;
}

// Whether it is an exact integer, and which.
bool shim_json_integer(const char *text, const char *path, int64_t *integer) {
    const json::Value tree = json::parse(text, "text");
    const json::Value &value = at(tree, path);
    *integer = value.integer.value_or(0);
    return value.integer.has_value();
}
}
