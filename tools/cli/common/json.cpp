#include "common/json.hpp"

#include <cmath>
#include <cstdio>

namespace cli {

Json &Json::set(const char *name, double value) {
    if (std::isfinite(value))
        cJSON_AddNumberToObject(object_.get(), name, value);
    else
        cJSON_AddNullToObject(object_.get(), name);
    return *this;
}

Json &Json::set_exact(const char *name, double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", value);
    cJSON_AddRawToObject(object_.get(), name, std::isfinite(value) ? text : "null");
    return *this;
}

Json &Json::set_flag(const char *name, bool value) {
    cJSON_AddBoolToObject(object_.get(), name, value);
    return *this;
}

Json &Json::set_whole(const char *name, uint64_t value) {
    cJSON_AddRawToObject(object_.get(), name, std::to_string(value).c_str());
    return *this;
}

Json &Json::set_count(const char *name, int64_t value) {
    cJSON_AddRawToObject(object_.get(), name, std::to_string(value).c_str());
    return *this;
}

Json &Json::set_null(const char *name) {
    cJSON_AddNullToObject(object_.get(), name);
    return *this;
}

Json &Json::set(const char *name, const std::string &value) {
    cJSON_AddStringToObject(object_.get(), name, value.c_str());
    return *this;
}

Json &Json::set(const char *name, Json &&value) {
    return set(name, std::move(value.object_));
}

Json &Json::set(const char *name, JsonTree &&value) {
    cJSON_AddItemToObject(object_.get(), name, value.release());
    return *this;
}

namespace {

std::string text_from(char *printed) {
    std::string text = printed != nullptr ? std::string(printed) + "\n" : "";
    cJSON_free(printed);
    return text;
}

} // namespace

std::string text_of(const JsonTree &tree) {
    return text_from(cJSON_Print(tree.get()));
}

std::string Json::line() const {
    return text_from(cJSON_PrintUnformatted(object_.get()));
}

} // namespace cli
