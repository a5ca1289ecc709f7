// The period of a state folder, as text and JSON.
#pragma once
#include <cmath>
#include <optional>
#include <string>

#include <toliman/toliman.hpp>

#include "common/json.hpp"
#include "series/coefficients.hpp"

namespace cli {

// Period of the highest peak on the grid, with the coefficients of the nuisance functions there, and, with Fit::made,
// of the least-squares fit to all values, which reads the ledger. Nothing of it if there are too few frames.
enum class Fit { none, made };
class PeriodFacts {
  public:
    PeriodFacts(const toliman::tracker &tracker, Fit fit);
    void add_to(Json &json) const;
    std::string text() const;
    std::string functions_text() const; // a line for each coefficient; "" if the mean alone is fitted

  private:
    int64_t count_;
    double sequential_ = NAN;
    std::string unit_; // of time
    std::optional<toliman_period_peak> peak_, fit_;
    Coefficients fitted_; // empty if the mean alone is fitted
};

} // namespace cli
