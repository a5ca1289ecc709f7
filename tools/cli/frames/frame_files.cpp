#include "frames/frame_files.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/json.hpp"
#include "common/text.hpp"
#include "frames/frames_in.hpp"

namespace cli {

namespace {

constexpr const char kSide[] = "_meta.jsonl", kPixels[] = "_frames.bin", kBatch[] = ".nc";
constexpr int kMostLines = 100;       // that are tried, as the first ones may be damaged
constexpr size_t kLongestLine = 4096; // of a side file

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
    std::set<std::string> pairs, batches, fits;
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
    const std::set<std::string> &files = !pairs.empty() ? pairs : !batches.empty() ? batches : fits;
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

} // namespace cli
