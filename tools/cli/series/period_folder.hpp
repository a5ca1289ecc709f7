// The folder of results of period --out, for report: all files or none.
#pragma once
#include <string>

#include "common/output.hpp"
#include "series/period_report.hpp"

namespace cli {

class PeriodFolder {
  public:
    // Opens every file before the computation, so that an unwritable folder fails at once.
    explicit PeriodFolder(const std::string &path);
    // residual: sums of the series without the sinusoid of the report.
    void write(const PeriodReport &report, const Series &series, const toliman::periodogram &residual);

  private:
    void write_series(const PeriodReport &report, const Series &series);
    void write_power(const std::string &name, const toliman::periodogram &periodogram, const FrequencyGrid &grid);
    OutputFolder folder_;
};

// Values of mean and nuisance functions of a series.
std::vector<double> nuisance_values(const Series &series, const std::vector<Coefficient> &coefficients);

// A series without the sinusoid.
Series without(const Sinusoid &sinusoid, const Series &series);

} // namespace cli
