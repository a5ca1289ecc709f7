// Results of period as text, JSON and files.
#pragma once
#include "series/fap.hpp"
#include "series/goodness.hpp"
#include "series/nuisance.hpp"
#include "series/periodogram.hpp"
#include "series/reduction.hpp"

namespace cli {

// amplitude sin(2 pi frequency (t - time_offset) + phase)
struct Sinusoid {
    double amplitude, frequency, phase, time_offset;
};

struct PeriodReport {
    const Periodogram &periodogram;
    FrequencyGrid grid;
    int64_t samples;
    std::vector<toliman_period_peak> peaks; // that of the report, then the others, the highest first
    const Fap &fap;
    std::string time_scale;             // of Modified Julian Days; empty for plain numbers
    const ReductionNote *reduced;       // NULL if the samples are not reduced
    const Noise *noise;                 // NULL from sums alone
    std::optional<Coefficients> fitted; // of nuisance functions; empty if the mean alone is fitted
    Aliases aliases;                    // of the peak
    Instruments instruments;            // none for a single one

    double shortest() const { return 1 / (grid.f0 + grid.df * static_cast<double>(grid.nf - 1)); }
    double longest() const { return 1 / grid.f0; } // infinite if the grid begins at 0
    // The sinusoid at the peak; with --noise ar1 that for such noise, as are offset and coefficients.
    Sinusoid sinusoid() const;
    double offset() const;
    void print() const;
    Json json() const;
};

// The files of period --out, all or none. residual: sums of the series without the sinusoid of the report.
inline const std::vector<const char *> kPeriodFiles = {"result.json", "series.csv", "periodogram.csv",
                                                       "residual_periodogram.csv"};
void write(OutputFolder &folder, const PeriodReport &report, const toliman_measure *series,
           const toliman::periodogram &residual);

// Values of mean and nuisance functions of a series.
std::vector<double> nuisance_values(const toliman_measure *series, const std::vector<Coefficient> &coefficients);

// A series without the sinusoid.
toliman::measurements without(const Sinusoid &sinusoid, const toliman_measure *series);

} // namespace cli
