// Estimators of a tracker: a network, a template or a user-supplied function.
#pragma once
#include <optional>

#include <toliman/track.h>

#include "api/handles.hpp"
#include "track/tracker.hpp"

namespace toliman::api {

// An estimator and its properties.
struct Source {
    size_t rows = 0, cols = 0; // of the input image; 0: any
    double sigma = 0;          // standard deviation of a value; 0: unknown
    uint64_t digest = 0;       // identity of the estimator
    track::Estimate estimate;
};

// Returns the estimator chosen in options. For a user-supplied function the member `estimate` stays empty until
// estimate_of(), which needs the shape of the image.
Source source_of(const toliman_track_options &options, unsigned workers);
// Wraps the user-supplied function for these terms and columns.
track::Estimate estimate_of(const toliman_track_options &options, const track::Terms &terms,
                            const track::Columns &columns);

// Holds a shared use of the estimator, so that it cannot be trained or destroyed while frames are estimated.
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
