// Position and velocity of the Earth's centre at any time.
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "backend/erfa.hpp"

namespace toliman::sky {

// Any number of threads may call at().
class Earth : public std::enable_shared_from_this<Earth> {
  public:
    // The one that other objects of the process hold, or a new one.
    static std::shared_ptr<const Earth> shared();

    struct State {
        erfa::EarthState earth;
        double tdb_minus_tt; // s
    };

    // days: TT since J2000.0, of the years 1900 to 2100.
    State at(double days) const;

  private:
    const State &day(int64_t number) const; // at 0 h; under the lock

    mutable std::mutex mutex_;
    mutable std::unordered_map<int64_t, State> days_;
};

} // namespace toliman::sky
