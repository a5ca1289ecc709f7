#include "series/columns.hpp"

#include <cstdlib>

namespace cli {

namespace {

constexpr char kSpace[] = " \t\r\v\f";

std::vector<std::string> words_of(const std::string &line) {
    std::vector<std::string> words;
    for (size_t start = line.find_first_not_of(kSpace); start != std::string::npos;) {
        const size_t end = line.find_first_of(kSpace, start);
        words.push_back(trimmed(line.substr(start, end - start)));
        start = line.find_first_not_of(kSpace, end);
    }
    return words.empty() ? std::vector<std::string>{""} : words;
}

} // namespace

char separator_of(const std::string &line) {
    if (line.find(';') != std::string::npos)
        return ';';
    return line.find(',') != std::string::npos ? ',' : ' ';
}

const char *separator_name(char separator) noexcept {
    return separator == ';' ? "semicolons" : separator == ',' ? "commas" : "white space";
}

std::string trimmed(const std::string &text) {
    const size_t first = text.find_first_not_of(kSpace);
    if (first == std::string::npos)
        return "";
    const std::string word = text.substr(first, text.find_last_not_of(kSpace) - first + 1);
    const bool quoted = word.size() >= 2 && word.front() == '"' && word.back() == '"';
    return quoted ? word.substr(1, word.size() - 2) : word;
}

std::vector<std::string> split(const std::string &line, char separator) {
    if (separator == ' ')
        return words_of(line);
    std::vector<std::string> fields;
    fields.reserve(3);
    size_t start = 0;
    for (size_t end; (end = line.find(separator, start)) != std::string::npos; start = end + 1)
        fields.push_back(trimmed(line.substr(start, end - start)));
    fields.push_back(trimmed(line.substr(start)));
    return fields;
}

bool number_of(const std::string &field, double &value) {
    char *end = nullptr;
    value = std::strtod(field.c_str(), &end);
    return !field.empty() && end == field.c_str() + field.size();
}

bool decimal_comma(const std::string &field) {
    const size_t comma = field.find(',');
    double value;
    return comma != std::string::npos && comma + 1 < field.size() &&
           number_of(std::string(field).replace(comma, 1, "."), value);
}

} // namespace cli
