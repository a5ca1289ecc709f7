// Prints the tables of lib/scene as JSON, from which tools/gen/scene_schema makes the JSON Schema of scenes and
// systems. Usage: scene_table [scene|system]
#include <cstdio>
#include <cstring>

#include "scene/groups.hpp"

using namespace toliman::scene;

namespace {

constexpr const char *kTypes[] = {"boolean",
                                  "integer",
                                  "number",
                                  "word",
                                  "words",
                                  "name",
                                  "text",
                                  "file",
                                  "numbers",
                                  "integers",
                                  "numbers_or_file",
                                  "number_or_file",
                                  "numbers_and_files",
                                  "numbers_by_index",
                                  "number_or_drift",
                                  "drifts_by_index",
                                  "number_or_rms",
                                  "group",
                                  "groups",
                                  "word_or_group",
                                  "word_file_or_group"};
constexpr const char *kConditions[] = {"always", "is", "with", "without"};

void print_text(const char *name, const std::string &text) {
    std::printf("\"%s\": \"", name);
    for (const char c : text)
        std::printf(c == '"' || c == '\\' ? "\\%c" : "%c", c);
    std::printf("\", ");
}

void print_condition(const Condition &condition, const char *end) {
    std::printf("{");
    print_text("keys", condition.keys);
    print_text("words", condition.words);
    std::printf("\"kind\": \"%s\"}%s", kConditions[static_cast<size_t>(condition.kind)], end);
}

void print_row(const Row &row, const char *end) {
    std::printf("    {");
    print_text("key", row.key);
    print_text("type", kTypes[static_cast<size_t>(row.type)]);
    print_text("text", row.text);
    print_text("unit", row.range.unit);
    print_text("words", row.words);
    print_text("group", row.group != nullptr ? row.group->name : "");
    print_text("instead", row.instead != nullptr ? row.instead : "");
    std::printf("\"low\": %.17g, \"low_excluded\": %d, ", row.range.low, row.range.low_excluded);
    if (row.range.high != kUnlimited)
        std::printf("\"high\": %.17g, ", row.range.high);
    if (row.initial != nullptr)
        std::printf("\"initial\": %.17g, ", row.initial() / row.scale);
    std::printf("\"least\": %zu, \"most\": %zu, \"required\": %d, \"supported\": %d, \"when\": [", row.least, row.most,
                row.required, row.read != nullptr);
    print_condition(row.first, ", ");
    print_condition(row.second, "]}");
    std::printf("%s\n", end);
}

// Groups that the group's rows use, then the group; `last` is the end of the list.
void print_group(const Group &group, const Group &last, std::vector<const Group *> &done) {
    for (const Group *other : done)
        if (other == &group)
            return;
    done.push_back(&group);
    for (const Row &row : group)
        if (row.group != nullptr)
            print_group(*row.group, last, done);
    std::printf("  \"%s\": {", group.name);
    print_text("text", group.text);
    std::printf("\"rows\": [\n");
    for (const Row &row : group)
        print_row(row, &row + 1 == group.end() ? "" : ",");
    std::printf("  ]}%s\n", &group == &last ? "" : ",");
}

} // namespace

int main(int argc, char **argv) {
    const bool of_system = argc > 1 && std::strcmp(argv[1], "system") == 0;
    const Group &all = of_system ? kSystem : kScene;
    std::vector<const Group *> done;
    std::printf("{\n");
    print_group(all, all, done);
    std::printf("}\n");
    return std::fflush(stdout) == 0 ? 0 : 1;
}
