// Estimators of a tracker: a network, a template or the caller's function.
#pragma once
#include <optional>

#include <toliman/track.h>

#include "api/handles.hpp"
#include "track/tracker.hpp"

namespace toliman::api {

// What makes values of images.
struct Source {
    size_t rows = 0, cols = 0; // of the image; 0: any
    double sigma = 0;
    uint64_t digest = 0;
    track::Estimate estimate;
};

// Of the caller's function without the estimate, for which the image's shape must be known.
Source source_of(const toliman_track_options &options, unsigned workers);
// That function on these terms, with these columns for its values.
track::Estimate estimate_of(const toliman_track_options &options, const track::Terms &terms,
                            const track::Columns &columns);

// Keeps the estimator from being trained or destroyed while frames are estimated.
class EstimatorUse {
  public:
    EstimatorUse(const toliman_cae *cae, const toliman_linear *linear) {
        if (cae != nullptr)
            cae_.emplace(cae, "options->cae");
        if (linear != nullptr)
            linear_.emplace(linear, "options->linear");
    }

  private:
    std::optional<Use<const toliman_cae>> cae_;
    std::optional<Use<const toliman_linear>> linear_;
};

} // namespace toliman::api
