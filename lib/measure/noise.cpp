#include "measure/noise.hpp"

namespace toliman::measure {

NoiseSeries::NoiseSeries(double f0, double df, int64_t nf, const Series &series)
    : series_(series), noise_grid_{f0, df, static_cast<size_t>(nf)}, functions_(series.function_rows()) {
    grid_.f0 = f0;
    grid_.df = df;
    grid_.nf = nf;
    grid_.sigma_ceiling = grid_.sigma_floor;
    grid_.check();
    check_reduced(series);
    for (size_t f = 0; f < series.functions(); f++)
        precision_.push_back(series.precision(f));
}

period::NoiseModel NoiseSeries::model() const {
    const double *const sigma = series_.sigma.empty() ? nullptr : series_.sigma.data();
    return {{{series_.t.data(), series_.y.data(), sigma, series_.count()},
             functions_.data(),
             series_.functions(),
             precision_.data()},
            grid_.last()};
}

} // namespace toliman::measure
