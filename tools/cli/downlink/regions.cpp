#include "downlink/regions.hpp"

#include <fstream>

#include "common/failure.hpp"
#include "common/json.hpp"

namespace cli {

namespace {

constexpr int kMostLines = 100;     // that are tried, as the first ones may be damaged
constexpr size_t kLongestLine = 4096; // of a side file

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

} // namespace

std::set<std::string> regions_of(const std::vector<std::string> &sides) {
    std::set<std::string> regions;
    for (const std::string &side : sides)
        regions.insert(region_of(side));
    regions.erase("");
    return regions;
}

void check_one_region(const std::vector<std::string> &sides, const std::string &input) {
    const std::set<std::string> regions = regions_of(sides);
    if (regions.size() < 2)
        return;
    std::string names;
    for (const std::string &region : regions)
        names += (names.empty() ? "" : ", ") + region;
    throw Failure(kExitUsage, input + ": has frames of the regions " + names +
                                  ": --roi LABEL takes those of one, for a folder of its own");
}

} // namespace cli
