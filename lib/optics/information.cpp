#include "optics/information.hpp"

#include <limits>

#include "kernels/project.hpp"

namespace toliman::optics {

namespace {

// Standard deviation of the best unbiased estimate of the separation with the nuisances free: one over the length of
// the whitened derivative that is left when the whitened nuisances are projected out.
double bound_with(const Images &images, const std::vector<Nuisance> &free) {
    const size_t n = images.both.size();
    Buffer<double> units(free.size() * n), signal(n);
    for (size_t k = 0; k < free.size(); k++)
        kernels::whiten(image_of(images, free[k]).data(), images.variance.data(), n, units.data() + k * n);
    kernels::whiten(images.motion[0].data(), images.variance.data(), n, signal.data());
    const size_t rank = kernels::orthonormalise(units.data(), free.size(), n);
    const double after = kernels::project_out_twice(units.data(), rank, n, signal.data()).after;
    return after > 0 ? 1 / after : std::numeric_limits<double>::infinity();
}

} // namespace

const Buffer<double> &image_of(const Images &images, Nuisance nuisance) noexcept {
    switch (nuisance) {
    case Nuisance::flux_a:
        return images.star[0];
    case Nuisance::flux_b:
        return images.star[1];
    case Nuisance::shift_x:
        return images.shift_x;
    case Nuisance::shift_y:
        return images.shift_y;
    case Nuisance::roll:
        return images.roll;
    case Nuisance::scale:
        return images.scale;
    case Nuisance::focus:
        return images.focus;
    case Nuisance::background:
        break;
    }
    return images.background;
}

Bounds bound(const Scene &scene, const Images &images) {
    std::vector<Nuisance> free;
    const auto with = [&](std::initializer_list<Nuisance> more) {
        for (const Nuisance nuisance : more)
            if (nuisance != Nuisance::flux_b || scene.stars.size() == 2)
                free.push_back(nuisance);
        return bound_with(images, free);
    };
    Bounds bounds;
    bounds.alone = with({});
    bounds.flux_shift = with({Nuisance::flux_a, Nuisance::flux_b, Nuisance::shift_x, Nuisance::shift_y});
    bounds.marginal = with({Nuisance::roll, Nuisance::scale, Nuisance::focus, Nuisance::background});
    bounds.projected = bound_with(images, scene.projected);
    return bounds;
}

} // namespace toliman::optics
