// Terms: everything other than the frame that determines a ledger record. Ledgers with equal terms can be merged.
#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "track/frame.hpp"

namespace toliman::track {

struct Terms {
    Geometry geometry = {};
    double sigma = 0;       // of a value; the smallest one
    double value_limit = 0; // larger |values| are outliers
    uint64_t estimator = 0; // digest of the estimator
    void check() const;     // Status::argument
    // Returns whether a frame may have this sigma of its own.
    bool allows_sigma(double own) const noexcept { return own >= sigma && own <= kMaxSigmaRatio * sigma; }
    static constexpr double kMaxSigmaRatio = 32;
    // Returns whether a record with these terms can have this content. reduced: of a ledger whose values are reduced,
    // so that the limit does not apply to the estimate.
    bool allow(const Record &record, bool reduced) const noexcept;
};

// Describes the first difference, for messages.
std::string difference(const Terms &there, const Terms &here);

constexpr size_t kTermsSize = 9 * 8 + 3 * 8;
using TermsBytes = std::array<uint8_t, kTermsSize>;
TermsBytes to_bytes(const Terms &terms) noexcept;
Terms terms_of(const uint8_t *bytes) noexcept;

} // namespace toliman::track
