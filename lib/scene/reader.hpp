// Reads one JSON object of a scene, key by key, and checks types and ranges. Every error names the file, the full key,
// the value and what is allowed: `scene.json: telescope.aperture_m = -0.125: must be in [0.001, 100] m`.
#pragma once
#include <string>
#include <vector>

#include "backend/json.hpp"
#include "base/error.hpp"
#include "scene/range.hpp"
#include "scene/scene.hpp"

namespace toliman::scene {

struct Row;
struct Group;

// What the value of a key is.
enum class Type {
    boolean,
    integer,
    number,
    word,  // one of the row's words
    words, // an array of them, all different
    name,  // as base/name.hpp allows
    text,  // any
    file,
    numbers,
    integers,
    numbers_or_file,
    number_or_file,
    numbers_and_files, // an array of both
    numbers_by_index,  // an object of numbers by Noll index
    number_or_drift,   // an rms, or an object with rms and drift_per_day
    drifts_by_index,   // an object of these by Noll index
    number_or_rms,     // the same without a drift
    group,
    groups,        // an array of objects
    word_or_group, // one of the row's words, or an object
    word_file_or_group,
};

struct Words {
    const char *list; // separated by spaces
};
std::vector<std::string> split(const std::string &words);
std::string join(const std::vector<std::string> &words, const char *quote, const char *separator);

struct NumberOrFile {
    double number = 0;
    std::string file; // "" = the number
};

// What all readers of a scene share. `scene` holds the groups that were read so far.
struct Context {
    const std::string &source, &folder;
    const Scene &scene;
    const char *whole = "the scene"; // what the file describes, for messages
};

class Reader {
  public:
    // value must be an object; path is "" for the whole file. value and context must outlive the reader.
    Reader(const json::Value &value, std::string path, const Context &context);

    const Scene &scene() const { return context_.scene; }
    const std::vector<std::string> &names() const { return value_.names; }
    bool has(const char *key) const { return value_.find(key) != nullptr; }
    bool has_object(const char *key) const;
    bool has_text(const char *key) const;
    bool has_any(const char *keys) const; // separated by spaces

    // Refuses keys that are not in `known`, suggesting the nearest one.
    void allow(const std::vector<std::string> &known) const;

    bool boolean(const char *key) const;
    double number(const char *key, Range range) const;
    double number(const Row &row) const;
    int64_t integer(const Row &row) const;
    std::vector<double> numbers(const Row &row) const;
    const std::string &text(const char *key) const;
    std::vector<std::string> texts(const Row &row) const;
    // Index of the string in the row's words.
    size_t choice(const Row &row) const;
    // A file name, relative to the scene's folder unless absolute; checks that the file exists and can be read.
    std::string file(const char *key) const;
    // Numbers and file names; each number is in the row's range.
    std::vector<NumberOrFile> numbers_and_files(const Row &row) const;
    Reader object(const char *key) const;
    std::vector<Reader> objects(const Row &row) const;

    // Fails with "<source>: <path>.<key><text>"; the format begins with ": " or " = ".
    [[noreturn]] void refuse(Status status, const char *key, const char *format, ...) const
        __attribute__((format(printf, 4, 5)));

  private:
    const json::Value &require(const char *key) const;
    const json::Value &require(const char *key, json::Value::Kind kind, const char *kind_name) const;
    const json::Value &array(const Row &row, const char *what, const char *entries) const;
    double checked(const std::string &key, const json::Value &value, Range range) const;
    std::string file_named(const std::string &key, const std::string &name) const;
    std::string full_key(const std::string &key) const { return path_.empty() ? key : path_ + "." + key; }

    const json::Value &value_;
    std::string path_;
    const Context &context_;
};

} // namespace toliman::scene
