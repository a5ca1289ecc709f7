// The work of planet: input, search, map and output, for one process or for one of many that share a map.
#pragma once
#include "series/planet_report.hpp"
#include "series/series_options.hpp"

namespace cli {

struct PlanetJobOptions : SeriesOptions {
    std::string unit, out;
    PlanetOptions planets;
    MapOptions map;
    bool limits = false, as_json = false;
    std::vector<std::string> of_series; // options that were given and do not suit a state folder

    // The options keep a reference to this object.
    void add_to(CLI::App &command);
    // After parsing: finds of_series.
    void see(const CLI::App &command);
};

class PlanetJob {
  public:
    // Reads the series, searches it, and makes an empty map if one is wanted. writes: whether this process has the
    // folder of --out and prints.
    PlanetJob(PlanetJobOptions &options, bool writes, Progress &progress);
    PlanetJob(const PlanetJob &) = delete;
    PlanetJob &operator=(const PlanetJob &) = delete;

    const PlanetSearch &search() const noexcept { return *search_; }
    DetectionMap *map() noexcept { return map_ ? &*map_ : nullptr; }
    MapFile *map_file() noexcept { return file_ ? &*file_ : nullptr; } // NULL without --out
    // Writes the folder of --out.
    void write();
    // Likewise, and prints, with the map. Then fails with kExitRejected if a candidate with sufficient odds is
    // not a planet.
    void finish(Progress &progress);

  private:
    struct Input {
        toliman::measurements series;
        ValueUnit unit;
        std::optional<ReductionNote> reduced;
    };
    PlanetReport report() const;
    Input input_of_state(Progress &progress) const;
    Input input_of_series(Progress &progress) const;

    PlanetJobOptions &options_;
    std::optional<OutputFolder> folder_;
    std::optional<Input> input_;
    std::optional<PlanetSearch> search_;
    std::optional<DetectionMap> map_;
    std::optional<MapFile> file_;
};

} // namespace cli
