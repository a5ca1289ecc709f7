// Definition of toliman_sky.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <toliman/sky.h>

#include "api/handle.hpp"
#include "sky/columns.hpp"
#include "sky/prediction.hpp"
#include "track/reduction.hpp"

namespace toliman::api {

// The reduction of a tracker's frames.
struct SkySource {
    std::string system; // JSON text; that of `folder` if it has the same numbers
    bool in_orbit = false;
    track::Reduce reduce;
    std::function<std::vector<sky::Column>(double scale_sigma)> error_columns; // of the orbit
};

// Precision of the prior of the error of an element, whose column is in arcsec, in values of this unit.
inline double prior_precision(double sigma, double unit_arcsec) noexcept {
    const double own = sigma / unit_arcsec;
    return 1 / (own * own);
}

// The system, and the means over the time on target of a frame. `sky` must outlive the result. folder: the system of a
// folder, or "". Status::argument if the predictor leaves out effects.
SkySource sky_source(const toliman_sky &sky, const std::string &folder);

} // namespace toliman::api

struct toliman_sky : toliman::api::Handle<toliman_sky> {
    static constexpr char kType[] = "toliman_sky";
    std::unique_ptr<const toliman::sky::Predictor> predictor;
    // For trackers, sky_source(): a pointer, so that programs without a system are linked without it.
    toliman::api::SkySource (*source)(const toliman_sky &sky, const std::string &folder);
};
