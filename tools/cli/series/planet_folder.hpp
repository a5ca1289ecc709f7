// The folder of results of planet --out, for report: all files or none, except the map, which is written as it grows.
#pragma once
#include <string>

#include "common/output.hpp"
#include "series/planet_report.hpp"

namespace cli {

class PlanetFolder {
  public:
    // Opens the files before the computation, so that an unwritable folder fails at once.
    PlanetFolder(const std::string &path, bool with_limits);
    std::string map_path() const { return folder_.file("map.csv"); }
    void write(const PlanetReport &report);

  private:
    void write_series(const PlanetReport &report);
    void write_samples(const PlanetSearch &search, uint32_t index);
    void write_limits(const PlanetReport &report);
    OutputFolder folder_;
};

} // namespace cli
