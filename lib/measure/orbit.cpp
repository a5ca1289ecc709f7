#include "measure/orbit.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "scene/system.hpp"
#include "sky/columns.hpp"
#include "sky/reduction.hpp"

namespace toliman::measure {

namespace {

// Names and standard deviations change no value.
bool has_same_numbers(const sky::System &a, const sky::System &b) {
    const sky::Predictor first(a, {}), second(b, {});
    return first.digest() == second.digest() && a.refit.has_value() == b.refit.has_value();
}

track::Reason reduce(const sky::Predictor &predictor, const track::OnTarget &on_target, track::Reduction &reduction) {
    sky::Exposure exposure = {{}, on_target.listed};
    exposure.intervals.reserve(on_target.spans.size());
    for (const track::Span &span : on_target.spans)
        exposure.intervals.push_back({span.start_ns, span.end_ns});
    try {
        const sky::ExposureMean mean = sky::mean_over(predictor, exposure);
        if (mean.outcome != sky::ExposureMean::Outcome::known)
            return mean.outcome == sky::ExposureMean::Outcome::unknown ? track::Reason::no_intervals
                                                                       : track::Reason::no_orbit;
        reduction.factor = mean.seen.factor;
        reduction.geometric_arcsec = mean.seen.geometric_arcsec;
        std::copy_n(mean.seen.partials, track::kPartials, reduction.partials);
        return track::Reason::none;
    } catch (const Error &error) {
        if (error.status() == Status::argument) // no length in ns, or longer than a mean may be
            return track::Reason::no_intervals;
        if (error.status() == Status::range) // years before 1900 or after 2100
            return track::Reason::no_orbit;
        throw;
    }
}

} // namespace

track::Orbit orbit_of(const sky::Predictor &predictor, const std::string &known) {
    static_assert(track::kPartials == sky::kElements);
    if (predictor.without() != 0)
        fail(Status::argument, "{options->reduction.sky}: leaves out effects 0x%x: must include all",
             predictor.without());
    const bool is_same = !known.empty() && has_same_numbers(read_system(known, "setup.tlms"), predictor.system());
    return {is_same ? known : system_json(predictor.system()),
            predictor.observer().kind() != sky::Observer::Kind::earth,
            [&predictor](const track::OnTarget &on_target, track::Reduction &reduction) {
                return reduce(predictor, on_target, reduction);
            },
            [&predictor](double scale_sigma, period::Basis &basis, track::OrbitErrors &errors) {
                for (const sky::Column &column : sky::error_columns(predictor.system(), scale_sigma)) {
                    basis.bound[static_cast<size_t>(basis.columns++)] = column.bound;
                    errors.sigmas[column.element] = column.sigma;
                }
            }};
}

} // namespace toliman::measure
