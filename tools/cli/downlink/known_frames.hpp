// The frames that were taken into account, by their keys.
#pragma once
#include "common/common.hpp"

#include <toliman/ingest.h>

namespace cli {

// What tells a frame from all others, in whatever file it arrives.
struct FrameKey {
    FrameKey(const toliman_frame &frame, const toliman_ingest_event &event);
    // Of raw pairs and batches: session, restarts of the camera and region; and the frame's id. Of .npy and FITS files:
    // the name without the number at its end, and this; of frames behind the first, the name and their number.
    std::string source;
    int64_t id, dropped; // dropped: ids before it that no frame has
};

class KnownFrames {
  public:
    bool contains(const FrameKey &key) const;
    void insert(const FrameKey &key);
    // {"session/restarts/roi": "0-41 43-99", ...}: ranges of ids.
    Json json() const;
    void read(const cJSON *object); // throws std::invalid_argument for anything else

  private:
    using Ranges = std::map<int64_t, int64_t>; // first -> last id, neither overlapping nor touching

    static void insert(Ranges &ranges, int64_t first, int64_t last);
    std::map<std::string, Ranges> sources_;
};

} // namespace cli
