// Results that other commands left: JSON of a known schema, and CSV of known columns. What is not as formats.md has
// it is a Failure that names file and key.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "common/json.hpp"

namespace cli {

using Items = std::vector<const cJSON *>;

class ResultFile {
  public:
    ResultFile(const std::string &path, const std::string &schema);
    // Keys of nested objects are written "template.sigma_px". NaN where the file has null.
    double number(const std::string &key) const { return number_in(tree_.get(), key); }
    double number_or(const std::string &key, double otherwise) const;
    std::string text(const std::string &key) const { return text_in(tree_.get(), key); }
    bool flag(const std::string &key) const;
    bool has(const std::string &key) const; // and not null
    // A whole number to its last digit, as the file has it; at the top level.
    std::string digits(const std::string &key) const;
    // Objects of an array.
    Items list(const std::string &key) const { return list_in(tree_.get(), key); }
    Items list_in(const cJSON *object, const std::string &key) const;
    double number_in(const cJSON *object, const std::string &key) const;
    double number_in(const cJSON *object, const std::string &key, double otherwise) const;
    double positive_in(const cJSON *object, const std::string &key) const;
    std::string text_in(const cJSON *object, const std::string &key) const;
    std::string text_in(const cJSON *object, const std::string &key, const std::string &otherwise) const;
    const JsonTree &tree() const noexcept { return tree_; }

  private:
    [[noreturn]] void wrong(const std::string &key, const char *what) const;
    std::string path_, text_;
    JsonTree tree_;
};

// The schema that a JSON file names, "" for any other file.
std::string schema_of(const std::string &path);

// A CSV file of columns t,y under these names, as read_series has it; an error where it is not as long as the others.
std::vector<double> column_of(const std::string &path, const std::string &axis, const std::string &name);
std::vector<std::string> header_of(const std::string &path);
// Its rows as texts, of the columns with these names.
using Cells = std::vector<std::string>;
void for_rows(const std::string &path, const std::vector<std::string> &columns,
              const std::function<void(const Cells &cells)> &work);
double number_of(const std::string &path, const std::string &cell);

} // namespace cli
