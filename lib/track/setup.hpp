// What the sums depend on beside the ledger: the grid of frequencies and the clock (tools/docs/formats.md "TLMS").
#pragma once
#include <cstdint>
#include <optional>

#include "backend/store.hpp"
#include "period/stream.hpp"
#include "track/clock.hpp"
#include "track/terms.hpp"

namespace toliman::track {

struct Setup {
    static constexpr const char *kName = "setup.tlms";
    period::Grid grid; // as a stream has it
    Clock clock;
    uint32_t digest() const;
};

std::vector<uint8_t> to_bytes(const Setup &setup);

// What there is, or nothing if there is none or it is damaged.
std::optional<Setup> load_setup(Store &store);

// The same frequencies and times, and of values what the terms say. A grid that differs from this does not belong to
// a ledger on these terms.
period::Grid for_terms(period::Grid grid, const Terms &terms);

} // namespace toliman::track
