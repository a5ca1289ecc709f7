// Setup: what a folder records in addition to the ledger: frequency grid, clock, how the times of its frames were
// read, and the reference of their reduction (tools/docs/formats.md, "TLMS").
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "backend/store.hpp"
#include "base/goodness.hpp"
#include "period/stream/stream.hpp"
#include "track/clock.hpp"
#include "track/reduction.hpp"
#include "track/terms.hpp"

namespace toliman::track {

enum class Stamp : int32_t { start = 0, middle = 1, end = 2 };

// Time stamps from which the camera times of all frames were computed. Recorded only: they change no time.
struct Timing {
    Stamp stamp = Stamp::middle;
    double exposure_s = 0; // 0: unknown
    bool operator==(const Timing &other) const noexcept {
        return stamp == other.stamp && exposure_s == other.exposure_s;
    }
};

// What is known of the model that measures the frames: of the calibration of its scene.
struct ModelVerdict {
    bool is_calibrated = false;
    bool is_complete = true; // the calibration found no effect that its model lacks
    Goodness goodness = {};  // of the calibration
};

// Status::mismatch, naming the setup file at `path`, if its reference differs.
void check_reference(const Reference &in_file, const Reference &own, const std::string &path);

// Status::mismatch, naming the setup file at `path`, if its timing differs from that of the tracker.
void check_timing(const Timing &in_file, const Timing &own, const std::string &path);

struct Setup {
    static constexpr const char *kName = "setup.tlms";
    static constexpr const char *kNewName = "setup.tlms.new"; // of a ledger that is about to get its name
    period::Grid grid;                                        // as of Stream::grid()
    Clock clock;
    Timing timing = {};
    Reference reference = {};
    uint64_t salt = 0;       // with a reference: of the ledger whose frames are reduced to it
    OrbitErrors errors = {}; // columns of the grid
    double chi_limit = 0;    // of the chi-square of a frame; 0: from the median (misfit.hpp)
    ModelVerdict model = {};
    uint32_t digest() const;
};

std::vector<uint8_t> to_bytes(const Setup &setup);

// Returns the setup of the folder's ledger, also if a crash left it under the new name. None if it is missing or
// damaged, or if the frames of the ledger are not reduced to its reference.
std::optional<Setup> load_setup(Store &store);

// Gives a setup that has the new name, and belongs to the ledger, its name.
void settle_setup(Store &store);

// Returns the grid with value_bound and sigmas as the terms determine them. A grid that differs from the result does
// not belong to a ledger with these terms.
period::Grid for_terms(period::Grid grid, const Terms &terms);

} // namespace toliman::track
