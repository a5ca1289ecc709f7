// What a frame's line in the ledger depends on beside the frame. Ledgers of the same terms can be merged.
#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "track/frame.hpp"

namespace toliman::track {

struct Terms {
    Geometry geometry = {};
    double sigma = 0;       // of every value
    double value_limit = 0; // values further from 0 are outliers
    uint64_t estimator = 0; // digest of what makes the values
    void check() const;     // Status::argument
    // A frame may have its own sigma.
    bool allows_sigma(double own) const noexcept { return own >= sigma && own <= kMostSigmas * sigma; }
    static constexpr double kMostSigmas = 32;
    // Whether a line on these terms can say that.
    bool allow(const Record &record) const noexcept;
};

// The first thing in which they differ, for messages.
std::string difference(const Terms &there, const Terms &here);

constexpr size_t kTermsSize = 9 * 8 + 3 * 8;
using TermsBytes = std::array<uint8_t, kTermsSize>;
TermsBytes to_bytes(const Terms &terms) noexcept;
Terms terms_of(const uint8_t *bytes) noexcept;

} // namespace toliman::track
