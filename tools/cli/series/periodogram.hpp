// The periodogram of a whole series, for `run` and `period`, and its saved sums.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

#include "common/terminal.hpp"
#include "series/series.hpp"

namespace cli {

struct FrequencyGrid {
    double f0, df;
    int64_t nf;
};

// Default grid of a mission of so many days with one sample per day.
FrequencyGrid grid_of_days(double days);
// Default grid of a series, by toliman_period_suggest.
FrequencyGrid default_grid(const Series &series);

// Options fixed at creation. Bounds that are not given are chosen from the samples at hand, with margins if more
// samples may follow.
struct SumOptions {
    bool fixed_mean = false, margins = false;
    std::optional<double> value_bound, sigma_floor, sigma_ceiling;
};

// Double-limb accumulators, so that no frequency loses digits.
uint32_t flags_of(const SumOptions &sums);
// Sets sigma_floor and sigma_ceiling; with margins they allow sigmas from 1/8 of the smallest to 4 times the largest.
void set_sigmas(const SumOptions &sums, double least, double largest, toliman_period_options &options);
// Samples without sigma have sigma_floor, which is 1 unless it is given.
void set_unweighted(const SumOptions &sums, toliman_period_options &options);
// The options already have references and value_bound. An error names the options of the command line.
toliman::periodogram make_periodogram(const FrequencyGrid &grid, const toliman_period_options &options);
// Why a sample was refused, with the option that would admit it.
std::string refusal(const toliman::periodogram &periodogram, double y, double sigma, bool from_state);

struct Periodogram {
    toliman::periodogram handle;
    double time_offset;       // reference time of the peak's phase: the first time
    toliman_period_peak peak; // refined by least squares on the samples
    bool at_edge() const noexcept { return (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0; }
};

// Pushes the samples one by one and fits the highest peak; a signal stops it between two samples.
Periodogram find_period(const Series &series, const FrequencyGrid &grid, const SumOptions &sums, Progress &progress);

// Reads a file of `period --save-state`.
toliman::periodogram load_state(const std::string &path);
std::vector<unsigned char> state_bytes(const toliman::periodogram &periodogram);
void save_state(const toliman::periodogram &periodogram, const std::string &path);

toliman_period_info info_of(const toliman::periodogram &periodogram);

// The power at all frequencies, in the given normalisation.
std::vector<double> power_of(const toliman_period *periodogram, int64_t nf,
                             int32_t normalisation = TOLIMAN_PERIOD_POWER_STANDARD);

// Warns of a grid step above 1/(5 T), with T from the sums alone, and of inaccurate powers, each once: `warned` holds
// the flags of toliman_period_sampling that were reported.
void warn_while_following(const toliman::periodogram &periodogram, uint32_t &warned, Progress &progress);
// All warnings, also of a peak at the edge. series: NULL if only the sums are known; then the median time step is
// unknown.
void warn_of_grid(const Periodogram &periodogram, const Series *series, Progress &progress);

} // namespace cli
