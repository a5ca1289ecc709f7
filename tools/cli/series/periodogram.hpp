// A whole periodogram of a series at once: what `run` and `period` share.
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

// Of a sample a day.
FrequencyGrid grid_of_days(double days);
// That of toliman_period_suggest.
FrequencyGrid default_grid(const Series &series);

// What the sums are made for, fixed for their life. Bounds that are not given fit the samples at hand, with margins
// where more are to come.
struct SumOptions {
    bool fixed_mean = false, margins = false;
    std::optional<double> value_bound, sigma_floor, sigma_ceiling;
};

// Sums are wide, so that no frequency loses digits.
uint32_t flags_of(const SumOptions &sums);
// Sigmas from 1/8 of the least to 4 times the largest one may come then. Sets sigma_floor and sigma_ceiling.
void set_sigmas(const SumOptions &sums, double least, double largest, toliman_period_options &options);
// Samples without sigma have sigma_floor, 1 unless it is given.
void set_unweighted(const SumOptions &sums, toliman_period_options &options);
// References and value_bound stand in the options already. An error names the options of the command line.
toliman::periodogram make_periodogram(const FrequencyGrid &grid, const toliman_period_options &options);
// Why a sample was refused, with the option that would have let it in.
std::string refusal(const toliman::periodogram &periodogram, double y, double sigma, bool from_state);

struct Periodogram {
    toliman::periodogram handle;
    double time_offset;       // where the peak's phase counts from: the first time
    toliman_period_peak peak; // refined against the samples
    bool at_edge() const noexcept { return (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0; }
};

// Pushes every sample one by one and fits the highest peak; a signal stops it between two samples.
Periodogram find_period(const Series &series, const FrequencyGrid &grid, const SumOptions &sums, Progress &progress);

// A periodogram file of `period --save-state`.
toliman::periodogram load_state(const std::string &path);
std::vector<unsigned char> state_bytes(const toliman::periodogram &periodogram);
void save_state(const toliman::periodogram &periodogram, const std::string &path);

constexpr const char kEdgeRemark[] =
    "the peak stands at the edge of the grid and the period may lie beyond: --f0, --df and --nf give another grid";

toliman_period_info info_of(const toliman::periodogram &periodogram);

// In TOLIMAN_PERIOD_POWER_STANDARD or another.
std::vector<double> power_of(const toliman::periodogram &periodogram, int64_t nf,
                             int32_t normalisation = TOLIMAN_PERIOD_POWER_STANDARD);

} // namespace cli
