// The methods that `experiment` compares: each turns frames into values.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.hpp"

namespace cli {

class Method {
  public:
    virtual ~Method() = default;
    // Adds the next frames of a series, in order, with their times in the scene.
    virtual void push(const double *images, const double *times_days, size_t count) = 0;
    // Returns one value for every block() frames since the last call and forgets these frames; those of an incomplete
    // last block are left out. NaN: the frame gave no value.
    virtual std::vector<double> series() = 0;
    virtual size_t block() const noexcept { return 1; }
};

// Frames that several methods of one scene and seed use, so that they are stored and their products computed once.
struct SharedFrames {
    std::shared_ptr<class ComponentFrames> whitened;
};

struct MethodKind {
    const char *name, *what;
    bool knows_scene;        // values are in px of a known scene, so that frames of other scenes make sense
    bool learns_from_series; // is fitted to the series it evaluates, so that it has no response to expected images
    bool slow;               // a minute or more per series: see kSlowSeeds and kSlowLeastPx
    // Creates a method that is ready for frames, trained on the scene if it is to be, with random numbers of the seed.
    // Methods with the same `shared` get the same frames; their calls may run on several threads.
    std::unique_ptr<Method> (*make)(const Scene &scene, uint64_t seed, SharedFrames &shared);
    bool on_request = false; // not among the default methods
};

constexpr uint64_t kSlowSeeds = 1;
constexpr double kSlowLeastPx = 1e-4; // at smaller amplitudes a method without a prior learns noise

const std::vector<MethodKind> &method_kinds();

// The method of this name; throws Failure with a list of all names if there is none.
const MethodKind &method_kind(const std::string &name);

} // namespace cli
