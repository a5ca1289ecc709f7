// Method: members are appended to one string; a tree of cJSON took 40 allocations per line of track. The text is the
// one that cJSON prints: numbers have 15 digits if these are read as the number within 2^-52 of it, else 17.
// std::to_chars gives the digits of printf in a third of the time.
#include "common/json.hpp"

#include <charconv>
#include <ctime>
#include <fstream>
#include <limits>

#include "common/common.hpp"

namespace cli {

namespace {

struct Digits {
    char text[32];
    size_t length;
};

// As printf("%.*g").
Digits digits_of(double value, int precision) {
    Digits digits;
    char *const end =
        std::to_chars(digits.text, digits.text + sizeof digits.text, value, std::chars_format::general, precision).ptr;
    digits.length = static_cast<size_t>(end - digits.text);
    return digits;
}

bool is_read_as(const Digits &digits, double value) {
    double read = 0;
    std::from_chars(digits.text, digits.text + digits.length, read);
    return read == value; // cJSON ignores the last bit
}

// One member per line, with tabs, as cJSON_Print does.
std::string indented(const std::string &line) {
    std::string text, open; // brackets that are open
    for (size_t i = 0; i < line.size(); i++) {
        const char c = line[i];
        if (c == '}' || c == ']')
            open.pop_back();
        if (c == '}' && text.back() != '\n')
            text += '\n';
        if (!text.empty() && text.back() == '\n')
            text.append(open.size(), '\t');
        text += c;
        if (c == '{' || c == '[')
            open += c;
        if (c == '{' || (c == ',' && open.back() == '{'))
            text += '\n';
        else if (c == ',')
            text += ' ';
        else if (c == ':')
            text += '\t';
        for (bool in_string = c == '"'; in_string;) {
            in_string = line[++i] != '"';
            if (line[i] == '\\')
                text += line[i++];
            text += line[i];
        }
    }
    return text + "\n";
}

std::string in_quotes(const std::string &word) {
    constexpr char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=,+@%-";
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos)
        return word;
    std::string text = "'";
    for (const char letter : word)
        text += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
    return text + "'";
}

// /proc/self/cmdline holds the words, each ended by a zero byte. The first is the path of the program.
std::string command_line() {
    std::ifstream file("/proc/self/cmdline", std::ios::binary);
    std::string word, text = "toliman";
    std::getline(file, word, '\0');
    while (std::getline(file, word, '\0'))
        text += " " + in_quotes(word);
    return text;
}

std::string utc_date() {
    const std::time_t now = std::time(nullptr);
    std::tm parts = {};
    char text[32] = "";
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", ::gmtime_r(&now, &parts));
    return text;
}

} // namespace

std::string text_of(const JsonTree &tree) {
    return indented(line_of(tree.get()));
}

std::string line_of(const cJSON *item) {
    char *const printed = cJSON_PrintUnformatted(item);
    std::string text = printed != nullptr ? printed : "";
    cJSON_free(printed);
    return text;
}

std::string Json::text() const {
    return indented("{" + members_ + "}");
}

void Json::add_text(std::string_view text) {
    constexpr std::string_view kEscaped = "\"\\\b\f\n\r\t", kLetters = "\"\\bfnrt";
    members_ += '"';
    for (const char c : text) {
        const size_t place = static_cast<unsigned char>(c) > '\\' ? kEscaped.npos : kEscaped.find(c);
        if (place != kEscaped.npos)
            (members_ += '\\') += kLetters[place];
        else if (static_cast<unsigned char>(c) < ' ')
            members_ += formatted("\\u%04x", c);
        else
            members_ += c;
    }
    members_ += '"';
}

void Json::add_number(double value) {
    const Digits digits = digits_of(value == 0 ? 0.0 : value, 15); // also -0, as cJSON prints it
    if (std::isfinite(value) && is_read_as(digits, value))
        members_.append(digits.text, digits.length);
    else
        add_exact(value);
}

void Json::add_exact(double value) {
    const Digits digits = digits_of(value, 17);
    std::isfinite(value) ? members_.append(digits.text, digits.length) : members_ += "null";
}

std::string processor_name() {
    std::ifstream cpuinfo("/proc/cpuinfo");
    for (std::string line; std::getline(cpuinfo, line);)
        if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
            return line.substr(line.find(": ") + 2);
    return "unknown";
}

Json provenance() {
    return Json("command", command_line(), "date", utc_date(), "processor", processor_name());
}

} // namespace cli
