#include "optics/pupil.hpp"

#include <algorithm>
#include <cmath>

#include "backend/file.hpp"
#include "base/npy.hpp"

namespace toliman::optics {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kSubsamples = 16; // per side of a cell that an edge crosses

// How far a point is inside the open aperture, in m; negative where light is blocked. Changes no faster than the point
// moves, so a cell whose centre is deeper than half its diagonal is open throughout.
class Opening {
  public:
    explicit Opening(const Telescope &telescope)
        : outer_(telescope.aperture_m / 2), inner_(telescope.secondary_m / 2),
          half_width_(telescope.struts.width_m / 2) {
        for (int i = 0; i < telescope.struts.count; i++) {
            const double angle = (telescope.struts.angle_deg + 360.0 * i / telescope.struts.count) * kPi / 180;
            directions_.push_back({std::cos(angle), std::sin(angle)});
        }
    }

    double depth(double x, double y) const noexcept {
        const double r = std::hypot(x, y);
        double depth = std::min(outer_ - r, inner_ > 0 ? r - inner_ : outer_);
        for (const Direction &d : directions_) // a strut runs from the centre outwards
            depth = std::min(depth, std::max(std::fabs(d.x * y - d.y * x) - half_width_, -(d.x * x + d.y * y)));
        return depth;
    }

  private:
    struct Direction {
        double x, y;
    };
    double outer_, inner_, half_width_;
    std::vector<Direction> directions_;
};

// Open part of a cell around (x, y). Each subsample counts by its distance from the edge, as if its own small cell were
// cut straight: edges along the grid come out exact, others to 1e-3 of the cell.
double open_fraction(const Opening &opening, double x, double y, double cell) noexcept {
    const double depth = opening.depth(x, y), step = cell / kSubsamples, reach = 0.7072 * cell + 0.5 * step;
    if (depth >= reach)
        return 1;
    if (depth <= -reach)
        return 0;
    double open = 0;
    for (int i = 0; i < kSubsamples; i++)
        for (int j = 0; j < kSubsamples; j++) {
            const double inside = opening.depth(x + step * (j + 0.5) - cell / 2, y + step * (i + 0.5) - cell / 2);
            open += std::clamp(0.5 + inside / step, 0.0, 1.0);
        }
    return open / (kSubsamples * kSubsamples);
}

// Sum of spiral cosines at a point in units of the aperture's radius.
double spiral(const std::vector<SpiralTerm> &terms, double x, double y) noexcept {
    const double r = std::max(std::hypot(x, y), 1e-12), theta = std::atan2(y, x);
    double sum = 0;
    for (const SpiralTerm &term : terms)
        sum += term.a * std::cos(2 * kPi * term.f * r + term.l * std::log(r) + term.m * theta + term.p);
    return sum;
}

double opd_of(const Mask &mask, double value, size_t i) {
    switch (mask.quantity) {
    case Mask::Quantity::binary:
        if (value != 0 && value != 1)
            fail(Status::format, "%s: element %zu = %g: a binary mask holds 0 and 1", mask.file.c_str(), i, value);
        return value * mask.opd_m;
    case Mask::Quantity::opd_m:
        break;
    case Mask::Quantity::phase_rad:
        return value / (2 * kPi) * mask.reference_m;
    }
    return value;
}

void read_mask_file(const Scene &scene, Pupil &pupil) {
    const Mask &mask = scene.telescope.mask;
    const size_t n = pupil.samples;
    const NpyImage image = parse_npy(file::read(mask.file, n * n * sizeof(double) + 65536), mask.file);
    if (image.rows != n || image.cols != n)
        fail(Status::format, "%s: telescope.mask.file: %s is %zu x %zu: must be %zu x %zu, the pupil_samples",
             scene.source.c_str(), mask.file.c_str(), image.rows, image.cols, n, n);
    for (size_t i = 0; i < n * n; i++) {
        if (!(std::fabs(image.values[i]) < 1e6))
            fail(Status::format, "%s: element %zu = %g: must be finite and below 1e6", mask.file.c_str(), i,
                 image.values[i]);
        pupil.opd_m[i] = opd_of(mask, image.values[i], i);
    }
}

} // namespace

Pupil make_pupil(const Scene &scene) {
    const Telescope &telescope = scene.telescope;
    const size_t n = telescope.pupil_samples;
    const Opening opening(telescope);
    const double cell = telescope.aperture_m / static_cast<double>(n), radius = telescope.aperture_m / 2;
    Pupil pupil;
    pupil.samples = n;
    pupil.aperture_m = telescope.aperture_m;
    pupil.amplitude.resize(n * n);
    pupil.opd_m.resize(n * n);
    const auto coordinate = [&](size_t i) {
        return (static_cast<double>(i) - 0.5 * static_cast<double>(n - 1)) * cell;
    };
    for (size_t row = 0; row < n; row++) {
        for (size_t col = 0; col < n; col++) {
            const double x = coordinate(col), y = coordinate(row), open = open_fraction(opening, x, y, cell);
            pupil.amplitude[row * n + col] = open;
            pupil.area += open;
            if (telescope.mask.kind == Mask::Kind::spiral && spiral(telescope.mask.terms, x / radius, y / radius) > 0)
                pupil.opd_m[row * n + col] = telescope.mask.opd_m;
        }
    }
    if (telescope.mask.kind == Mask::Kind::file)
        read_mask_file(scene, pupil);
    if (!(pupil.area >= 1))
        fail(Status::scene, "%s: telescope: secondary and struts leave less than a sample open", scene.source.c_str());
    return pupil;
}

} // namespace toliman::optics
