// Correlated noise of a series, by --noise: whiteness, and the highest peak for noise of the fitted correlation.
#pragma once
#include <optional>
#include <string>

#include <toliman/toliman.hpp>

#include "common/json.hpp"
#include "common/terminal.hpp"
#include "series/coefficients.hpp"
#include "series/fap.hpp"
#include "series/periodogram.hpp"

namespace CLI {
class App;
}

namespace cli {

struct NoiseOptions {
    std::string model = "white";
};
void add_noise(CLI::App &command, NoiseOptions &options);

class Noise {
  public:
    // Searches the series with the model of the options. For white noise a short series is tested only, and nothing is
    // known if it cannot be: on the part of the grid that takes about 2 s, if this contains `frequency`, that of the
    // peak. With ar1 and --fap bootstrap, blocks of residuals are resampled.
    Noise(const NoiseOptions &options, const FapOptions &fap, const Series &series, FrequencyGrid grid,
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
