// Results of planet as text, JSON and files.
#pragma once
#include "series/detection_map.hpp"
#include "series/planet_search.hpp"
#include "series/reduction.hpp"

namespace cli {

struct PlanetReport {
    const PlanetSearch &search;
    const toliman_measure *series;
    std::optional<ReductionNote> reduced;     // empty if the samples are not reduced
    std::vector<toliman_planet_limit> limits; // empty without --limits
    std::optional<DetectionMap> map;          // empty without --map

    void warn(Progress &progress) const;
    // Fails with kExitRejected if a candidate is not a planet although its odds reach the threshold.
    void refuse() const;
    void print() const;
    Json json() const;

  private:
    std::string planet_text(size_t index) const;
    std::string candidate_text() const;
    std::string fit_text() const;
    std::string outlier_text() const;
    std::string mass_text(const toliman_planet_candidate &planet) const;
    std::string axis_text() const;
    std::string limits_text() const;
    std::string amplitude_text(double value) const; // with its unit
    std::optional<double> uas(double value) const;  // nothing if it is not known
    std::vector<double> in_uas(const double (&points)[3]) const;
    Json planet_json(size_t index) const;
    Json limit_json(const toliman_planet_limit &limit) const;
};

// The files of planet --out: all or none, except the map, which is written as it grows.
std::vector<const char *> files_of(bool with_limits);
void write(OutputFolder &folder, const PlanetReport &report);

} // namespace cli
