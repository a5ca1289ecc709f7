// The header of ECSV tables, YAML in comments.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace toliman::ingest {

struct EcsvHeader {
    char delimiter = ' ';
    std::vector<std::pair<std::string, std::string>> units; // of names
};

// text: the comments of the header without their #. Of a malformed description, units may be missing.
EcsvHeader parse_ecsv(const std::string &text);

} // namespace toliman::ingest
