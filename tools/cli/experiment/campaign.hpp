// The experiment itself: tables of scenes, amplitudes, seeds and methods, each cell tried on fresh noise.
//
// Noise. Every series has frames 0 ... N - 1 of the cadence, under a noise seed that nothing else uses: seed + 2^32 j,
// where j counts the amplitudes and then the series without signal. So `run --seed` has the noise of j = 0. Tables have
// the same seeds and differ by their scenes alone; networks are trained on no frame at all.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/terminal.hpp"
#include "experiment/journal.hpp"
#include "experiment/methods.hpp"
#include "experiment/theory.hpp"
#include "scenes/scene.hpp"

namespace cli {

struct CampaignOptions {
    std::vector<double> amplitudes;
    std::vector<std::string> methods, tables;
    uint64_t seeds = 0, blind = 0;
};

// Frames of one scene, before methods that were made for it or for another.
struct Table {
    std::string name, what;
    bool ladder; // over all amplitudes and seeds; else the scene's own amplitude and a few seeds
    std::shared_ptr<const Scene> frames, methods;
    std::vector<double> amplitudes;
    std::vector<uint64_t> blind;   // series without signal of each seed
    std::vector<double> reference; // added to every frame; empty for nothing
};

class Campaign {
  public:
    // A Failure for a scene that has no signal, no photon noise or a number of frames that no periodogram takes.
    Campaign(std::shared_ptr<const Scene> scene, const CampaignOptions &options);

    const Scene &scene() const noexcept { return *scene_; }
    const CampaignOptions &options() const noexcept { return options_; }
    const std::vector<Table> &tables() const noexcept { return tables_; }
    const Theory &theory() const noexcept { return theory_; }
    const FrequencyGrid &grid() const noexcept { return grid_; }
    JsonTree arguments() const; // what the results depend on

    // Tries whatever the journal does not hold.
    void run(Journal &journal, Progress &progress) const;

    // Rows of a method in a table: with an amplitude one a seed, with 0 all series without signal.
    std::vector<Row> rows(const Journal &journal, const Table &table, const std::string &method,
                          double amplitude_px) const;

  private:
    struct Cell; // one series of frames
    struct Work; // a cell and the rows that it lacks
    class Workshop;
    std::vector<Cell> cells(const Table &table, uint64_t seed) const;
    static bool fits(const MethodKind &method, const Table &table, const Row &row);
    std::vector<Work> left(const Journal &journal) const;
    void try_out(Work &work, Workshop &workshop, const std::function<void(double)> &show) const;
    void make_tables();
    Table &add_table(const std::string &name, const std::string &what, std::shared_ptr<const Scene> frames,
                     std::shared_ptr<const Scene> methods);
    void add_mismatch(const std::string &name, const std::string &what, const std::string &json);

    std::shared_ptr<const Scene> scene_;
    CampaignOptions options_;
    Cadence cadence_;
    FrequencyGrid grid_;
    std::vector<double> shape_; // of the signal, amplitude 1
    Theory theory_;
    std::vector<double> amplitudes_; // of all tables
    std::vector<Table> tables_;
};

} // namespace cli
