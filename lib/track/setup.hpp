// Setup: what the sums depend on in addition to the ledger, frequency grid and clock (tools/docs/formats.md, "TLMS").
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
    period::Grid grid; // as of Stream::grid()
    Clock clock;
    uint32_t digest() const;
};

std::vector<uint8_t> to_bytes(const Setup &setup);

// Returns none if the file is missing or damaged.
std::optional<Setup> load_setup(Store &store);

// Returns the grid with value_bound and sigmas as the terms determine them. A grid that differs from the result does
// not belong to a ledger with these terms.
period::Grid for_terms(period::Grid grid, const Terms &terms);

} // namespace toliman::track
