// Detection map of a search: the fraction of injected planets that are detected, in cells of period and mass.
#pragma once
#include "common/job_journal.hpp"
#include "series/planet_search.hpp"

namespace cli {

struct MapOptions {
    bool is_wanted = false;
    std::string cells = "20x15"; // periods x masses
    std::string masses;          // "MIN,MAX" in Earths; "" = around those that are detected
    uint32_t injections = 100;   // per cell

    void add_to(CLI::App &command);
};

struct DetectionMap {
    int32_t star = -1;                            // that has the planets, 0 = A; -1: sizes are amplitudes
    std::vector<double> period_edges, size_edges; // units of t; Earth masses, or units of y
    uint32_t injections = 0;                      // per cell
    uint64_t seed = 0;                            // of cell 0; that of cell k is seed + k
    std::vector<uint32_t> detected;               // [sizes][periods]

    size_t periods() const noexcept { return period_edges.size() - 1; }
    size_t sizes() const noexcept { return size_edges.size() - 1; }
    const char *size_name() const noexcept { return star < 0 ? "amplitude" : "mass"; }
    toliman_planet_cell cell(size_t k) const;
    void print() const;
    Json json() const;
};

// The map of the options without its cells. Throws Failure for bad options.
DetectionMap empty_map(const MapOptions &options, const PlanetSearch &search, uint64_t seed);

// The file map.csv: each cell is appended when it and all before it are known, so that a stopped command resumes.
class MapFile {
  public:
    // Throws Failure if the file is another one, or the map of another search.
    MapFile(const std::string &path, const DetectionMap &map, const PlanetSearch &search);
    const std::vector<uint32_t> &detected() const noexcept { return detected_; } // of the first cells
    void add(uint32_t detected);

  private:
    std::string row(uint32_t detected) const; // of the next cell
    void read(const Json &settings);
    void check_settings(const cJSON *found, const Json &settings) const;

    const DetectionMap &map_;
    JournalFile file_;
    std::vector<uint32_t> detected_;
};

// Computes the cells that the file lacks; all without a file (NULL).
void fill(DetectionMap &map, const PlanetSearch &search, MapFile *file, Progress &progress);

} // namespace cli
