// Method: cells that an edge crosses get the open fraction of their area (grey pixels), so that the effective area is
// continuous in the aperture's dimensions. The open fraction comes from the signed distance to the nearest edge at
// 16 x 16 points of the cell. Intensities are normalised by sum(A), the open area: with binary transmission a cell that
// is open by A carries A of the light, and sum(A^2) would be 2.5e-3 too small at N = 256.
// Mask, Zernike aberrations (Noll 1976) and OPD files add up to one OPD, exact at all wavelengths. Only a cell that an
// edge of the mask crosses (mask.edges "area") has no OPD of its own: its transmission is the average over the cell,
//     t = 1 - c + c exp(2 pi i s/lambda),   c the covered fraction, s the mask's step,
// whose amplitude and phase depend on the wavelength. The light that |t|^2 < 1 lacks is diffracted beyond the image of
// the cells; it is not renormalised.
#include "optics/pupil.hpp"

#include <algorithm>
#include <cmath>

#include "backend/file.hpp"
#include "base/constants.hpp"
#include "frame/npy_image.hpp"
#include "kernels/cis.hpp"
#include "kernels/zernike.hpp"
#include "optics/mask_cells.hpp"
#include "scene/range.hpp"

namespace toliman::optics {

namespace {

constexpr int kSubsamples = 16;            // per side of a cell that an edge crosses
constexpr double kLargestPhase = 50;       // rad, of a mask's file: detects degrees
constexpr double kLargestOpd = 1e-3;       // m, of a file: detects files in nanometres
constexpr double kMinTransmission = 1e-12; // of an amplitude file, relative to the open aperture

// Signed distance (m) of a point to the nearest edge: positive inside the open aperture, negative where it is blocked.
// It changes no faster than the point moves, so that a cell whose centre is deeper than half its diagonal is open.
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

