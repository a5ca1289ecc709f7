// Method: with whitened images u = (dI/dp)/sqrt(V) of the free parameters and g = (dI/dd)/sqrt(V) of the separation d,
// the least-squares estimate of d is q . r/sqrt(V) for a residual r, where
//     q = (g - P g)/|g - P g|^2,   P the projection onto the span of the u.
// Its standard deviation is 1/|g - P g|, the Cramer-Rao bound. A parameter that is not free and off by one unit adds
// the residual dI/dp, a bias of q . u. A free one leaves its second-order term, 1/2 d^2 I/dp^2, in the residual.
//     The covariance of all free parameters is R^-1 R^-T, with the factor R of the QR decomposition of the whitened
// images, scaled to unit norm. The Fisher matrix R^T R is not formed: that would square the condition number.
//     K frames that share the instrument's parameters, with all others free in each: eliminating the frames' own
// parameters leaves the information of the shared ones summed over the frames (Schur complement). For identical frames
//     variance = f^2 + (a^2 - f^2)/K,
// with the bounds f, only the frame's parameters free, and a, all free. The second term is common to all frames.
// Reference: Kay 1993, Fundamentals of Statistical Signal Processing: Estimation Theory, chapter 3.
#include "information/budget.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "information/curvature.hpp"
#include "information/information.hpp"
#include "kernels/project.hpp"
#include "scene/geometry.hpp"
#include "scene/wobble.hpp"

namespace toliman::information {

namespace {

using Kind = Parameter::Kind;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kEarthAu[2] = {1.23, 0.71};
constexpr int kLastLowZernike = 11, kLastLowSpectralMode = 2;

Buffer<double> whitened(const optics::Images &images, const Buffer<double> &image) {
    Buffer<double> result(image.size());
    kernels::whiten(image.data(), images.variance().data(), image.size(), result.data());
    return result;
}

template <class Vector> double product(const Vector &a, const Vector &b) noexcept {
    return kernels::dot(a.data(), b.data(), a.size());
}

// The QR decomposition of whitened images, column by column.
class Decomposition {
  public:
    explicit Decomposition(size_t pixels) : pixels_(pixels) {}

    // Appends an image; returns its component perpendicular to those before, empty if it depends on them.
    Buffer<double> append(const Buffer<double> &image) {
        Buffer<double> rest = image;
        const double after = kernels::project_out_twice(basis_.data(), norms_.size(), pixels_, rest.data()).after;
        if (!(after > 0))
            return {};
        const double norm = std::sqrt(product(image, image));
        std::vector<double> column;
        for (size_t i = 0; i < norms_.size(); i++)
            column.push_back(kernels::dot(basis_.data() + i * pixels_, image.data(), pixels_) / norm);
        column.push_back(after / norm);
        columns_.push_back(std::move(column));
        norms_.push_back(norm);
        basis_.resize(norms_.size() * pixels_);
        for (size_t i = 0; i < pixels_; i++)
            basis_[(norms_.size() - 1) * pixels_ + i] = rest[i] / after;
        return rest;
    }

    // Rows of R^-1 in units of the images: their products are the covariances.
    std::vector<std::vector<double>> deviations() const {
        const size_t n = norms_.size();
        std::vector<std::vector<double>> rows(n, std::vector<double>(n, 0.0));
        for (size_t j = 0; j < n; j++)
            for (size_t i = j + 1; i-- > 0;) {
                double sum = i == j ? 1 : 0;
                for (size_t k = i + 1; k <= j; k++)
                    sum -= columns_[k][i] * rows[k][j];
                rows[i][j] = sum / columns_[i][i];
            }
        for (size_t i = 0; i < n; i++)
            for (double &value : rows[i])
                value /= norms_[i];
        return rows;
    }

