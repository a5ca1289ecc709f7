// The methods that `experiment` compares: from frames to numbers.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.hpp"

namespace cli {

class Method {
  public:
    Method() = default;
    virtual ~Method() = default;
    Method(const Method &) = delete;
    Method &operator=(const Method &) = delete;

    // Takes the next frames of a series, in order.
    virtual void push(const double *images, size_t count) = 0;
    // One value for every block() frames since the last call, for which the method then begins anew; the frames of a
    // last block that is not full are left out.
    virtual std::vector<double> series() = 0;
    virtual size_t block() const noexcept { return 1; }
};

struct MethodKind {
    const char *name, *what;
    bool knows_scene;        // and what a px is: it can be asked about frames of other scenes
    bool learns_from_series; // from the very frames that it is asked about, so that it has no scatter without them
    bool slow;               // a minute a series and more: see kSlowSeeds and kSlowLeastPx
    // Ready to be pushed to: what is learnt from the scene alone is learnt here, from random numbers of the seed.
    std::unique_ptr<Method> (*make)(const Scene &scene, uint64_t seed);
};

constexpr uint64_t kSlowSeeds = 1;
constexpr double kSlowLeastPx = 1e-4; // below, a method without a prior learns noise

const std::vector<MethodKind> &method_kinds();

// The method of a name; a Failure that lists all names if there is none.
const MethodKind &method_kind(const std::string &name);

} // namespace cli
