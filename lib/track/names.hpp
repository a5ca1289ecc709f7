// Names of sessions and regions, and restarts of the camera, by digest, one line each (tools/docs/formats.md,
// "streams.txt"); for display only: losing them loses no frame.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "backend/store.hpp"

namespace toliman::track {

class Names {
  public:
    static constexpr const char *kName = "streams.txt";
    explicit Names(Store &store) : store_(store) {}
    struct Stream {
        std::string session, roi;
        int64_t restarts = 0;
    };
    // Calls each for every valid line.
    using Each = std::function<void(uint64_t digest, const Stream &stream)>;
    void visit(const Each &each) const;
    // Creates the file, so that adding to it does not allocate.
    void begin();
    // Adds a line.
    void add(uint64_t digest, std::string_view session, std::string_view roi, int64_t restarts);
    // fsync's added lines.
    void sync();

  private:
    Store &store_;
    bool added_ = false;
};

} // namespace toliman::track
