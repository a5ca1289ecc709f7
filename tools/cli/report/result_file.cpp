#include "report/result_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/lines.hpp"
#include "common/terminal.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

constexpr size_t kMostBytes = 1 << 26; // of a JSON file

std::string bytes_of(const std::string &path) {
    if (InputFile(path).size() > kMostBytes)
        malformed(path, "is too long for a result");
    return whole_text(path);
}

const cJSON *found(const cJSON *object, const std::string &key) {
    const size_t dot = key.find('.');
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key.substr(0, dot).c_str());
    return item == nullptr || dot == std::string::npos ? item : found(item, key.substr(dot + 1));
}

Cells cells_of(const std::string &line) {
    Cells cells(1);
    for (const char letter : line)
        if (letter == ',')
            cells.emplace_back();
        else if (letter != '\r')
            cells.back() += letter;
    return cells;
}

// Lines without remarks; the first has the names.
void for_lines(const std::string &path, const std::function<bool(const Cells &cells, const std::string &where)> &work) {
    InputFile check(path); // a pipe would be waited for
    LineSource source(path, stop_if_asked);
    std::string line;
    for (int number = 1; source.next(line); number++)
        if (!line.empty() && line[0] != '#' && !work(cells_of(line), path + ":" + std::to_string(number)))
            return;
}

} // namespace

ResultFile::ResultFile(const std::string &path, const std::string &schema)
    : path_(path), text_(bytes_of(path)), tree_(cJSON_ParseWithLength(text_.data(), text_.size())) {
    if (!cJSON_IsObject(tree_.get()))
        malformed(path, "is damaged: no JSON object");
    const std::string own = text_in(tree_.get(), "schema", "");
    if (own != schema)
        malformed(path, "schema = " + (own.empty() ? "missing" : own) + ": must be " + schema);
}

void ResultFile::wrong(const std::string &key, const char *what) const {
    malformed(path_, key + ": must be " + what);
}

double ResultFile::number_in(const cJSON *object, const std::string &key) const {
    const cJSON *item = found(object, key);
    if (cJSON_IsNull(item))
        return NAN;
    if (!cJSON_IsNumber(item))
        wrong(key, "a number");
    if (!std::isfinite(item->valuedouble)) // 1e999
        wrong(key, "a finite number");
    return item->valuedouble;
}

double ResultFile::positive_in(const cJSON *object, const std::string &key) const {
    const double value = number_in(object, key);
    if (!(value > 0))
        wrong(key, "above 0");
    return value;
}

double ResultFile::number_in(const cJSON *object, const std::string &key, double otherwise) const {
    return found(object, key) == nullptr ? otherwise : number_in(object, key);
}

double ResultFile::number_or(const std::string &key, double otherwise) const {
    return number_in(tree_.get(), key, otherwise);
}

std::string ResultFile::text_in(const cJSON *object, const std::string &key) const {
    const cJSON *item = found(object, key);
    if (!cJSON_IsString(item))
        wrong(key, "text");
    return item->valuestring;
}

std::string ResultFile::text_in(const cJSON *object, const std::string &key, const std::string &otherwise) const {
    return found(object, key) == nullptr ? otherwise : text_in(object, key);
}

bool ResultFile::flag(const std::string &key) const {
    const cJSON *item = found(tree_.get(), key);
    if (!cJSON_IsBool(item))
        wrong(key, "true or false");
    return cJSON_IsTrue(item) != 0;
}

bool ResultFile::has(const std::string &key) const {
    const cJSON *item = found(tree_.get(), key);
    return item != nullptr && !cJSON_IsNull(item);
}

std::string ResultFile::digits(const std::string &key) const {
    if (!cJSON_IsNumber(found(tree_.get(), key)))
        wrong(key, "a number");
    const size_t name = text_.find("\"" + key + "\"");
    const size_t at = name == std::string::npos ? name : text_.find_first_of("0123456789", name + key.size() + 2);
    if (at == std::string::npos)
        wrong(key, "a number in digits");
    return text_.substr(at, text_.find_first_not_of("0123456789", at) - at);
}

Items ResultFile::list_in(const cJSON *object, const std::string &key) const {
    const cJSON *array = found(object, key);
    if (!cJSON_IsArray(array))
        wrong(key, "a list of objects");
    Items items;
    const cJSON *item = nullptr;
    cJSON_ArrayForEach(item, array) {
        if (!cJSON_IsObject(item))
            wrong(key, "a list of objects");
        items.push_back(item);
    }
    return items;
}

std::string schema_of(const std::string &path) {
    const std::string text = bytes_of(path);
    const JsonTree tree(cJSON_ParseWithLength(text.data(), text.size()));
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(tree.get(), "schema");
    return cJSON_IsString(item) ? item->valuestring : "";
}

std::vector<double> column_of(const std::string &path, const std::string &axis, const std::string &name) {
    return read_series(path, {axis, name}).y;
}

std::vector<std::string> header_of(const std::string &path) {
    Cells names;
    for_lines(path, [&](const Cells &cells, const std::string &) {
        names = cells;
        return false;
    });
    return names;
}

void for_rows(const std::string &path, const std::vector<std::string> &columns,
              const std::function<void(const Cells &cells)> &work) {
    std::vector<size_t> places;
    size_t width = 0;
    for_lines(path, [&](const Cells &cells, const std::string &where) {
        if (width == 0) {
            width = cells.size();
            for (const std::string &name : columns) {
                const auto at = std::find(cells.begin(), cells.end(), name);
                if (at == cells.end())
                    malformed(where, "has no column " + name);
                places.push_back(static_cast<size_t>(at - cells.begin()));
            }
            return true;
        }
        if (cells.size() != width)
            malformed(where, "has " + std::to_string(cells.size()) + " columns, the header " + std::to_string(width));
        Cells chosen;
        for (const size_t place : places)
            chosen.push_back(cells[place]);
        work(chosen);
        return true;
    });
}

double number_of(const std::string &path, const std::string &cell) {
    char *end = nullptr;
    const double value = std::strtod(cell.c_str(), &end);
    if (cell.empty() || *end != '\0')
        malformed(path, "'" + cell + "' is no number");
    return value;
}

} // namespace cli
