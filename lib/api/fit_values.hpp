// Predictions and results of a fit, from and to the caller.
#pragma once
#include <optional>

#include <toliman/fit.h>

#include "api/struct_array.hpp"
#include "fit/fit.hpp"

namespace toliman::api {

// NULL: time 0, no shift.
fit::Prediction prediction_of(const toliman_fit_prediction *given);
// One whose struct_size is checked. `name` is that of the argument in messages.
fit::Prediction prediction_of(const toliman_fit_prediction &given, const char *name);
// That of a frame of this window.
fit::Prediction in_window(fit::Prediction prediction, const std::optional<DetectorWindow> &window);
// Status::unsupported, naming the spread, for the prediction of a sum of frames, which banks do not take.
fit::Prediction of_one_frame(const fit::Prediction &prediction, const char *name);
// Those of several frames. NULL: time 0, no shift.
class Predictions {
  public:
    explicit Predictions(const toliman_fit_prediction *first) {
        if (first != nullptr)
            given_.emplace(first, "predictions");
    }
    fit::Prediction at(size_t i) const {
        return given_ ? prediction_of(given_->get(i), "predictions") : fit::Prediction();
    }

  private:
    std::optional<StructArray<const toliman_fit_prediction>> given_;
};
// The numbers of a frame that was not fitted are NaN. n: number of parameters.
toliman_fit_result public_result(const fit::Result &result, size_t n);

} // namespace toliman::api
