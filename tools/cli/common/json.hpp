// Builds JSON results from owned cJSON objects. Numbers that are not finite become null.
#pragma once
#include <cjson/cJSON.h>
#include <cstdint>
#include <memory>
#include <string>

namespace cli {

struct FreeJson {
    void operator()(cJSON *item) const noexcept { cJSON_Delete(item); }
};
using JsonTree = std::unique_ptr<cJSON, FreeJson>;

// The tree as indented text with a newline at the end.
std::string text_of(const JsonTree &tree);

class Json {
  public:
    Json() : object_(cJSON_CreateObject()) {}
    Json &set(const char *name, double value);
    Json &set_exact(const char *name, double value); // 17 digits: the same bits are read again
    Json &set_flag(const char *name, bool value);
    Json &set_whole(const char *name, uint64_t value); // all digits, also above 2^53
    Json &set_count(const char *name, int64_t value);
    Json &set_null(const char *name);
    Json &set(const char *name, const std::string &value);
    Json &set(const char *name, Json &&value); // nested
    Json &set(const char *name, JsonTree &&value);
    std::string text() const { return text_of(object_); }
    std::string line() const; // on one line
    JsonTree release() { return std::move(object_); }

  private:
    JsonTree object_;
};

} // namespace cli
