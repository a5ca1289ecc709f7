// Names of sessions and regions by their digests, a line each beside the ledger (tools/docs/formats.md "streams.txt"):
// for people. What is lost of them costs no frame.
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
    // Hands out every line that is whole.
    using Each = std::function<void(uint64_t stream, const std::string &session, const std::string &roi)>;
    void visit(const Each &each) const;
    // Makes the file, so that adding to it allocates nothing.
    void begin();
    // Adds a line.
    void add(uint64_t stream, std::string_view session, std::string_view roi);
    // Brings added lines to the disk.
    void sync();

  private:
    Store &store_;
    bool added_ = false;
};

} // namespace toliman::track
