// Estimators of a tracker: those of lib/estimate, or a user-supplied function.
#pragma once
#include <optional>
#include <utility>

#include <toliman/track.h>

#include "api/handles.hpp"
#include "api/sky_handle.hpp"
#include "estimate/estimators.hpp"

namespace toliman::api {

// Returns the estimator chosen in options. For a user-supplied function the member `estimate` stays empty until
// estimate_of(), which needs the shape of the image; that of a fit or bank is for time_offset_ns = 0.
track::Source source_of(const toliman_track_options &options, unsigned workers);
// The fit or bank of these options, for time_offset_ns.
track::Source moving_source(const toliman_track_options &options, int64_t time_offset_ns);
// Status::mismatch unless the bank was made for this fit. name: of the bank, in messages.
void check_fit(const toliman_bank &bank, const toliman_fit &fit, const char *name);
// Called by toliman_fit::source and toliman_bank::source.
inline track::Source fit_source(const toliman_fit &handle, int64_t time_offset_ns) {
    return estimate::of_fit(handle.fit, handle.works, time_offset_ns);
}
inline track::Source bank_source(const toliman_bank &handle, const toliman_fit &fit, int64_t time_offset_ns) {
    check_fit(handle, fit, "options->estimator.bank");
    return estimate::of_bank(handle.bank, handle.works, fit.fit, fit.works, time_offset_ns);
}
// Wraps the user-supplied function for these terms and columns.
track::Estimate estimate_of(const toliman_track_options &options, const track::Terms &terms,
                            const track::Columns &columns);

// Holds a shared use of the estimator, so that it cannot be trained or destroyed while frames are estimated.
class EstimatorUse {
  public:
    EstimatorUse(const toliman_track_estimator &given, const toliman_sky *sky)
        : cae_(use_of(given.cae, "options->estimator.cae")), linear_(use_of(given.linear, "options->estimator.linear")),
          fit_(use_of(given.fit, "options->estimator.fit")), bank_(use_of(given.bank, "options->estimator.bank")),
          sky_(use_of(sky, "options->reduction.sky")) {}

  private:
    template <class T> static std::optional<Use<const T>> use_of(const T *handle, const char *name) {
        return handle != nullptr ? std::optional<Use<const T>>(std::in_place, handle, name) : std::nullopt;
    }

    std::optional<Use<const toliman_cae>> cae_;
    std::optional<Use<const toliman_linear>> linear_;
    std::optional<Use<const toliman_fit>> fit_;
    std::optional<Use<const toliman_bank>> bank_;
    std::optional<Use<const toliman_sky>> sky_;
};

} // namespace toliman::api
