// A series of measurements for every step from the frames to the planets: values with their times, exposures, errors,
// unit and the functions that are fitted with their mean.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ingest/time_scale.hpp"
#include "sky/refit.hpp"

namespace toliman::measure {

constexpr size_t kMostFunctions = 32; // without the mean
constexpr int32_t kMostTrend = 8;

// What the values are.
enum class Kind : int32_t {
    value,      // any
    separation, // apparent separations, as they were measured
    reduced,    // separations reduced to the orbit: measured/factor - geometric
    velocity    // radial velocities of a star
};

// A function whose values come with the samples.
struct Column {
    std::string name;
    std::vector<double> values; // [samples]
    double bound = 0;           // largest |value|
    double precision = 0;       // 1/s^2 of the prior of its coefficient, in units of the value; 0: none
    double unit = 1;            // factor from the coefficient to the number that it stands for
};

// Chebyshev polynomials T_1 ... T_order of the time on [start, end].
struct Trend {
    int32_t order = 0;
    double start = 0, end = 0;     // units of t
    std::vector<double> precision; // [order]
};

// How the times were given; none for plain numbers.
struct Dates {
    ingest::TimeFormat format;
    ingest::Scale scale; // of t, Modified Julian Days; never UTC
};

struct Series {
    Kind kind = Kind::value;
    std::string name;                                  // of the file or folder, for messages; may be empty
    std::vector<double> t, y, sigma;                   // sigma: empty if it is not known
    std::vector<int64_t> tai_ns;                       // times in TAI, if they are known better than by t
    std::vector<sky::Exposure> exposures;              // empty: not known
    std::vector<double> position_angle_deg;            // of B from A, on the orbit; empty: not known
    std::vector<double> separation_arcsec;             // of reduced ones: as they were measured
    std::vector<double> factor, geometric_arcsec;      // of reduced ones: their predictions
    std::optional<Dates> dates;                        // of t
    double unit = 0;                                   // arcsec (velocities: m/s) per unit of y; 0: not known
    std::string unit_name;                             // as the source states it, "km/s"; "" if it does not
    double time_unit_days = 1;                         // days per unit of t
    double frame_chi_square = 0;                       // median of the frames; 0: not known
    double parallax_arcsec = 0, star_mass[2] = {0, 0}; // of the system, solar masses; 0: not known
    bool is_refitted = false; // reduced to an orbit that was refitted to samples of these dates
    Trend trend;
    std::vector<Column> columns;
    std::vector<int32_t> instrument;      // of each sample, index of its name; empty: one instrument
    std::vector<std::string> instruments; // names; each has an offset, a column, but the first, and a jitter
    std::string instrument_names;         // separated by commas
    size_t left_out = 0;                  // samples of the source that could not be used

    size_t count() const noexcept { return t.size(); }
    size_t functions() const noexcept { return static_cast<size_t>(trend.order) + columns.size(); }
    std::string function_name(size_t function) const; // "T1" ..., then those of the columns
    double precision(size_t function) const;
    double &precision(size_t function);
    bool has_priors() const noexcept;
    // Values of all functions, [samples][functions()], or of the columns only.
    std::vector<double> function_rows() const;
    std::vector<double> column_rows() const;

    // Sets the trend; both ends 0: from the first to the last time. Status::argument if all times are equal.
    void set_trend(int32_t order, double start, double end);
    // Sets the instruments of the samples, and their offsets. Status::argument for bad numbers.
    void set_instruments(std::vector<std::string> names, std::vector<int32_t> of_samples);
    // Index of the column of the offset of an instrument, of the second or a later one.
    size_t offset_column(size_t which) const;
    // Adds a column. Status::argument for a name that is taken and for bad values.
    void add_column(const std::string &name, std::vector<double> values, double precision);
    // Sets the exposures, whose middles are the times, if they are known: a length of 0 is an instant, which only an
    // observer at the Earth's centre can reduce. Status::argument for a length without dates.
    void set_exposures(double exposure_s);
    // Sets the times to numbers that are no dates, which leaves no trend.
    void set_plain_times(std::vector<double> times);
    // Sets the times to the middles of the exposures.
    void set_times_of_exposures();
    // The values "t", "y", "sigma", "position_angle_deg", "separation_arcsec", "factor", "geometric_arcsec" or
    // "instrument" of each sample, or those of the function of this name. Status::not_found.
    std::vector<double> values(const std::string &name) const;
    // Adds a sample of a series with the same members.
    void add(const Series &from, size_t sample);
};

// The unit of a series of this kind, from the one given; 0: not given. Status::argument.
double known_unit(double unit, Kind kind);

// Status::argument, naming the member and the sample, for numbers that no function takes; for arrays of other lengths.
void check(const Series &series);

// FNV-1a hash of all numbers that a fit takes, with a hash of earlier ones.
uint64_t digest_of(const Series &series, uint64_t hash);

// Status::argument for measured separations, which are to be reduced first.
void check_reduced(const Series &series);

// Times in TAI, ns. Status::argument for plain numbers.
std::vector<int64_t> tai_of(const Series &series);

// Modified Julian Day of TAI; whole days are exact.
double mjd_of(int64_t tai_ns) noexcept;

} // namespace toliman::measure
