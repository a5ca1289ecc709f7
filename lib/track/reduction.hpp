// Reduction of measured separations: what a planet changes, without the orbit of the binary and without the motion of
// the observer.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "period/stream/basis.hpp"
#include "track/clock.hpp"
#include "track/columns.hpp"
#include "track/record.hpp"

namespace toliman::track {

constexpr char kMeasured[] = "separation_px"; // name of the value that is reduced

// Time on target, TAI.
struct Span {
    int64_t start_ns, end_ns;
};

// Time on target of a frame.
struct OnTarget {
    std::vector<Span> spans; // increasing; a single one of length zero: the exposure is not known
    bool listed = false;     // the frame came with a list of its intervals; otherwise it is the whole exposure
};

// Means over the time on target of a frame.
struct Reduction {
    double factor = 0;           // apparent separation over geometric separation
    double geometric_arcsec = 0; // separation on the reference orbit
    double partials[kPartials] = {};
};

// Reduces a frame. Returns Reason::none, or why it cannot be reduced.
using Reduce = std::function<Reason(const OnTarget &on_target, Reduction &reduction)>;

// The reference orbit and plate scale of a folder. They are fixed until it is rebuilt: sums of other references do not
// add up.
struct Reference {
    std::string system;      // JSON text; empty: frames are not reduced
    double scale_arcsec = 0; // per px
    bool in_orbit = false;   // the observer; false: at the Earth's centre, up to 8 km/s slower
    bool is_given() const noexcept { return !system.empty(); }
    bool operator==(const Reference &other) const noexcept {
        return system == other.system && scale_arcsec == other.scale_arcsec && in_orbit == other.in_orbit;
    }
};

// Errors of the reference orbit that are nuisance functions of the sums.
struct OrbitErrors {
    std::array<double, kPartials> sigmas = {}; // above 0: the partial derivative by the element is the next column
    double scale_sigma = 0; // relative error of the plate scale, contained in that of the semi-major axis
    size_t count() const noexcept {
        return static_cast<size_t>(std::count_if(sigmas.begin(), sigmas.end(), [](double sigma) { return sigma > 0; }));
    }
};

// Values of the columns of a sample.
using Row = std::array<double, kPartials>;

// Reads and writes the reduction of a record.
class Reducer {
  public:
    // Status::mismatch unless the columns include the measured separation and, for reading, those of a reduction.
    Reducer(const Columns &columns, const Reference &reference, OrbitErrors errors, const std::string &ledger);
    // Measured separation divided by the factor, minus the geometric separation, px; NaN if the record is not reduced.
    double value(const Record &record) const noexcept;
    // The values of the columns, arcsec per unit of each element.
    Row row(const Record &record) const noexcept;

  private:
    size_t measured_, factor_, geometric_, partials_;
    double scale_arcsec_;
    OrbitErrors errors_;
};

// Stores the reduction in cells of columns of this version; NULL: none.
void store(const Reduction *reduction, Cells &cells) noexcept;

// Removes reduction and number of intervals from a record with these columns.
void clear_reduction(const Columns &columns, Record &record) noexcept;

// Makes a frame that was reduced to an unknown reference unreduced.
void forget_reduction(const Columns &columns, Record &record) noexcept;

// Sets the time on target of an exposure about camera_ns; exposure_s = 0: not known. intervals: pairs (start, end) in s
// from its start. Returns false if a time does not fit in TAI.
bool find_on_target(int64_t camera_ns, double exposure_s, const double *intervals, size_t count, const Clock &clock,
                    OnTarget &on_target);

} // namespace toliman::track
