// The period of a state folder and the goodness of fit of its frames, as text and JSON.
#pragma once
#include "series/goodness.hpp"
#include "series/nuisance.hpp"

namespace cli {

constexpr uint32_t kLeastFrames = 20; // for which a change is stated
constexpr double kLeastYears = 0.05;  // and a trend per year

// Period of the highest peak on the grid, with the coefficients of the nuisance functions there; with Fit::made, of the
// least-squares fit to all values, which reads the ledger; with Fit::tested also whether the values are white. Nothing
// of it if there are too few frames.
enum class Fit { none, made, tested };
class PeriodFacts {
  public:
    PeriodFacts(const toliman::tracker &tracker, Fit fit, Progress &progress);
    void add_to(Json &json) const;
    std::string text() const;
    const std::optional<toliman_period_peak> &fit() const noexcept { return fit_; }
    const Coefficients &fitted() const noexcept { return fitted_; } // empty if the mean alone is fitted
    std::string aliases_text() const;                               // a line for each alias of a significant period
    std::string functions_text() const; // a line for each coefficient; "" if the mean alone is fitted

  private:
    int64_t count_;
    double sequential_ = NAN;
    std::string unit_; // of time
    std::optional<toliman_period_peak> peak_, fit_;
    Coefficients fitted_;
    std::optional<Aliases> aliases_; // unknown with Fit::none
    std::optional<double> log10_p_white_;
};

toliman_track_goodness goodness_of(const toliman::tracker &tracker);
// Lines of `status`, each indented.
std::string goodness_text(const toliman_track_goodness &goodness);
Json goodness_json(const toliman_track_goodness &goodness);
// What is wrong with the model of the frames, in a sentence; "" if nothing is.
std::string model_complaint(const toliman_track_goodness &goodness);

} // namespace cli
