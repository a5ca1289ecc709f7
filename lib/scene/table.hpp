// Tables of the scene's keys. Each key is described once, by a row: the parser (table.cpp) and the JSON Schema
// (tools/gen/scene_schema) follow the rows.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "scene/reader.hpp"

namespace toliman::scene {

// When a key is allowed, with the reason that messages give where it is not; nullptr: derived from the words.
struct Condition {
    enum class Kind { always, is, with, without } kind = Kind::always;
    const char *keys = "";  // separated by spaces: the key of a choice (is); one of these is present (with), or none
    const char *words = ""; // that the choice may have, separated by spaces; a choice that is absent may have any
    const char *why = nullptr;
};
constexpr Condition is(const char *key, const char *words, const char *why = nullptr) {
    return {Condition::Kind::is, key, words, why};
}
constexpr Condition with(const char *keys, const char *why) {
    return {Condition::Kind::with, keys, "", why};
}
constexpr Condition without(const char *keys, const char *why) {
    return {Condition::Kind::without, keys, "", why};
}

// One key of a group. The functions get the group's object, of the type that its rows are written for.
struct Row {
    const char *key;
    const char *text; // description, without the unit
    Type type;
    bool required = false; // where its conditions hold
    Range range = {};
    const char *words = "";                                      // of a choice, separated by spaces
    const Group *group = nullptr;                                // of an object
    void (*read)(const Reader &, const Row &, void *) = nullptr; // nullptr: the key is reserved, and refused
    void (*check)(const Reader &, void *) = nullptr;             // called after read; may also derive members
    double (*initial)() = nullptr;                               // default, as the key would give it
    const char *instead = nullptr;     // another key that replaces this one; both are not allowed together
    size_t least = 0, most = 0;        // entries of an array
    double scale = 1;                  // the member is the number times this
    Condition first = {}, second = {}; // both must hold

    constexpr Row as(Type other) {
        type = other;
        return *this;
    }
    constexpr Row scaled(double factor) {
        scale = factor;
        return *this;
    }
    constexpr Row entries(size_t fewest, size_t highest) {
        least = fewest, most = highest;
        return *this;
    }
    constexpr Row or_word(const char *list) {
        type = Type::word_or_group, words = list;
        return *this;
    }
    constexpr Row either(const char *other) {
        instead = other;
        return *this;
    }
    constexpr Row when(Condition one, Condition other = {}) {
        first = one, second = other;
        return *this;
    }
    // Calls `function(reader, object)` after the key was read.
    template <auto function> constexpr Row checked() const;
};

struct Group {
    const char *name; // in the schema
    const char *text; // description
    const Row *rows;
    size_t size;

    const Row *begin() const { return rows; }
    const Row *end() const { return rows + size; }
};
template <size_t count> constexpr Group group_of(const char *name, const char *text, const Row (&rows)[count]) {
    return {name, text, rows, count};
}

// Reads an object: checks which keys are given, then reads them in the order of the rows.
void read_group(const Group &group, const Reader &reader, void *object);

// The value of a key becomes that of a member.
template <class T> void assign(const Reader &reader, const Row &row, T &member) {
    if constexpr (std::is_same_v<T, bool>)
        member = row.type == Type::word ? reader.choice(row) == 1 : reader.boolean(row.key);
    else if constexpr (std::is_enum_v<T>)
        member = static_cast<T>(reader.choice(row));
    else if constexpr (std::is_integral_v<T>)
        member =
            static_cast<T>(row.type == Type::word ? static_cast<int64_t>(reader.choice(row)) : reader.integer(row));
    else if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>)
        member =
            (row.type == Type::integer ? static_cast<double>(reader.integer(row)) : reader.number(row)) * row.scale;
    else if constexpr (std::is_same_v<T, std::string>)
        member = reader.file(row.key);
    else if constexpr (std::is_same_v<T, std::vector<double>>)
        member = reader.numbers(row);
    else
        read_group(*row.group, reader.object(row.key), &member);
}

template <class T> void assign(const Reader &reader, const Row &row, std::optional<T> &member) {
    assign(reader, row, member.emplace());
}

// A word that is checked, and not kept.
template <class T> void check_word(const Reader &reader, const Row &row, T & /*object*/) {
    reader.choice(row);
}

// A row is written for a member of the group's object, or for a function that reads the key into the object.
template <class M> struct Target;
template <class O, class T> struct Target<T O::*> {
    using Object = O;
    using Value = T;
};
template <class O> struct Target<void (*)(const Reader &, const Row &, O &)> {
    using Object = O;
    using Value = void;
};
template <class O> struct Target<void (*)(const Reader &, O &)> { using Object = O; };

template <auto target> void read_into(const Reader &reader, const Row &row, void *object) {
    using Object = typename Target<decltype(target)>::Object;
    if constexpr (std::is_member_pointer_v<decltype(target)>)
        assign(reader, row, static_cast<Object *>(object)->*target);
    else
        target(reader, row, *static_cast<Object *>(object));
}

template <auto member> double initial_value() {
    return static_cast<double>(typename Target<decltype(member)>::Object().*member);
}

template <auto target> constexpr Row make(const char *key, Type type, const char *text) {
    using Value = typename Target<decltype(target)>::Value;
    Row row = {key, text, type};
    row.read = read_into<target>;
    if constexpr (std::is_arithmetic_v<Value> || std::is_enum_v<Value>)
        row.initial = initial_value<target>;
    return row;
}

// Rows of optional and of required keys: a boolean or a file, a number, a choice of words, an object.
template <auto target> constexpr Row optional(const char *key, const char *text) {
    const bool flag = std::is_same_v<typename Target<decltype(target)>::Value, bool>;
    return make<target>(key, flag ? Type::boolean : Type::file, text);
}
template <auto target> constexpr Row optional(const char *key, Range range, const char *text) {
    using Value = typename Target<decltype(target)>::Value;
    const Type type = std::is_integral_v<Value>                    ? Type::integer
                      : std::is_same_v<Value, std::vector<double>> ? Type::numbers
                                                                   : Type::number;
    Row row = make<target>(key, type, text);
    row.range = range;
    return row;
}
template <auto target> constexpr Row optional(const char *key, Words words, const char *text) {
    Row row = make<target>(key, Type::word, text);
    row.words = words.list;
    return row;
}
template <auto target> constexpr Row optional(const char *key, const Group *group, const char *text = "") {
    Row row = make<target>(key, Type::group, text);
    row.group = group;
    return row;
}
template <auto target, class... Arguments> constexpr Row required(const char *key, const Arguments &...arguments) {
    Row row = optional<target>(key, arguments...);
    row.required = true;
    return row;
}

// An object whose keys belong to the object that contains it.
constexpr Row part(const char *key, const Group *group) {
    Row row = {key, "", Type::group};
    row.group = group;
    row.read = [](const Reader &reader, const Row &own, void *object) {
        read_group(*own.group, reader.object(own.key), object);
    };
    return row;
}

// A key of a later version.
constexpr Row reserved(const char *key, const char *text) {
    return {key, text, Type::integer};
}

template <auto function> constexpr Row Row::checked() const {
    Row row = *this;
    row.check = [](const Reader &reader, void *object) {
        function(reader, *static_cast<typename Target<decltype(function)>::Object *>(object));
    };
    return row;
}

} // namespace toliman::scene
