// The methods that `experiment` compares: from frames to one number a frame.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "scene.hpp"

namespace cli {

class Method {
  public:
    Method() = default;
    virtual ~Method() = default;
    Method(const Method &) = delete;
    Method &operator=(const Method &) = delete;

    // Takes the next frames of a series, in order.
    virtual void push(const double *images, size_t count) = 0;
    // One value for each frame since the last call, for which the method then begins anew.
    virtual std::vector<double> series() = 0;
};

struct MethodKind {
    const char *name, *what;
    bool learns_from_series; // from the very frames that it is asked about, so that it has no scatter without them
    // Ready to be pushed to: what is learnt from the scene alone is learnt here, from random numbers of the seed.
    std::unique_ptr<Method> (*make)(const Scene &scene, uint64_t seed);
};

const std::vector<MethodKind> &method_kinds();

// The method of a name; a Failure that lists all names if there is none.
const MethodKind &method_kind(const std::string &name);

} // namespace cli
