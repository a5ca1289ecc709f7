// Method: first all keys of an object are compared with the group's rows: keys whose conditions do not hold are refused
// with the reason, unknown keys with the nearest known one. Then the keys are read in the order of the rows.
// Why: a mistyped optional key would otherwise switch a stage off without notice.
#include "scene/table.hpp"

#include <algorithm>

namespace toliman::scene {

namespace {

const Condition *failing(const Group &group, const Reader &reader, const Row &row);

// Evaluating a choice also checks its word.
bool holds(const Group &group, const Reader &reader, const Condition &condition) {
    if (condition.kind != Condition::Kind::is)
        return condition.kind == Condition::Kind::always ||
               reader.has_any(condition.keys) == (condition.kind == Condition::Kind::with);
    const Row &choice = *std::find_if(group.begin(), group.end(),
                                      [&](const Row &row) { return row.key == std::string(condition.keys); });
    if (!reader.has(choice.key) && (!choice.required || failing(group, reader, choice) != nullptr))
        return true;
    const std::vector<std::string> words = split(condition.words);
    return std::count(words.begin(), words.end(), split(choice.words)[reader.choice(choice)]) != 0;
}

// The first condition of the row that does not hold, nullptr if all do.
const Condition *failing(const Group &group, const Reader &reader, const Row &row) {
    for (const Condition *condition : {&row.first, &row.second})
        if (!holds(group, reader, *condition))
            return condition;
    return nullptr;
}

void check_keys(const Group &group, const Reader &reader) {
    std::vector<std::string> known;
    for (const Row &row : group) {
        const Condition *const condition = failing(group, reader, row);
        const bool given = reader.has(row.key);
        if (given && condition != nullptr && condition->why != nullptr)
            reader.refuse(Status::scene, row.key, ": %s", condition->why);
        if (given && condition != nullptr)
            reader.refuse(Status::scene, row.key, ": needs %s %s", condition->keys,
                          join(split(condition->words), "\"", " or ").c_str());
        if (given && row.read == nullptr)
            reader.refuse(Status::unsupported, row.key, ": not supported yet");
        if (row.read != nullptr && (condition == nullptr || condition->kind == Condition::Kind::with))
            known.emplace_back(row.key);
    }
    reader.allow(known);
}

} // namespace

void read_group(const Group &group, const Reader &reader, void *object) {
    check_keys(group, reader);
    for (const Row &row : group) {
        if (row.read == nullptr || failing(group, reader, row) != nullptr)
            continue;
        const bool given = reader.has(row.key), replaced = row.instead != nullptr && reader.has(row.instead);
        if (row.instead != nullptr && given == replaced && (given || row.required))
            reader.refuse(Status::scene, row.key, ": give either %s or %s", row.key, row.instead);
        if (!given && row.required && !replaced)
            reader.refuse(Status::scene, row.key, ": is missing");
        if (given)
            row.read(reader, row, object);
        if (given && row.check != nullptr)
            row.check(reader, object);
    }
}

} // namespace toliman::scene
