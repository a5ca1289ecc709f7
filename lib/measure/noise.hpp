// A series and a grid, as the search in correlated noise takes them.
#pragma once
#include <vector>

#include "measure/series.hpp"
#include "period/noise/noise_search.hpp"
#include "period/stream/stream.hpp"

namespace toliman::measure {

class NoiseSeries {
  public:
    // The series must outlive the object. Status::argument for a bad grid, and for measured separations.
    NoiseSeries(double f0, double df, int64_t nf, const Series &series);

    const period::Grid &grid() const noexcept { return grid_; }
    const period::NoiseGrid &noise_grid() const noexcept { return noise_grid_; }
    const Series &series() const noexcept { return series_; }
    period::NoiseModel model() const;

  private:
    const Series &series_;
    period::Grid grid_;
    period::NoiseGrid noise_grid_;
    std::vector<double> functions_, precision_;
};

} // namespace toliman::measure
