// False alarm probability of a peak by the method that --fap names.
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

constexpr double kSignificant = -2; // log10 FAP from which on a peak is called a period that was found

struct FapOptions {
    std::string method = "baluev";
    size_t resamplings = 1000;
    uint64_t seed = 0;
};
void add_fap(CLI::App &command, FapOptions &options);

class Fap {
  public:
    // series: the samples pushed, which only the bootstrap needs; NULL where there are none.
    Fap(const FapOptions &options, const toliman::periodogram &periodogram, const Series *series, Progress &progress);
    // log10(1 - power) by which the highest peak is judged: as it was fitted, but by bootstrap as it stands on the
    // grid, since its resamplings are not fitted either.
    double judged(const toliman_period_peak &fitted) const;
    // log10 of it, for a peak of that log10(1 - power).
    double log10(double log10_residual) const;
    // The same for people, "< -3.00" where no resampling peaks as high, and how it was judged.
    std::string text(double log10_residual) const;
    std::string how(double log10_residual) const;
    const std::string &method() const noexcept { return method_; }

  private:
    std::ptrdiff_t above(double log10_residual) const;
    bool is_bound(double log10_residual) const;
    const toliman::periodogram &periodogram_;
    std::string method_;
    std::vector<double> resampled_; // highest peaks of noise, the strongest first
};

} // namespace cli