    // r = hypot(x, y)
    double depth(double x, double y, double r) const noexcept {
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

// Open fraction of a cell around (x, y). Each subsample contributes by its distance from the edge, as if a straight
// edge cut its own small cell: edges along the grid are exact, others within 1e-3 of the cell. Only subsamples that an
// edge crosses need r to the last bit; elsewhere the faster square root gives the same result.
double open_fraction(const Opening &opening, double x, double y, double cell) noexcept {
    const double depth = opening.depth(x, y, std::sqrt(x * x + y * y)), step = cell / kSubsamples,
                 reach = 0.7072 * cell + 0.5 * step;
    if (depth >= reach)
        return 1;
    if (depth <= -reach)
        return 0;
    double open = 0;
    for (int i = 0; i < kSubsamples; i++)
        for (int j = 0; j < kSubsamples; j++) {
            const double u = x + step * (j + 0.5) - cell / 2, v = y + step * (i + 0.5) - cell / 2;
            const double inside = opening.depth(u, v, std::sqrt(u * u + v * v));
            if (std::fabs(inside) >= step)
                open += inside > 0 ? 1 : 0;
            else
                open += std::clamp(0.5 + opening.depth(u, v, std::hypot(u, v)) / step, 0.0, 1.0);
        }
    return open / (kSubsamples * kSubsamples);
}

// Calls cell(i, x, y) for each of the n x n cells, x and y its centre in units of the aperture's radius.
template <class Cell> void for_each_cell(size_t n, Cell cell) {
    const auto coordinate = [n](size_t i) {
        return (2 * static_cast<double>(i) - static_cast<double>(n - 1)) / static_cast<double>(n);
    };
    for (size_t row = 0; row < n; row++)
        for (size_t col = 0; col < n; col++)
            cell(row * n + col, coordinate(col), coordinate(row));
}

double opd_of(const Mask &mask, double value, size_t i) {
    switch (mask.quantity) {
    case Mask::Quantity::binary:
        if (value != 0 && value != 1)
            fail(Status::format, "{%s}: element %zu = %g: must be 0 or 1 in a binary mask", mask.file.c_str(), i,
                 value);
        return value * mask.step_m();
    case Mask::Quantity::opd_m:
        break;
    case Mask::Quantity::phase_rad:
        return value / (2 * kPi) * mask.reference_m;
    }
    return value;
}

// Numbers beyond it are in another unit: nanometres, degrees.
scene::Range range_of(Mask::Quantity quantity) {
    return quantity == Mask::Quantity::opd_m       ? scene::within(-kLargestOpd, kLargestOpd, "m")
           : quantity == Mask::Quantity::phase_rad ? scene::within(-kLargestPhase, kLargestPhase, "rad")
                                                   : scene::within(-1e6, 1e6);
}

// The N x N numbers of the file that the scene names under key, each checked to be within the range.
std::vector<double> read_map(const Scene &scene, const char *key, const std::string &path, size_t n,
                             scene::Range range) {
    NpyImage image = parse_npy(file::read(path, n * n * sizeof(double) + 65536), path);
    if (image.rows != n || image.cols != n)
        fail(Status::format, "%s: {telescope.%s}: %s is %zu x %zu: must be %zu x %zu, as pupil_samples",
             scene.source.c_str(), key, path.c_str(), image.rows, image.cols, n, n);
    for (size_t i = 0; i < n * n; i++)
        if (!(image.values[i] >= range.low && image.values[i] <= range.high))
            fail(Status::format, "{%s}: element %zu = %g: must be in [%g, %g]%s%s", path.c_str(), i, image.values[i],
                 range.low, range.high, range.unit[0] != '\0' ? " " : "", range.unit);
    return std::move(image.values);
}

void add_spiral(const Telescope &telescope, Pupil &pupil) {
    pupil.step_m = telescope.mask.step_m();
    const Buffer<double> covered = covered_fractions(telescope.mask, pupil.aperture_m, pupil.samples, pupil.amplitude);
    for (size_t i = 0; i < covered.size(); i++) {
        pupil.opd_m[i] = covered[i] * pupil.step_m;
        if (covered[i] > 0 && covered[i] < 1)
            pupil.mixed.push_back({i, covered[i]});
    }
}

void add_mask(const Scene &scene, Pupil &pupil) {
    const Mask &mask = scene.telescope.mask;
    if (mask.kind == Mask::Kind::spiral)
        add_spiral(scene.telescope, pupil);
    if (mask.kind != Mask::Kind::file)
        return;
    const std::vector<double> map = read_map(scene, "mask.file", mask.file, pupil.samples, range_of(mask.quantity));
    for (size_t i = 0; i < map.size(); i++)
        pupil.opd_m[i] = opd_of(mask, map[i], i);
}

// Zernike polynomials over the full aperture, without the secondary. Closed cells are skipped, because the polynomials
// grow fast outside the disc.
void add_aberrations(const Scene &scene, Pupil &pupil) {
    const Telescope &telescope = scene.telescope;
    if (!telescope.zernikes.empty())
        for_each_cell(pupil.samples, [&](size_t i, double x, double y) {
            for (const ZernikeTerm &term : telescope.zernikes)
                if (pupil.amplitude[i] > 0)
                    pupil.opd_m[i] += term.rms_m * kernels::zernike(term.noll, x, y);
        });
    const std::vector<double> map = opd_of_file(scene, pupil.samples);
    for (size_t i = 0; i < map.size(); i++)
        pupil.opd_m[i] += map[i];
}

// A cell that is open by A and has the amplitude transmission t transmits A t^2 of its light; its field is A t.
void add_amplitude(const Scene &scene, Pupil &pupil) {
    const std::string &path = scene.telescope.amplitude_file;
    if (path.empty())
        return;
    const std::vector<double> map = read_map(scene, "amplitude.file", path, pupil.samples, scene::within(0, 1));
    const double open = pupil.area;
    pupil.area = 0;
    for (size_t i = 0; i < map.size(); i++) {
        pupil.area += pupil.amplitude[i] * map[i] * map[i];
        pupil.amplitude[i] *= map[i];
    }
    if (!(pupil.area >= kMinTransmission * open))
        fail(Status::scene, "%s: {telescope.amplitude.file}: %s transmits less than %g of the light",
             scene.source.c_str(), path.c_str(), kMinTransmission);
}

// Of the OPD beyond that of the mask.
double steepest_of(const Pupil &pupil, const Buffer<double> &mask) {
    const size_t n = pupil.samples;
    double steepest = 0;
    const auto compare = [&](size_t i, size_t j) {
        if (pupil.amplitude[i] > 0 && pupil.amplitude[j] > 0)
            steepest = std::max(steepest, std::fabs(pupil.opd_m[i] - mask[i] - (pupil.opd_m[j] - mask[j])));
    };
    for (size_t i = 0; i + 1 < n * n; i++) {
        if ((i + 1) % n != 0)
            compare(i, i + 1);
        if (i + n < n * n)
            compare(i, i + n);
    }
    return steepest;
}

// k dE/dk = A i k OPD exp(i k OPD), k = 2 pi/lambda; of a mixed cell, with the OPD d outside the mask's step s,
//     k d/dk A ((1 - c) exp(i k d) + c exp(i k (d + s))) = A exp(i k d) i k (d (1 - c) + (d + s) c exp(i k s)).
void wavenumber_field(const Pupil &pupil, double wavenumber, double *amplitude, double *opd_m) noexcept {
    const double k = 2 * kPi * wavenumber;
    for (size_t i = 0; i < pupil.opd_m.size(); i++) {
        amplitude[i] = pupil.amplitude[i] * std::fabs(k * pupil.opd_m[i]);
        opd_m[i] = pupil.opd_m[i] + (pupil.opd_m[i] < 0 ? -0.25 : 0.25) / wavenumber;
    }
    double cosine, sine;
    kernels::cis_cycles(kernels::reduce_cycles(pupil.step_m * wavenumber), cosine, sine);
    for (const MixedCell &cell : pupil.mixed) {
        const double outside = pupil.opd_m[cell.index] - cell.covered * pupil.step_m,
                     covered = (outside + pupil.step_m) * cell.covered;
        const double real = -k * covered * sine, imaginary = k * (outside * (1 - cell.covered) + covered * cosine);
        amplitude[cell.index] = pupil.amplitude[cell.index] * std::hypot(real, imaginary);
        opd_m[cell.index] = outside + std::atan2(imaginary, real) / k;
    }
}

} // namespace

Pupil make_pupil(const Scene &scene, size_t samples) {
    const Telescope &telescope = scene.telescope;
    const size_t n = samples;
    const Opening opening(telescope);
    const double cell = telescope.aperture_m / static_cast<double>(n), radius = telescope.aperture_m / 2;
    Pupil pupil;
    pupil.samples = n;
    pupil.aperture_m = telescope.aperture_m;
    pupil.amplitude.resize(n * n);
    pupil.opd_m.resize(n * n);
    for_each_cell(n, [&](size_t i, double x, double y) {
        pupil.amplitude[i] = open_fraction(opening, x * radius, y * radius, cell);
        pupil.area += pupil.amplitude[i];
    });
    if (!(pupil.area >= 1))
        fail(Status::scene, "%s: {telescope}: secondary and struts leave less than one pupil sample open",
             scene.source.c_str());
    add_amplitude(scene, pupil);
    add_mask(scene, pupil);
    const Buffer<double> mask = pupil.opd_m;
    add_aberrations(scene, pupil);
    pupil.steepest_m = steepest_of(pupil, mask);
    pupil.defocus.resize(n * n);
    for_each_cell(n, [&](size_t i, double x, double y) {
        pupil.defocus[i] = pupil.amplitude[i] > 0 ? kernels::zernike(4, x, y) : 0;
    });
    return pupil;
}

double open_area_m2(const Pupil &pupil) noexcept {
    const double cell = pupil.aperture_m / static_cast<double>(pupil.samples);
    return pupil.area * (cell * cell);
}

std::vector<double> opd_of_file(const Scene &scene, size_t samples) {
    const std::string &path = scene.telescope.opd_file;
    if (path.empty())
        return {};
    return read_map(scene, "aberrations.opd_file", path, samples, scene::within(-kLargestOpd, kLargestOpd, "m"));
}

Mode zernike_mode(const Pupil &pupil, int noll) {
    Mode mode;
    mode.opd_m.resize(pupil.samples * pupil.samples);
    for_each_cell(pupil.samples, [&](size_t i, double x, double y) {
        mode.opd_m[i] = pupil.amplitude[i] > 0 ? 1e-9 * kernels::zernike(noll, x, y) : 0;
    });
    return mode;
}

Mode mask_mode(const Scene &scene, const Pupil &pupil, MaskMotion motion) {
    constexpr double kSmallAngle = 1e-4, kSmallShift = 1e-9; // deg; apertures
    const auto covered_at = [&](double by) {
        Mask mask = scene.telescope.mask;
        (motion == MaskMotion::rotation ? mask.rotation_deg : mask.shift_m[motion == MaskMotion::shift_y]) += by;
        return covered_fractions(mask, pupil.aperture_m, pupil.samples, pupil.mixed);
    };
    const double step = motion == MaskMotion::rotation ? kSmallAngle : kSmallShift * pupil.aperture_m;
    const std::vector<double> before = covered_at(-step), after = covered_at(step);
    Mode mode;
    mode.step_m = scene.telescope.mask.step_m();
    for (size_t i = 0; i < before.size(); i++)
        if (after[i] != before[i])
            mode.cells.push_back({pupil.mixed[i].index, pupil.mixed[i].covered, (after[i] - before[i]) / (2 * step)});
    return mode;
}

// dE = A exp(i k OPD_0) c' (exp(i k s) - 1) = A exp(i k (OPD - c s)) c' 2 i sin(k s/2) exp(i k s/2), with the covered
// fraction c, the step s and k = 2 pi/lambda; the pupil's OPD has c s in the mean.
void field_of(const Pupil &pupil, const Mode &mode, double wavenumber, double *amplitude, double *opd_m) noexcept {
    double cosine, sine;
    if (mode.of_wavenumber)
        return wavenumber_field(pupil, wavenumber, amplitude, opd_m);
    kernels::cis_cycles(kernels::reduce_cycles(0.5 * mode.step_m * wavenumber), cosine, sine);
    for (const Mode::Cell &cell : mode.cells) {
        const double factor = 2 * sine * cell.rate;
        amplitude[cell.index] = pupil.amplitude[cell.index] * std::fabs(factor);
        opd_m[cell.index] =
            pupil.opd_m[cell.index] + (0.5 - cell.covered) * mode.step_m + (factor < 0 ? -0.25 : 0.25) / wavenumber;
    }
}

// The cells kept are off the centre by half a cell, which changes only the phase of the focal field.
Pupil halved(const Pupil &pupil) {
    const size_t n = pupil.samples, h = (n + 1) / 2;
    Pupil result;
    result.samples = h;
    result.aperture_m = pupil.aperture_m * static_cast<double>(2 * h) / static_cast<double>(n);
    result.area = pupil.area / 4;
    for (Buffer<double> *map : {&result.amplitude, &result.opd_m})
        map->resize(h * h);
    for (size_t row = 0; row < h; row++)
        for (size_t col = 0; col < h; col++) {
            result.amplitude[row * h + col] = pupil.amplitude[2 * (row * n + col)];
            result.opd_m[row * h + col] = pupil.opd_m[2 * (row * n + col)];
        }
    for (const MixedCell &cell : pupil.mixed)
        if (cell.index / n % 2 == 0 && cell.index % n % 2 == 0)
            result.mixed.push_back({cell.index / n / 2 * h + cell.index % n / 2, cell.covered});
    result.step_m = pupil.step_m;
    return result;
}

void resolve_mixed(const Pupil &pupil, double wavenumber, double *amplitude, double *opd_m) noexcept {
    double cosine, sine;
    kernels::cis_cycles(kernels::reduce_cycles(pupil.step_m * wavenumber), cosine, sine);
    for (const MixedCell &cell : pupil.mixed) {
        const double real = 1 - cell.covered + cell.covered * cosine, imaginary = cell.covered * sine;
        amplitude[cell.index] = pupil.amplitude[cell.index] * std::hypot(real, imaginary);
        opd_m[cell.index] = pupil.opd_m[cell.index] - cell.covered * pupil.step_m +
                            std::atan2(imaginary, real) / (2 * kPi * wavenumber);
    }
}

} // namespace toliman::optics
