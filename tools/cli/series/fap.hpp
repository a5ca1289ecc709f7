// False alarm probability (FAP) of a peak by the method of --fap, for white and correlated noise (--noise).
#pragma once
#include "series/nuisance.hpp"
#include "series/periodogram.hpp"
#include "series/series.hpp"

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

inline constexpr char kBootstrap[] = "bootstrap";

// The highest peaks of resampled series, as log10(1 - power) in ascending order.
struct Resampled {
    std::vector<double> peaks;
    // log10 of the FAP of a peak with this log10(1 - power); a bound if no resampling has a peak this high.
    double log10(double log10_residual) const;
    bool is_bound(double log10_residual) const { return above(log10_residual) == 0; }
    // "-2.30 (bootstrap)", "< -3.00 (bootstrap, none of 999)".
    std::string text(double log10_residual) const;

  private:
    std::ptrdiff_t above(double log10_residual) const;
};

class Fap {
  public:
    // series: the samples that were pushed, needed by the bootstrap only; NULL if they are not known.
    Fap(const FapOptions &options, const toliman::periodogram &periodogram, const toliman_measure *series,
        Progress &progress);
    // log10(1 - power) for which the FAP of the highest peak is computed: that of the fit, but for the bootstrap that
    // of the highest grid frequency, since its resamplings are not fitted either.
    double residual_of(const toliman_period_peak &fitted) const;
    // log10 of the FAP of a peak with this log10(1 - power).
    double log10(double log10_residual) const;
    // The same as text, "< -3.00" if no resampling has a peak this high, and with the method.
    std::string text(double log10_residual) const;
    std::string with_method(double log10_residual) const;
    const std::string &method() const noexcept { return method_; }

  private:
    const toliman::periodogram &periodogram_;
    std::string method_;
    Resampled resampled_; // of the bootstrap
};

struct NoiseOptions {
    std::string model = "white";
};
void add_noise(CLI::App &command, NoiseOptions &options);

// Correlated noise of a series: whiteness, and the highest peak for noise of the fitted correlation.
class Noise {
  public:
    // Searches the series with the model of the options. For white noise a short series is tested only, and nothing is
    // known if it cannot be: on the part of the grid that takes about 2 s, if this contains `frequency`, that of the
    // peak. With ar1 and --fap bootstrap, blocks of residuals are resampled.
    Noise(const NoiseOptions &options, const FapOptions &fap, const toliman_measure *series, FrequencyGrid grid,
          double frequency, Progress &progress);
    // Warns if white noise was assumed and the series is not white.
    void warn(Progress &progress) const;
    void print() const;
    bool known() const noexcept { return found_.has_value(); }
    double log10_p_white() const noexcept { return found_->log10_p_white; } // if known
    static constexpr double kNotWhite = -3;                                 // of log10_p_white
    Json json() const;
    bool is_ar1() const;
    const toliman_period_noise &found() const { return *found_; } // with ar1
    // Replaces coefficients by those of ar1.
    void set(std::vector<Coefficient> &coefficients) const;

  private:
    void search(const toliman_measure *series, const FrequencyGrid &grid, Progress &progress);
    std::string model_;
    std::optional<toliman_period_noise> found_;
    std::vector<double> coefficients_, errors_; // of the functions, without the mean
    std::optional<Resampled> resampled_;        // of the bootstrap
};

} // namespace cli
