// Warnings about many frames, files or lines: the first of each kind are told at once, the number of all at the end.
#pragma once
#include <set>

#include "common/common.hpp"

namespace cli {

constexpr int64_t kMostInputs = 10; // warnings of one kind about inputs or lines, each of which has its own cause

class Warnings {
  public:
    explicit Warnings(Progress &progress) : progress_(progress) {}

    // most: number of warnings of this kind that are told.
    void warn(const std::string &kind, const std::string &text, int64_t most = 1) {
        Kind &known = kinds_[kind];
        known.most = most;
        if (known.count++ < most)
            progress_.warn(text);
    }
    // A message, once for each kind, that is not a warning.
    void tell(const std::string &kind, const std::string &text) {
        if (notes_.insert(kind).second)
            progress_.tell(text);
    }
    // Warns for each kind of which some were not told: text(kind, number of all, number of those told).
    template <class Text> void end(Text text) const {
        for (const auto &[name, kind] : kinds_)
            if (kind.count > kind.most)
                progress_.warn(text(name, kind.count, kind.most));
    }

  private:
    struct Kind {
        int64_t count = 0, most = 1;
    };

    Progress &progress_;
    std::map<std::string, Kind> kinds_;
    std::set<std::string> notes_;
};

} // namespace cli
