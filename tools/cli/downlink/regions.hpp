// Regions of the detector in the pairs of files: frames of two regions must not share a periodogram.
#pragma once
#include <set>
#include <string>
#include <vector>

namespace cli {

// roi_label of the first line of each side file that has one, in the order of the names.
std::set<std::string> regions_of(const std::vector<std::string> &sides);
// Throws Failure, which lists them, for files of several regions.
void check_one_region(const std::vector<std::string> &sides, const std::string &input);

} // namespace cli