  private:
    size_t pixels_;
    Buffer<double> basis_; // [columns][pixels], orthonormal
    std::vector<std::vector<double>> columns_;
    std::vector<double> norms_; // of the images
};

// Error of the estimate for a whitened residual. 0 if that depends on the free images but for rounding.
double bias_of(const BudgetFit &fit, const Buffer<double> &residual) {
    if (fit.weights.empty())
        return kUnknown;
    const double bias = product(fit.weights, residual);
    const double largest = std::sqrt(product(fit.weights, fit.weights) * product(residual, residual));
    return std::fabs(bias) > kernels::kRounding * largest ? bias : 0;
}

// Standard deviation of the error due to responses of unit standard deviation, independent from pixel to pixel.
double flat_bias(const optics::Simulator &simulator, const BudgetFit &fit) {
    if (fit.weights.empty())
        return kUnknown;
    Buffer<double> light = simulator.images().both();
    for (double &value : light)
        value -= simulator.detector().dark_e();
    const Buffer<double> residual = whitened(simulator.images(), light);
    double square = 0;
    for (size_t i = 0; i < residual.size(); i++)
        square += fit.weights[i] * fit.weights[i] * residual[i] * residual[i];
    return std::sqrt(square);
}

} // namespace

Earth earth_of(const Scene &scene) {
    const Signal &signal = scene.signal;
    const Star &star = scene.stars[signal.star];
    if (signal.kind == Signal::Kind::planet)
        return {signal.amplitude_px, "the planet of the scene"};
    if (star.mass_sun && scene.binary.distance_pc) {
        const double uas = reflex_uas({1, kEarthAu[signal.star], *star.mass_sun, *scene.binary.distance_pc});
        return {uas / uas_per_px(scene),
                signal.star == 0 ? "an Earth at 1.23 au of star A" : "an Earth at 0.71 au of star B"};
    }
    if (signal.amplitude_px > 0)
        return {signal.amplitude_px, "the amplitude of the signal"};
    return {kUnknown, "not known"};
}

double uas_per_px(const Scene &scene) noexcept {
    return scene.detector.pixel_scale_arcsec * 1e6 / pixels_along_axis(scene);
}

BoundOfFrames bound_of_frames(const optics::Simulator &simulator, const std::vector<Parameter> &free, double frames) {
    std::vector<Parameter> of_frame;
    for (const Parameter parameter : free)
        if (scope_of(parameter) == Scope::frame)
            of_frame.push_back(parameter);
    const double all = bound_with(simulator.images(), free);
    const double alone = of_frame.size() < free.size() ? bound_with(simulator.images(), of_frame) : all;
    return {all, std::isinf(all) ? all : std::sqrt(alone * alone + (all * all - alone * alone) / frames)};
}

std::vector<BudgetStep> budget_steps(const optics::Simulator &simulator) {
    const std::vector<Parameter> flux_shift = {{Kind::flux_a}, {Kind::flux_b}, {Kind::shift_x}, {Kind::shift_y}},
                                 others = {{Kind::roll}, {Kind::scale}, {Kind::focus}, {Kind::background}},
                                 jitter = {{Kind::jitter_xx}, {Kind::jitter_yy}, {Kind::jitter_xy}},
                                 temperatures = {{Kind::temperature_a}, {Kind::temperature_b}};
    std::vector<Parameter> zernikes;
    for (int noll = 5; noll <= 10; noll++)
        zernikes.push_back({Kind::zernike, noll});
    using Sets = std::vector<const std::vector<Parameter> *>;
    const std::vector<Parameter> wavelength = {{Kind::wavelength}};
    const std::pair<const char *, Sets> sets[] = {
        {"alone", {}},
        {"fluxes, shift", {&flux_shift}},
        {"eight", {&flux_shift, &others}},
        {"eight + jitter", {&flux_shift, &others, &jitter}},
        {"eight + Noll 5-10", {&flux_shift, &others, &zernikes}},
        {"eight + temperatures", {&flux_shift, &others, &temperatures}},
        {"all of these", {&flux_shift, &others, &jitter, &zernikes, &temperatures}},
        {"all + wavelength", {&flux_shift, &others, &jitter, &zernikes, &temperatures, &wavelength}},
    };
    std::vector<BudgetStep> steps;
    for (const auto &[name, parts] : sets) {
        BudgetStep &step = steps.emplace_back();
        step.name = name;
        for (const std::vector<Parameter> *part : parts)
            for (const Parameter parameter : *part)
                if (why_no_derivative(simulator.scene(), simulator.plan(), parameter) == nullptr)
                    step.free.push_back(parameter);
    }
    return steps;
}

BudgetFit fit_of(const optics::Images &images, const std::vector<Parameter> &free) {
    images.prepare(free);
    Decomposition decomposition(images.both().size());
    std::vector<size_t> entries; // in the matrix of correlations, of each image that does not depend on those before
    for (size_t i = 0; i < free.size(); i++)
        if (!decomposition.append(whitened(images, image_of(images, free[i]))).empty())
            entries.push_back(i + 1);
    BudgetFit fit;
    const size_t n = free.size() + 1;
    fit.deviation.assign(n - 1, kUnknown);
    fit.correlations.assign(n * n, kUnknown);
    fit.weights = decomposition.append(whitened(images, images.motion()[0]));
    if (fit.weights.empty())
        return fit;
    entries.push_back(0);
    const double square = product(fit.weights, fit.weights);
    for (double &value : fit.weights)
        value /= square;
    const std::vector<std::vector<double>> deviations = decomposition.deviations();
    std::vector<double> lengths;
    for (const std::vector<double> &deviation : deviations)
        lengths.push_back(std::sqrt(product(deviation, deviation)));
    for (size_t i = 0; i < entries.size(); i++) {
        if (entries[i] > 0)
            fit.deviation[entries[i] - 1] = lengths[i];
        for (size_t j = 0; j < entries.size(); j++)
            fit.correlations[entries[i] * n + entries[j]] =
                i == j ? 1 : product(deviations[i], deviations[j]) / (lengths[i] * lengths[j]);
    }
    return fit;
}

std::vector<Parameter> others_than(const optics::Simulator &simulator, const std::vector<Parameter> &free,
                                   bool low_orders) {
    const auto is_high = [](const Parameter &parameter) {
        const bool is_spectral = parameter.kind == Kind::spectrum_a || parameter.kind == Kind::spectrum_b;
        return (parameter.kind == Kind::zernike && parameter.number > kLastLowZernike) ||
               (is_spectral && parameter.number > kLastLowSpectralMode);
    };
    std::vector<Parameter> others;
    for (const Parameter parameter : all_parameters())
        if (parameter.kind != Kind::separation && !(low_orders && is_high(parameter)) &&
            std::find(free.begin(), free.end(), parameter) == free.end() &&
            why_no_derivative(simulator.scene(), simulator.plan(), parameter) == nullptr)
            others.push_back(parameter);
    return others;
}

std::vector<BudgetRow> budget_rows(const optics::Simulator &simulator, const std::vector<Parameter> &free,
                                   const std::vector<Parameter> &others, const BudgetFit &fit) {
    const optics::Images &images = simulator.images();
    images.prepare(others);
    const auto bias = [&](const Buffer<double> &image) { return bias_of(fit, whitened(images, image)); };
    std::vector<BudgetRow> rows;
    for (const Parameter parameter : free) {
        const auto curvature = half_curvature(simulator, parameter);
        rows.push_back({parameter, true, kUnknown, !curvature ? kUnknown : curvature->empty() ? 0 : bias(*curvature)});
    }
    for (const Parameter parameter : others)
        rows.push_back({parameter, false, bias(image_of(images, parameter)), kUnknown});
    rows.push_back({{Kind::flat}, false, flat_bias(simulator, fit), kUnknown});
    return rows;
}

} // namespace toliman::information
