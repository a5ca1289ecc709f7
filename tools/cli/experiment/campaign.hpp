// The experiment: every method on every combination of table (scene), amplitude and seed, each with fresh noise.
//
// Noise: every series has frames 0 ... N - 1 of the cadence with a noise seed of its own, seed + 2^32 j, where j counts
// the amplitudes and then the series without signal. `run --seed` therefore has the noise of j = 0. All tables use the
// same seeds and differ in their scenes only. Networks are trained without frames.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/terminal.hpp"
#include "experiment/controls.hpp"
#include "experiment/journal.hpp"
#include "experiment/methods.hpp"
#include "experiment/theory.hpp"
#include "scenes/scene.hpp"

namespace cli {

struct CampaignOptions {
    std::vector<double> amplitudes;
    std::vector<std::string> methods, tables;
    uint64_t seeds = 0, blind = 0;
    Controls controls = Controls::full; // `blind` is the number that they leave
};

// Frames of one scene, given to methods that were made for the same or for another scene.
struct Table {
    std::string name, what;
    bool ladder; // all amplitudes and seeds; otherwise the scene's own amplitude and a few seeds
    std::shared_ptr<const Scene> frames, methods;
    std::vector<double> amplitudes;
    std::vector<uint64_t> blind;   // series without signal of each seed
    std::vector<double> reference; // added to every frame; empty: nothing is added
};

class Campaign {
  public:
    // Throws Failure for a scene without signal or photon noise, or with a number of frames outside the grid's limits.
    Campaign(std::shared_ptr<const Scene> scene, const CampaignOptions &options);

    const Scene &scene() const noexcept { return *scene_; }
    const CampaignOptions &options() const noexcept { return options_; }
    const std::vector<Table> &tables() const noexcept { return tables_; }
    const Theory &theory() const noexcept { return theory_; }
    const FrequencyGrid &grid() const noexcept { return grid_; }
    Json arguments() const; // all that the results depend on

    // Computes every result that the journal does not contain.
    void run(Journal &journal, Progress &progress) const;

  private:
    struct Work; // one series of frames and its rows that are still to be computed
    using Groups = std::map<std::pair<size_t, uint64_t>, std::vector<Work>>;
    using Methods = std::map<std::string, std::unique_ptr<Method>>; // of one scene and seed
    Groups left(const Journal &journal) const;
    static Methods methods_of(const std::vector<Work> &group);
    void run_series(Work &work, const Methods &methods, const std::function<void(double)> &show) const;
    void evaluate(const Work &work, const std::vector<double> &truth, Method &method, Row &row) const;
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
