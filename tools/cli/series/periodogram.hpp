// The periodogram of a whole series, for `run` and `period`, and its saved sums.
#pragma once
#include "series/nuisance.hpp"
#include "series/series.hpp"

namespace cli {

struct FrequencyGrid {
    double f0, df;
    int64_t nf;
};

// f0 + k df.
std::vector<double> frequencies_of(const FrequencyGrid &grid);
// Default grid of a mission of so many days with one sample per day.
FrequencyGrid grid_of_days(double days);
// Default grid of the times of a series, by toliman_period_suggest.
FrequencyGrid default_grid(const std::string &name, const std::vector<double> &times);

// Options fixed at creation. Bounds that are not given are chosen from the samples at hand, with margins if more
// samples may follow.
struct SumOptions {
    bool fixed_mean = false, margins = false;
    std::optional<double> value_bound, sigma_floor, sigma_ceiling;
};

// Offsets and bounds for the samples of a series, by toliman_period_suggest, with double-limb accumulators, so that no
// frequency loses digits, and its nuisance functions. Samples without sigma have sigma_floor, 1 unless it is given.
toliman_period_options options_for(const toliman_measure *series, const SumOptions &sums);
// The same for n samples, without functions.
toliman_period_options options_for(const double *t, const double *y, const double *sigma, size_t n,
                                   const SumOptions &sums);
// An error names the options of the command line.
toliman::periodogram make_periodogram(const FrequencyGrid &grid, const toliman_period_options &options);
// Why a sample was refused, with the option that would admit it.
std::string refusal(const toliman::periodogram &periodogram, double t, double y, double sigma, bool from_state);

struct Periodogram {
    toliman::periodogram handle;
    double time_offset;       // reference time of the peak's phase: the first time
    toliman_period_peak peak; // refined by least squares on the samples
    bool at_edge() const noexcept { return (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0; }
};

// Pushes the samples of a series one by one; a signal stops it between two samples.
toliman::periodogram sums_of(const toliman_measure *series, const FrequencyGrid &grid,
                             const toliman_period_options &options, Progress &progress);
// Pushes the samples and fits the highest peak.
Periodogram find_period(const toliman_measure *series, const FrequencyGrid &grid, const SumOptions &sums,
                        Progress &progress);

// The peak from the sums alone, without samples to refine it. The model is that of the nearest frequency of the grid.
Periodogram from_sums(toliman::periodogram &&handle);
std::vector<toliman_period_peak> peaks_of(const Periodogram &periodogram, size_t most);
int64_t nearest_index(const toliman_period_info &info, double frequency);

// Reads a file of `period --save-state`.
toliman::periodogram load_state(const std::string &path);
std::vector<unsigned char> state_bytes(const toliman::periodogram &periodogram);
void save_state(const toliman::periodogram &periodogram, const std::string &path);

toliman_period_info info_of(const toliman::periodogram &periodogram);

// The power at all frequencies, in the given normalisation.
std::vector<double> power_of(const toliman_period *periodogram, int64_t nf,
                             int32_t normalisation = TOLIMAN_PERIOD_POWER_STANDARD);

// Warns of a grid step above 1/(5 T), of inaccurate powers, of a peak at the edge and, if the series is known, of
// frequencies that the times do not resolve, or that the default grid omits. series: NULL if only the sums are known.
// peak_flags: of the highest peak, 0 for none. warned: flags that were reported and are not reported again.
void warn_of_grid(const toliman::periodogram &periodogram, const toliman_measure *series, bool is_default,
                  uint32_t peak_flags, uint32_t &warned, Progress &progress);

} // namespace cli
