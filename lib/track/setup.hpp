// What the sums depend on beside the ledger: the grid of frequencies and the clock (lib/FORMATS.md "TLMS").
#pragma once
#include <cstdint>
#include <optional>

#include "backend/store.hpp"
#include "period/stream.hpp"
#include "track/clock.hpp"

namespace toliman::track {

struct Setup {
    static constexpr const char *kName = "setup.tlms";
    period::Grid grid; // as a stream has it
    Clock clock;
    uint32_t digest() const;
};

// Status::write; the old one then stands.
void save(Store &store, const Setup &setup);

// What there is, or nothing if there is none or it is damaged.
std::optional<Setup> load_setup(Store &store);

} // namespace toliman::track
