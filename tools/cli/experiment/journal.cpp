// Format: JSON Lines; the first line has the arguments of the experiment, every other line one result, numbers with 17
// digits so that a resumed experiment has the same bits. A line is written by one write(2) with O_APPEND and
// fdatasync'ed at most once per second, since a sync takes as long as many results. flock keeps out a second process.
#include "experiment/journal.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <sstream>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/stop.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

[[noreturn]] void unwritable(const std::string &path) {
    throw Failure(kExitOutput, path + ": cannot be written: " + std::strerror(errno));
}

// Calls work(key, member) for all members of a row, in the order of a line.
template <class AnyRow, class Work> void for_members(AnyRow &row, Work work) {
    work("table", row.table);
    work("method", row.method);
    work("amplitude_px", row.amplitude_px);
    work("seed", row.seed);
    work("series", row.series);
    work("period_days", row.period_days);
    work("log10_fap", row.log10_fap);
    work("slope", row.slope);
    work("sigma", row.sigma);
    work("mean", row.mean);
}

bool read_value(const cJSON *item, std::string &value) {
    value = cJSON_IsString(item) ? item->valuestring : "";
    return cJSON_IsString(item);
}

bool read_value(const cJSON *item, double &value) {
    value = cJSON_IsNumber(item) ? item->valuedouble : NAN;
    return cJSON_IsNumber(item) || cJSON_IsNull(item);
}

bool read_value(const cJSON *item, uint64_t &value) {
    const bool whole = cJSON_IsNumber(item) && item->valuedouble >= 0 && item->valuedouble < 9e15;
    value = whole ? static_cast<uint64_t>(item->valuedouble) : 0;
    return whole;
}

} // namespace

Journal::Journal(const std::string &path)
    : path_(path), file_(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666)) {
    if (file_ < 0)
        unwritable(path_);
}

Journal::Journal(const std::string &path, const Json &arguments) : Journal(path) {
    struct stat status = {};
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0 || ::fstat(file_, &status) != 0 || status.st_nlink == 0)
        throw Failure(kExitOutput,
                      path_ + ": another process is writing to it: wait until it ends, or give another --out");
    read(arguments);
}

Journal::~Journal() {
    if (is_new_)
        ::unlink(path_.c_str());
    end_unfinished(path_);
    ::close(file_);
}

void Journal::read(const Json &arguments) {
    std::string text = whole_text(path_);
    const size_t whole = text.rfind('\n') + 1; // 0 without a newline
    if (whole < text.size() && ::ftruncate(file_, static_cast<off_t>(whole)) != 0)
        unwritable(path_);
    text.resize(whole);
    if (text.empty()) {
        is_new_ = make_unfinished(path_, [] { return true; });
        return append(arguments.line());
    }
    std::istringstream lines(text);
    std::string line;
    std::getline(lines, line);
    check_arguments(line, arguments);
    for (size_t number = 2; std::getline(lines, line); number++)
        rows_.insert(parse(line, number));
}

void Journal::check_arguments(const std::string &line, const Json &arguments) const {
    const JsonTree found(cJSON_ParseWithLength(line.data(), line.size()));
    if (!cJSON_IsObject(found.get()))
        malformed(path_ + ":1", "is not the journal of an experiment: give another --out");
    const JsonTree given(cJSON_Parse(arguments.line().c_str()));
    for (const cJSON *item = given->child; item != nullptr; item = item->next) {
        const cJSON *there = item_of(found.get(), item->string);
        if (cJSON_Compare(item, there, 1) == 0)
            throw Failure(kExitUsage, path_ + ": " + item->string + " = " +
                                          (there != nullptr ? line_of(there) : "nothing") + ": must be " +
                                          line_of(item) +
                                          ", as in this experiment: give another --out or the same arguments");
    }
}

Row Journal::parse(const std::string &line, size_t number) const {
    const JsonTree found(cJSON_ParseWithLength(line.data(), line.size()));
    Row row;
    bool is_result = true;
    for_members(row, [&](const char *key, auto &value) {
        is_result = is_result && read_value(item_of(found.get(), key), value);
    });
    if (!is_result || std::isnan(row.amplitude_px))
        malformed(path_ + ":" + std::to_string(number),
                  "is not a result of an experiment: remove this line, and the result is computed again");
    return row;
}

void Journal::add(const Row &row) {
    if (std::exchange(is_new_, false))
        end_unfinished(path_);
    Json line;
    for_members(row, [&](const char *key, const auto &value) {
        if constexpr (std::is_same_v<decltype(value), const double &>)
            line.set(key, Exact{value});
        else
            line.set(key, value);
    });
    append(line.line());
    rows_.insert(row);
}

std::vector<Row> Journal::rows(const std::string &table, const std::string &method, double amplitude_px) const {
    return {rows_.lower_bound({table, method, amplitude_px}),
            rows_.upper_bound({table, method, amplitude_px, UINT64_MAX, UINT64_MAX})};
}

void Journal::append(const std::string &line) {
    if (::write(file_, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
        unwritable(path_);
    const auto now = std::chrono::steady_clock::now();
    if (now - synced_ < std::chrono::seconds(1)) // a sync may take longer than a result
        return;
    if (::fdatasync(file_) != 0)
        unwritable(path_);
    synced_ = now;
}

} // namespace cli
