// Method: the changes are tried in the order in which an error of one would be taken for the next: first how the pupil
// is sampled (edges of the mask, number of cells), then the spectra, then the map, which imitates all of them in part.
// Changes with time come before the map, and first of all where they explain nearly all that is not noise
// (verdict.cpp); each time in twice as many windows. Each change starts from the last result, so that it needs few
// iterations.
// A change with p further parameters lowers the sum of squared residuals of a complete model by chi-square with p
// degrees of freedom. It is kept if the sum, over chi-square per degree of freedom where that is above 1, falls by more
// than the quantile of this distribution at 6 standard deviations. For a map, p is the effective number of parameters
// in one step (map.cpp), and twice as much may be noise (verdict.cpp).
#include "calibrate/improve.hpp"

#include <algorithm>
#include <cmath>

#include "calibrate/prior.hpp"
#include "optics/derivatives.hpp"

namespace toliman::calibrate {

namespace {

using Kind = Parameter::Kind;

constexpr Lack kOrder[] = {lacks_edges, lacks_samples, lacks_spectrum, lacks_drift, lacks_map};
constexpr double kLeastDrift = 0.1, kMostlyDrift = 0.9;
constexpr size_t kMostSamples = 1024; // per axis; more cells than any mask is made with
constexpr Parameter kModes[] = {
    {Kind::spectrum_a, 1}, {Kind::spectrum_a, 2}, {Kind::spectrum_b, 1}, {Kind::spectrum_b, 2}};

bool is_free(const Problem &problem, Parameter parameter) noexcept {
    return std::any_of(problem.free.begin(), problem.free.end(),
                       [=](const Free &one) { return one.parameter == parameter; });
}

// Whether the scene may have other pupil cells: its files, and a map to start from, have exactly those of the scene.
bool is_resizable(const Telescope &telescope, const Calibration &calibration) noexcept {
    return telescope.mask.kind != Mask::Kind::file && telescope.amplitude_file.empty() && telescope.opd_file.empty() &&
           (calibration.point.map_m.empty() || calibration.map_iterations > 0);
}

// The modes that the scene has and that are not free, to be appended to the text of the parameters.
std::string missing_modes(const Problem &problem, const std::string &free) {
    const char *const before = free.empty() || free.find('+') != std::string::npos ? " +" : " ";
    const optics::Outline outline = optics::outline_of(problem.nominal, problem.settings);
    std::string names;
    for (const Parameter mode : kModes)
        if (!is_free(problem, mode) && optics::why_no_derivative(problem.nominal, outline.plan, mode) == nullptr)
            names += before + name_of(mode);
    return names;
}

bool may_lack(Lack lack, const Calibration &calibration, const Problem &problem, const Options &options) {
    const Telescope &telescope = problem.nominal.telescope;
    switch (lack) {
    case lacks_edges:
        return telescope.mask.kind == Mask::Kind::spiral && telescope.mask.edges == Mask::Edges::cell;
    case lacks_samples:
        return telescope.pupil_samples < kMostSamples && is_resizable(telescope, calibration) &&
               calibration.pupil_error > std::max(problem.nominal.accuracy, calibration.peak_noise);
    case lacks_spectrum:
        return !missing_modes(problem, "").empty();
    case lacks_drift:
        return calibration.drift > kLeastDrift;
    default:
        return !options.map && !problem.frames.has_sums();
    }
}

// The problem that calibrates one change of the model; and where it starts.
struct Variant {
    Problem problem;
    std::string free;
    Options options;
    Point start;
};

// Values of the parameters that both have; the others start at 0.
std::vector<std::vector<double>> carried(const Calibration &from, const std::vector<Window> &windows,
                                         const Problem &to) {
    std::vector<std::vector<double>> instrument;
    for (const std::vector<double> &window : at_starts(from.point.instrument, windows, to.windows)) {
        instrument.emplace_back(to.free.size());
        for (size_t i = 0; i < to.free.size(); i++)
            for (size_t k = 0; k < from.free.size(); k++)
                if (from.free[k].parameter == to.free[i].parameter)
                    instrument.back()[i] = window[k];
    }
    return instrument;
}

Variant with(Lack lack, Variant variant, const Calibration &from) {
    Telescope &telescope = variant.problem.nominal.telescope;
    if (lack == lacks_edges)
        telescope.mask.edges = Mask::Edges::area;
    if (lack == lacks_samples)
        telescope.pupil_samples = std::min(2 * telescope.pupil_samples, kMostSamples);
    if (lack == lacks_spectrum)
        variant.free += missing_modes(variant.problem, variant.free);
    const std::vector<Window> windows = variant.problem.windows;
    if (lack == lacks_drift)
        refine_windows(variant.problem);
    variant.options.map |= lack == lacks_map;
    variant.options.lack = lack;
    variant.options.improved |= lack;
    const optics::Outline outline = optics::outline_of(variant.problem.nominal, variant.problem.settings);
    const std::vector<Free> before = variant.problem.free;
    variant.problem.left_out.clear();
    variant.problem.free =
        free_of(variant.free, variant.problem.nominal, outline.plan, variant.problem.peak_e, &variant.problem.left_out);
    if ((from.flags & not_converged) == 0) {
        variant.start = from.point;
        variant.start.instrument = carried(from, windows, variant.problem);
    } else { // from where the one before started
        Calibration start;
        start.free = before;
        start.point = variant.start;
        variant.start.instrument = carried(start, windows, variant.problem);
    }
    return variant;
}

bool is_better(const Calibration &next, const Calibration &before) noexcept {
    if ((next.flags & not_converged) != 0)
        return false;
    if ((before.flags & not_converged) != 0)
        return true;
    const double of_map = next.map_parameters - before.map_parameters,
                 added = std::max(1.0, before.freedom - next.freedom),
                 noise = added * chi_square_quantile(std::sqrt(2 / added), kFrameSigmas) + std::max(0.0, of_map);
    return (before.squares - next.squares) / std::max(1.0, next.goodness.chi_square) > noise;
}

bool needs_more(const Calibration &calibration, Lack lack) noexcept {
    const bool failed = (calibration.flags & not_converged) != 0;
    return failed ? lack == lacks_edges || lack == lacks_samples : (calibration.flags & incomplete) != 0;
}

// Tries one change, and keeps it if it is better, or if it must be.
bool attempt(Lack lack, bool must, Variant &model, Calibration &best) {
    Variant variant = with(lack, model, best);
    Calibration next = calibrate(variant.problem, variant.start, variant.options);
    const bool kept = must || is_better(next, best);
    std::vector<Attempt> attempts = best.attempts;
    attempts.push_back({lack, kept, next.flags, next.samples, next.goodness});
    if (kept) {
        next.before = std::move(best.before);
        best = std::move(next);
        model = std::move(variant);
    }
    best.attempts = std::move(attempts);
    return kept;
}

} // namespace

uint32_t lacks_of(const Calibration &calibration, const Problem &problem, const Options &options) {
    uint32_t lacks = 0;
    for (const Lack lack : kOrder)
        if ((calibration.flags & incomplete) != 0 && may_lack(lack, calibration, problem, options))
            lacks |= lack;
    return lacks;
}

Calibration improve(Problem problem, const std::string &free, const Point &start, Options options) {
    const bool must_map = options.map; // after all else
    options.map = false;
    Calibration best = calibrate(problem, start, options);
    Variant model = {std::move(problem), free, std::move(options), start};
    while (best.drift > kMostlyDrift && needs_more(best, lacks_drift) && attempt(lacks_drift, false, model, best)) {
    }
    for (const Lack lack : kOrder) {
        const bool must = lack == lacks_map && must_map && (best.flags & not_converged) == 0;
        while ((must || needs_more(best, lack)) && may_lack(lack, best, model.problem, model.options))
            if (!attempt(lack, must, model, best))
                break;
    }
    return best;
}

} // namespace toliman::calibrate
