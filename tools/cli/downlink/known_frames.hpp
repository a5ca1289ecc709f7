// The frames that were taken into account, by their keys: session, restarts of the camera, region and id.
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include <toliman/frame.h>

#include "common/json.hpp"

namespace cli {

class KnownFrames {
  public:
    bool contains(const toliman_frame &frame) const;
    void insert(const toliman_frame &frame);
    // {"session/restarts/roi": "0-41 43-99", ...}; text of each: ranges of ids.
    Json json() const;
    void read(const cJSON *object); // throws std::invalid_argument for anything else

  private:
    using Ranges = std::map<int64_t, int64_t>; // first -> last id, neither overlapping nor touching

    static void insert(Ranges &ranges, int64_t first, int64_t last);
    static void close_smallest_gap(Ranges &ranges);
    std::map<std::string, Ranges> keys_;
};

} // namespace cli
