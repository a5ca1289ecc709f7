#include "frames/frame_files.hpp"

#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <set>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "frames/frames_in.hpp"

namespace cli {

namespace {

constexpr const char kSide[] = "_meta.jsonl", kPixels[] = "_frames.bin", kBatch[] = ".nc";
constexpr int kMostLines = 100;       // that are tried, as the first ones may be damaged
constexpr size_t kLongestLine = 4096; // of a side file

// Method: a child process reads the file and tells by its end whether that was possible, so that one damaged file does
// not end a run of many. netCDF is loaded before, once for all children.

[[noreturn]] void read_and_exit(const std::string &path) noexcept {
    const rlimit no_core = {0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    const int null = ::open("/dev/null", O_WRONLY);
    ::dup2(null, STDERR_FILENO); // what the C library says of a damaged heap
    auto options = toliman::sized<toliman_ingest_options>();
    options.pixel = TOLIMAN_PIXEL_U16;
    toliman_ingest *reader = nullptr;
    toliman_status status = toliman_ingest_create(path.c_str(), &options, &reader);
    auto event = toliman::sized<toliman_ingest_event>();
    while (status == TOLIMAN_OK && event.event != TOLIMAN_INGEST_EVENT_NOTHING) {
        auto frame = toliman::sized<toliman_frame>();
        event = toliman::sized<toliman_ingest_event>();
        status = toliman_ingest_next(reader, &frame, &event);
    }
    ::_exit(0);
}

// Orders names that end with a number by this: batch9999 is before batch10000.
struct InTime {
    bool operator()(const std::string &a, const std::string &b) const noexcept {
        return a.size() != b.size() ? a.size() < b.size() : a < b;
    }
};

} // namespace

bool is_pair(const std::string &path) {
    return ends_with(path, kSide) || ends_with(path, kPixels);
}

bool is_batch(const std::string &path) {
    return ends_with(path, kBatch);
}

std::string other_file(const std::string &path) {
    const bool is_side = ends_with(path, kSide);
    return path.substr(0, path.size() - std::strlen(is_side ? kSide : kPixels)) + (is_side ? kPixels : kSide);
}

std::string side_of(const std::string &path) {
    return ends_with(path, kSide) ? path : other_file(path);
}

bool is_dated_file(const std::string &path) {
    return ends_with(path, ".npy") || is_fits(path);
}

std::vector<std::string> files_of(const std::string &path) {
    std::error_code error;
    std::set<std::string> pairs;
    std::set<std::string, InTime> batches, fits;
    for (std::filesystem::directory_iterator entry(path, error), end; entry != end; entry.increment(error)) {
        const std::string name = entry->path().filename().native(), file = plain(path) + "/" + name;
        if (is_pair(name))
            pairs.insert(side_of(file));
        else if (is_batch(name))
            batches.insert(file);
        else if (is_fits(name))
            fits.insert(file);
    }
    if (error)
        malformed(path, error.message());
    if (!pairs.empty())
        return {pairs.begin(), pairs.end()};
    const auto &files = !batches.empty() ? batches : fits;
    return {files.begin(), files.end()};
}

std::vector<std::string> pairs_of(const std::string &path) {
    const std::vector<std::string> files = files_of(path);
    return !files.empty() && is_pair(files.front()) ? files : std::vector<std::string>();
}

void check_complete(const std::string &side) {
    for (const std::string &path : {side, other_file(side)})
        if (!exists(path))
            malformed(path, std::strerror(errno) +
                                std::string(exists(other_file(path)) ? ", required next to " + other_file(path) : ""));
}

std::string region_of(const std::string &side) {
    std::ifstream file(side);
    std::string line(kLongestLine, '\0');
    for (int i = 0; i < kMostLines && file.getline(line.data(), static_cast<std::streamsize>(line.size())); i++) {
        const JsonTree tree(cJSON_Parse(line.c_str()));
        const cJSON *const roi = cJSON_GetObjectItemCaseSensitive(tree.get(), "roi_label");
        if (cJSON_IsString(roi))
            return roi->valuestring;
    }
    return "";
}

bool has_pairs(const std::string &input) {
    try {
        return is_folder(input) ? !pairs_of(input).empty() : is_pair(input);
    } catch (const Failure &) {
        return false;
    }
}

bool has_stamps(const std::vector<std::string> &inputs) {
    return std::any_of(inputs.begin(), inputs.end(), [](const std::string &input) {
        const std::vector<std::string> files = is_folder(input) ? files_of(input) : std::vector<std::string>{input};
        return files.empty() || !is_dated_file(files.front());
    });
}

void check_one_region(const std::vector<std::string> &inputs) {
    std::set<std::string> regions;
    for (const std::string &input : inputs)
        if (has_pairs(input))
            for (const std::string &side : is_folder(input) ? pairs_of(input) : std::vector<std::string>{input})
                regions.insert(region_of(side_of(side)));
    regions.erase("");
    if (regions.size() < 2)
        return;
    std::string names;
    for (const std::string &region : regions)
        names += (names.empty() ? "" : ", ") + region;
    throw Failure(kExitUsage, (inputs.size() == 1 ? inputs.front() : "the inputs") + ": frames of the regions " +
                                  names + ": --roi LABEL takes those of one");
}

void probe_batch(const std::string &path) {
    if (toliman_ingest_netcdf_version()[0] == '\0')
        return;
    const pid_t child = ::fork();
    if (child == 0)
        read_and_exit(path);
    int status = 0;
    while (child > 0 && ::waitpid(child, &status, 0) < 0 && errno == EINTR)
        ;
    if (child > 0 && WIFSIGNALED(status))
        malformed(path, "is damaged: netCDF crashes on it");
}

} // namespace cli
