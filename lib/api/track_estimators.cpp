#include "api/track_estimators.hpp"

#include <algorithm>
#include <cmath>

#include "api/members.hpp"
#include "api/spread.hpp"
#include "estimate/values.hpp"

namespace toliman::api {

static_assert(estimate::kBankFlags == TOLIMAN_TRACK_BANK_FLAGS);

track::Source source_of(const toliman_track_options &options, unsigned workers) {
    const bool given[] = {options.estimator.cae != nullptr, options.estimator.linear != nullptr,
                          options.estimator.fit != nullptr, options.estimator.estimate != nullptr};
    if (given[0] + given[1] + given[2] + given[3] > 1)
        fail(Status::argument, "{options}: at most one of cae, linear, fit and estimate may be set");
    if (given[0])
        return estimate::of_network(options.estimator.cae->network, workers);
    if (given[1])
        return estimate::of_template(options.estimator.linear->estimator, workers);
    if (options.estimator.bank != nullptr && !given[2])
        fail(Status::argument, "{options->estimator.bank}: needs fit, the fit for which it was made");
    if (given[2])
        return moving_source(options, 0);
    track::Source source;
    source.digest = options.estimator.id;
    source.values = options.estimator.values;
    return source;
}

track::Source moving_source(const toliman_track_options &options, int64_t time_offset_ns) {
    const toliman_fit &fit = *options.estimator.fit;
    return options.estimator.bank != nullptr
               ? options.estimator.bank->source(*options.estimator.bank, fit, time_offset_ns)
               : fit.source(fit, time_offset_ns);
}

namespace {

toliman_estimate_input input_of(const double *image, const track::Frame &frame, int64_t tai_ns,
                                const track::Terms &terms) {
    const track::Geometry &geometry = terms.geometry;
    const double noise = frame.sigma != 0 ? frame.sigma / terms.sigma : 1;
    toliman_estimate_input input = {};
    input.struct_size = sizeof input;
    input.image = image;
    input.rows = geometry.out_rows;
    input.cols = geometry.out_cols;
    input.stride = geometry.out_cols;
    input.tai_ns = tai_ns;
    input.variance_scale = noise * noise;
    TOLIMAN_COPY(input, frame, exposure_s, intervals, interval_count);
    input.window_row = frame.window_row + static_cast<int64_t>(geometry.crop_row);
    input.window_col = frame.window_col + static_cast<int64_t>(geometry.crop_col);
    return input;
}

} // namespace

track::Estimate estimate_of(const toliman_track_options &options, const track::Terms &terms,
                            const track::Columns &columns) {
    return [call = options.estimator.estimate, data = options.estimator.estimate_data, terms, count = columns.values()](
               double *image, const track::Frame &frame, int64_t tai_ns, unsigned, track::Estimated &estimated) {
        toliman_estimate_input input = input_of(image, frame, tai_ns, terms);
        const toliman_spread spread = public_spread(frame.spread);
        if (frame.spread.any())
            input.spread = &spread;
        double values[track::kMaxValues], covariance[track::kMaxValues * track::kMaxValues];
        std::fill_n(values, count, NAN);
        std::fill_n(covariance, count * count, NAN);
        toliman_estimate made = {};
        made.struct_size = sizeof made;
        made.values = values;
        made.value_count = count;
        made.covariance = covariance;
        made.chi_square = NAN;
        if (call(&input, &made, data) != 0)
            return;
        estimated.value = values[0];
        TOLIMAN_COPY(estimated, made, sigma, chi_square, flags);
        estimate::store_further(values, covariance, count, estimated);
    };
}

} // namespace toliman::api
