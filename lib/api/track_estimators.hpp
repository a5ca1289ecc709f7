// Estimators of a tracker: a network, a template, a fit of the forward model, with or without a bank of networks, or a
// user-supplied function.
#pragma once
#include <optional>
#include <string>
#include <utility>

#include <toliman/track.h>

#include "api/handles.hpp"
#include "api/sky_handle.hpp"
#include "track/tracker.hpp"

namespace toliman::api {

// An estimator and its properties.
struct Source {
    size_t rows = 0, cols = 0; // of the input image; 0: any
    double sigma = 0;          // standard deviation of a value; 0: unknown
    uint64_t digest = 0;       // identity of the estimator
    std::string values;        // names of its further values (base/words.hpp)
    track::Estimate estimate;
    double scale_arcsec = 0; // of a pixel; 0: unknown
    track::ModelVerdict model = {};
};

// What is known of the model of a fit: the worst calibration of its windows.
track::ModelVerdict model_verdict_of(const fit::Windows &fit) noexcept;

// Returns the estimator chosen in options. For a user-supplied function the member `estimate` stays empty until
// estimate_of(), which needs the shape of the image; that of a fit or bank is for time_offset_ns = 0.
Source source_of(const toliman_track_options &options, unsigned workers);
// The fit of each frame at its time in the scene, whose time 0 is TAI time_offset_ns. Called by toliman_fit::source.
Source fit_source(const toliman_fit &handle, int64_t time_offset_ns);
// The same with the networks of a bank. Called by toliman_bank::source. Status::mismatch for the bank of another fit,
// Status::argument for networks that are not trained.
Source bank_source(const toliman_bank &handle, const toliman_fit &fit, int64_t time_offset_ns);
// Status::mismatch unless the bank was made for this fit. name: of the bank, in messages.
void check_fit(const toliman_bank &bank, const toliman_fit &fit, const char *name);
// The fit or bank of these options, for time_offset_ns.
Source moving_source(const toliman_track_options &options, int64_t time_offset_ns);
// Wraps the user-supplied function for these terms and columns.
track::Estimate estimate_of(const toliman_track_options &options, const track::Terms &terms,
                            const track::Columns &columns);

// Holds a shared use of the estimator, so that it cannot be trained or destroyed while frames are estimated.
class EstimatorUse {
  public:
    EstimatorUse(const toliman_cae *cae, const toliman_linear *linear, const toliman_fit *fit, const toliman_bank *bank,
                 const toliman_sky *sky)
        : cae_(use_of(cae, "options->estimator.cae")), linear_(use_of(linear, "options->estimator.linear")),
          fit_(use_of(fit, "options->estimator.fit")), bank_(use_of(bank, "options->estimator.bank")),
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
