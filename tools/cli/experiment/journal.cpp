// Format: JSON Lines; the first line has the arguments of the experiment, every other line one result, numbers with 17
// digits so that a resumed experiment has the same bits. A line is written by one write(2) with O_APPEND and
// fdatasync'ed at most once per second, since a sync takes as long as many results. flock keeps out a second process.
#include "experiment/journal.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "common/failure.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

[[noreturn]] void unwritable(const std::string &path) {
    throw Failure(kExitOutput, path + ": cannot be written: " + std::strerror(errno));
}

std::string read_all(int file, const std::string &path) {
    std::string text;
    char part[1 << 16];
    for (ssize_t size; (size = ::read(file, part, sizeof part)) != 0;) {
        if (size < 0)
            malformed(path, std::strerror(errno));
        text.append(part, static_cast<size_t>(size));
    }
    return text;
}

std::string line_of(const cJSON *item) {
    char *printed = cJSON_PrintUnformatted(item);
    std::string text = printed != nullptr ? printed : "nothing";
    cJSON_free(printed);
    return text;
}

// All digits, so that the same bits are read again.
std::string number_text(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return std::isfinite(value) ? text : "null";
}

std::string line_of(const Row &row) {
    return "{\"table\":\"" + row.table + "\",\"method\":\"" + row.method +
           "\",\"amplitude_px\":" + number_text(row.amplitude_px) + ",\"seed\":" + std::to_string(row.seed) +
           ",\"series\":" + std::to_string(row.series) + ",\"period_days\":" + number_text(row.period_days) +
           ",\"log10_fap\":" + number_text(row.log10_fap) + ",\"slope\":" + number_text(row.slope) +
           ",\"sigma\":" + number_text(row.sigma) + ",\"mean\":" + number_text(row.mean) + "}";
}

bool read_text(const cJSON *line, const char *name, std::string &value) {
    const cJSON *item = item_of(line, name);
    if (!cJSON_IsString(item))
        return false;
    value = item->valuestring;
    return true;
}

bool read_number(const cJSON *line, const char *name, double &value) {
    const cJSON *item = item_of(line, name);
    value = cJSON_IsNumber(item) ? item->valuedouble : NAN;
    return cJSON_IsNumber(item) || cJSON_IsNull(item);
}

bool read_whole(const cJSON *line, const char *name, uint64_t &value) {
    double number;
    if (!read_number(line, name, number) || !(number >= 0 && number < 9e15))
        return false;
    value = static_cast<uint64_t>(number);
    return true;
}

} // namespace

std::string Journal::key_of(const Row &row) {
    return row.table + "|" + row.method + "|" + number_text(row.amplitude_px) + "|" + std::to_string(row.seed) + "|" +
           std::to_string(row.series);
}

Journal::Journal(const std::string &path, const JsonTree &arguments)
    : path_(path), file_(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666)) {
    if (file_ < 0)
        unwritable(path_);
    try {
        if (::flock(file_, LOCK_EX | LOCK_NB) != 0)
            throw Failure(kExitOutput,
                          path_ + ": another process is writing to it: wait until it ends, or give another --out");
        read(arguments);
    } catch (...) {
        ::close(file_);
        throw;
    }
}

Journal::~Journal() {
    ::close(file_);
}

void Journal::read(const JsonTree &arguments) {
    std::string text = read_all(file_, path_);
    const size_t whole = text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1;
    if (whole < text.size() && ::ftruncate(file_, static_cast<off_t>(whole)) != 0)
        unwritable(path_);
    text.resize(whole);
    if (text.empty())
        return append(line_of(arguments.get()));
    size_t number = 0;
    for (size_t start = 0; start < text.size();) {
        const size_t end = text.find('\n', start);
        const std::string line = text.substr(start, end - start);
        if (++number == 1)
            check_arguments(line, arguments);
        else
            parse(line, number);
        start = end + 1;
    }
}

void Journal::check_arguments(const std::string &line, const JsonTree &arguments) const {
    const JsonTree found(cJSON_ParseWithLength(line.data(), line.size()));
    if (!cJSON_IsObject(found.get()))
        malformed(path_ + ":1", "is not the journal of an experiment: give another --out");
    for (const cJSON *item = arguments->child; item != nullptr; item = item->next) {
        const cJSON *there = item_of(found.get(), item->string);
        if (cJSON_Compare(item, there, 1) == 0)
            throw Failure(kExitUsage, path_ + ": " + item->string + " = " + line_of(there) + ": must be " +
                                          line_of(item) +
                                          ", as in this experiment: give another --out or the same arguments");
    }
}

void Journal::parse(const std::string &line, size_t number) {
    const JsonTree found(cJSON_ParseWithLength(line.data(), line.size()));
    const cJSON *json = found.get();
    Row row;
    if (!read_text(json, "table", row.table) || !read_text(json, "method", row.method) ||
        !read_number(json, "amplitude_px", row.amplitude_px) || !read_whole(json, "seed", row.seed) ||
        !read_whole(json, "series", row.series) || !read_number(json, "period_days", row.period_days) ||
        !read_number(json, "log10_fap", row.log10_fap) || !read_number(json, "slope", row.slope) ||
        !read_number(json, "sigma", row.sigma) || !read_number(json, "mean", row.mean))
        malformed(path_ + ":" + std::to_string(number),
                  "is not a result of an experiment: remove this line, and the result is computed again");
    if (place_.emplace(key_of(row), rows_.size()).second)
        rows_.push_back(row);
}

void Journal::add(const Row &row) {
    append(line_of(row));
    place_.emplace(key_of(row), rows_.size());
    rows_.push_back(row);
}

void Journal::append(const std::string &line) {
    const std::string text = line + "\n";
    if (::write(file_, text.data(), text.size()) != static_cast<ssize_t>(text.size()))
        unwritable(path_);
    const auto now = std::chrono::steady_clock::now();
    if (now - synced_ < std::chrono::seconds(1)) // a sync may take longer than a result
        return;
    if (::fdatasync(file_) != 0)
        unwritable(path_);
    synced_ = now;
}

} // namespace cli
