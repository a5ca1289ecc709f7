// Method: the Fisher matrix F of all candidates, of the parameters that are always free and of the others gives the
// standard deviation of each, sqrt((F^-1)_ii). The candidate that is determined worst, in units of its limit, is left
// out until all are within their limits: with an error of 5 nm the phase is wrong by 0.05 rad, where images are still
// linear in the OPD. A parameter that a frame determines less costs the separation, and helps nothing: drift of a
// calibrated telescope is smaller.
#include "fit/self.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/symmetric.hpp"
#include "fit/fit.hpp"
#include "optics/derivatives.hpp"

namespace toliman::fit {

namespace {

using Kind = Parameter::Kind;

constexpr int kLastZernike = 11;
constexpr double kMostNm = 5, kMostPx2 = 0.02; // standard deviations
constexpr double kCapture = 0.1;               // px: only the scene's own frame is used
constexpr size_t kBandSteps = 10;              // enough for standard deviations to a few percent

double limit_of(Parameter parameter) noexcept {
    return parameter.kind == Kind::focus || parameter.kind == Kind::zernike ? kMostNm : kMostPx2;
}

std::vector<Parameter> candidates(const optics::Simulator &simulator, const std::vector<Parameter> &others) {
    std::vector<Parameter> all = {{Kind::jitter_xx}, {Kind::jitter_yy}, {Kind::jitter_xy}, {Kind::focus}};
    for (int number = kFirstZernike; number <= kLastZernike; number++)
        all.push_back({Kind::zernike, number});
    const auto is_unfit = [&](Parameter parameter) {
        return std::find(others.begin(), others.end(), parameter) != others.end() ||
               optics::why_no_derivative(simulator.scene(), simulator.plan(), parameter) != nullptr;
    };
    all.erase(std::remove_if(all.begin(), all.end(), is_unfit), all.end());
    all.resize(std::min(all.size(), kMostParameters - always - std::min(others.size(), kMostParameters - always)));
    return all;
}

// The scene with fewer wavelengths.
optics::Simulator rough_of(const optics::Simulator &simulator, unsigned workers) {
    Scene scene = simulator.scene();
    if (scene.band)
        scene.band->steps = std::min(scene.band->steps, kBandSteps);
    optics::Settings settings;
    settings.workers = workers;
    return optics::Simulator(optics::outline_of(scene, settings), settings);
}

// The rows and columns `kept` of F [n][n]; the largest standard deviation over its limit among the last ones, those of
// the candidates, and which of them has it.
double worst_of(const Buffer<double> &fisher, size_t n, const std::vector<size_t> &kept, size_t first,
                const std::vector<double> &limits, size_t &worst) {
    const size_t size = kept.size();
    Buffer<double> part(size * size);
    for (size_t i = 0; i < size; i++)
        for (size_t j = 0; j < size; j++)
            part[i * size + j] = fisher[kept[i] * n + kept[j]];
    const bool solvable = invert_symmetric(part.data(), size);
    double largest = 0;
    for (size_t i = first; i < size; i++) { // without the inverse: the diagonal, that of the parameter alone
        const double alone = fisher[kept[i] * n + kept[i]], limit = limits[kept[i]];
        const double sigma = solvable ? std::sqrt(part[i * size + i]) : 1 / std::sqrt(alone);
        const double ratio = alone > 0 ? sigma / limit : std::numeric_limits<double>::infinity();
        if (i == first || ratio > largest) {
            largest = ratio;
            worst = i;
        }
    }
    return solvable ? largest : std::numeric_limits<double>::infinity();
}

} // namespace

std::vector<Parameter> self_parameters(const optics::Simulator &simulator, const std::vector<Parameter> &others,
                                       unsigned workers) {
    std::vector<Parameter> free = others;
    const std::vector<Parameter> found = candidates(simulator, others);
    free.insert(free.end(), found.begin(), found.end());
    const optics::Simulator rough = rough_of(simulator, workers);
    const Model model(rough, free, kCapture, workers, {}, Model::Effects::any);
    const size_t n = model.parameters(), first = always + others.size();
    std::vector<double> values(n), limits(n);
    std::vector<size_t> kept(n);
    for (size_t i = 0; i < n; i++) {
        kept[i] = i;
        limits[i] = i >= first ? limit_of(free[i - always]) : 0;
    }
    for (size_t star = 0; star < 2; star++)
        for (size_t axis = 0; axis < 2; axis++)
            values[2 * star + axis] = rough.light().offset_px[star][axis];
    Work work = model.work();
    model.linearise(nullptr, values.data(), 0, work);
    for (size_t worst = 0; kept.size() > first;) {
        if (worst_of(work.matrix, n, kept, first, limits, worst) <= 1)
            break;
        kept.erase(kept.begin() + static_cast<long>(worst));
    }
    std::vector<Parameter> chosen;
    for (size_t i = first; i < kept.size(); i++)
        chosen.push_back(free[kept[i] - always]);
    return chosen;
}

} // namespace toliman::fit
