// Predictions and results of a fit, from and to the caller.
#pragma once
#include <toliman/fit.h>

#include "fit/fit.hpp"

namespace toliman::api {

// NULL: time 0, no shift.
fit::Prediction prediction_of(const toliman_fit_prediction *given);
// One whose struct_size is checked. `name` is that of the argument in messages.
fit::Prediction prediction_of(const toliman_fit_prediction &given, const char *name);
// The numbers of a frame that was not fitted are NaN. n: number of parameters.
toliman_fit_result public_result(const fit::Result &result, size_t n);

} // namespace toliman::api
