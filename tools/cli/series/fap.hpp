// False alarm probability (FAP) of a peak by the method of --fap.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

#include "common/terminal.hpp"
#include "series/series.hpp"

namespace CLI {
class App;
}

namespace cli {

constexpr double kSignificant = -2; // log10 FAP up to which a peak counts as a period that was found

// The power that the highest peak of noise exceeds with a probability of 1e-3 (Baluev's FAP); NaN for too few samples.
double power_at_fap_1e_3(const toliman_period *period);

struct FapOptions {
    std::string method = "baluev";
    size_t resamplings = 1000;
    uint64_t seed = 0;
};
void add_fap(CLI::App &command, FapOptions &options);

class Fap {
  public:
    // series: the samples that were pushed, needed by the bootstrap only; NULL if they are not known.
    Fap(const FapOptions &options, const toliman::periodogram &periodogram, const Series *series, Progress &progress);
    // log10(1 - power) for which the FAP of the highest peak is computed: that of the fit, but for the bootstrap that
    // of the highest grid frequency, since its resamplings are not fitted either.
    double residual_of(const toliman_period_peak &fitted) const;
    // log10 of the FAP of a peak with this log10(1 - power).
    double log10(double log10_residual) const;
    // The same as text, "< -3.00" if no resampling has a peak this high; and the method as text.
    std::string text(double log10_residual) const;
    std::string how(double log10_residual) const;
    const std::string &method() const noexcept { return method_; }

  private:
    std::ptrdiff_t above(double log10_residual) const;
    bool is_bound(double log10_residual) const;
    const toliman::periodogram &periodogram_;
    std::string method_;
    std::vector<double> resampled_; // log10(1 - power) of each resampling's highest peak, ascending
};

} // namespace cli
