#include "common/json.hpp"

#include "common/text.hpp"

namespace cli {

namespace {

std::string text_from(char *printed) {
    std::string text = printed != nullptr ? printed : "";
    cJSON_free(printed);
    return text;
}

} // namespace

std::string text_of(const JsonTree &tree) {
    return text_from(cJSON_Print(tree.get())) + "\n";
}

std::string line_of(const cJSON *item) {
    return text_from(cJSON_PrintUnformatted(item));
}

JsonTree exact(double value) {
    return JsonTree(cJSON_CreateRaw(std::isfinite(value) ? formatted("%.17g", value).c_str() : "null"));
}

} // namespace cli
