#include "common/provenance.hpp"

#include <ctime>
#include <fstream>

namespace cli {

namespace {

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
