// Method: for counts with mean I and variance V the Fisher matrix of the separation d and the nuisances q_k is
//     F_ij = sum over pixels of (dI/da_i) (dI/da_j) / V,   a = (d, q_1, q_2, ...),
// and the Cramer-Rao bound of d with all q free is sqrt((F^-1)_00). With g = (dI/dd) / sqrt(V), the whitened signal,
// and u_k = (dI/dq_k) / sqrt(V) this equals 1 / |g - P g|, P the orthogonal projection onto the span of the u_k. The
// projection is computed instead of F^-1: inverting F would square the condition number where nuisances are nearly
// degenerate. Linearly dependent nuisances are dropped.
// Exact for photon noise, V = I; with read noise, V = I + sigma_read^2, the usual Gaussian approximation.
// Reference: Kay 1993, Fundamentals of Statistical Signal Processing: Estimation Theory, chapter 3.
#include "information/information.hpp"

#include <limits>

#include "kernels/project.hpp"

namespace toliman::information {

using Kind = Parameter::Kind;

double bound_with(const optics::Images &images, const std::vector<Parameter> &free) {
    images.prepare(free);
    const size_t n = images.both().size();
    Buffer<double> nuisances(free.size() * n), signal(n);
    for (size_t k = 0; k < free.size(); k++)
        kernels::whiten(image_of(images, free[k]).data(), images.variance().data(), n, nuisances.data() + k * n);
    kernels::whiten(images.motion()[0].data(), images.variance().data(), n, signal.data());
    const size_t rank = kernels::orthonormalise(nuisances.data(), free.size(), n);
    const double remaining = kernels::project_out_twice(nuisances.data(), rank, n, signal.data()).after;
    return remaining > 0 ? 1 / remaining : std::numeric_limits<double>::infinity();
}

double gradient_energy(const optics::Images &images) {
    const optics::Disturbed &slopes = images.disturbed();
    const size_t n = images.both().size();
    double square = 0, light = 0;
    for (size_t i = 0; i < n; i++) {
        square += slopes.shift_x[i] * slopes.shift_x[i] + slopes.shift_y[i] * slopes.shift_y[i];
        light += images.star(0)[i] + (images.star(1).empty() ? 0 : images.star(1)[i]);
    }
    return square / light / light * static_cast<double>(n);
}

std::vector<Parameter> fluxes_and_shift(const Scene &scene) {
    std::vector<Parameter> free = {{Kind::flux_a}};
    if (scene.stars.size() == 2)
        free.push_back({Kind::flux_b});
    free.insert(free.end(), {{Kind::shift_x}, {Kind::shift_y}});
    return free;
}

std::vector<Parameter> eight_nuisances(const Scene &scene) {
    std::vector<Parameter> free = fluxes_and_shift(scene);
    free.insert(free.end(), {{Kind::roll}, {Kind::scale}, {Kind::focus}, {Kind::background}});
    return free;
}

Bounds bound(const Scene &scene, const optics::Images &images) {
    Bounds bounds;
    bounds.alone = bound_with(images, {});
    bounds.flux_shift = bound_with(images, fluxes_and_shift(scene));
    bounds.marginal = bound_with(images, eight_nuisances(scene));
    bounds.projected = bound_with(images, scene.projected);
    return bounds;
}

const Bounds &KnownBounds::of(const optics::Simulator &simulator) const {
    const optics::Images &images = simulator.bound_images();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!bounds_)
        bounds_ = bound(simulator.scene(), images);
    return *bounds_;
}

} // namespace toliman::information
