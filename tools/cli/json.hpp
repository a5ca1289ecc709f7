// JSON results: owned cJSON objects; numbers that are not finite become null.
#pragma once
#include <cjson/cJSON.h>
#include <cstdint>
#include <memory>
#include <string>

namespace cli {

class Json {
  public:
    Json() : object_(cJSON_CreateObject()) {}
    Json &set(const char *name, double value);
    Json &set_whole(const char *name, uint64_t value); // every digit, where a double would round
    Json &set(const char *name, const std::string &value);
    Json &set(const char *name, Json &&value); // nested
    std::string text() const;                  // indented, with a line end

  private:
    struct Delete {
        void operator()(cJSON *item) const noexcept { cJSON_Delete(item); }
    };
    std::unique_ptr<cJSON, Delete> object_;
};

} // namespace cli
