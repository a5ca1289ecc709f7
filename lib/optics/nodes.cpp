#include "optics/nodes.hpp"

#include <algorithm>
#include <cmath>

#include "base/workers.hpp"
#include "optics/matrix_dft.hpp"

namespace toliman::optics {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr size_t kBeyondPhase = 24; // terms beyond the band's phase: the rest is below 1e-13
constexpr size_t kPoints = 16;      // per side of the grid, where the error is looked for
constexpr size_t kRough = 6;        // nodes that show the peak to a few per cent

// The band in 1/lambda, as its middle and half its width.
struct Band1 {
    double middle, reach;
};

Band1 band_of(const Light &light) noexcept {
    const double first = 1 / light.wavelength_m.front(), last = 1 / light.wavelength_m.back();
    return {0.5 * (first + last), 0.5 * (first - last)};
}

double node_angle(size_t j, size_t count) noexcept {
    return kPi * (static_cast<double>(j) + 0.5) / static_cast<double>(count);
}

// Phase in rad through which the intensity of the pixel farthest from a star turns between the middle and the ends of
// the band: pi D R (1/lambda_min - 1/lambda_max), R the angle between them.
double band_phase(const Pupil &pupil, const Light &light, const Grid &grid) noexcept {
    double farthest = 0;
    for (const auto &offset : light.offset_px)
        farthest = std::max(farthest, std::hypot(static_cast<double>(grid.cols) / 2 + std::fabs(offset[0]),
                                                 static_cast<double>(grid.rows) / 2 + std::fabs(offset[1])));
    return 2 * kPi * pupil.aperture_m * static_cast<double>(grid.pitch_rad) * farthest * band_of(light).reach;
}

// Values of the Lagrange polynomials of the nodes at x.
std::vector<double> lagrange(const std::vector<double> &nodes, const std::vector<double> &weights, double x) {
    std::vector<double> values(nodes.size(), 0.0);
    double sum = 0;
    for (size_t j = 0; j < nodes.size(); j++) {
        if (x == nodes[j]) {
            std::fill(values.begin(), values.end(), 0.0);
            values[j] = 1;
            return values;
        }
        values[j] = weights[j] / (x - nodes[j]);
        sum += values[j];
    }
    for (double &value : values)
        value /= sum;
    return values;
}

// Moments of the star's light, weighted by 1/lambda^2, in Chebyshev polynomials over the band.
std::vector<double> moments_of(const Light &light, size_t star, size_t count) {
    const Band1 band = band_of(light);
    std::vector<double> moments(count, 0.0);
    for (size_t i = 0; i < light.wavelength_m.size(); i++) {
        const double wavenumber = 1 / light.wavelength_m[i];
        const double weight = light.photons[star][i] * (wavenumber * wavenumber);
        const double angle = std::acos(std::clamp((wavenumber - band.middle) / band.reach, -1.0, 1.0));
        for (size_t k = 0; k < count; k++)
            moments[k] += weight * std::cos(static_cast<double>(k) * angle);
    }
    return moments;
}

// On so many nodes the polynomial of degree k looks like one of less degree, of this moment.
double aliased(const std::vector<double> &moments, size_t k, size_t nodes) noexcept {
    const size_t turns = (k + nodes) / (2 * nodes), whole = 2 * nodes * turns, rest = k > whole ? k - whole : whole - k;
    if (rest == nodes)
        return 0;
    return turns % 2 == 0 ? moments[rest] : -moments[rest];
}

// Chebyshev coefficients [count][rows * cols] of the intensity of one photon, less 1/lambda^2, over the band.
Buffer<double> coefficients_of(const Pupil &pupil, const Light &light, const Grid &grid, size_t star, size_t count,
                               unsigned workers) {
    const Band1 band = band_of(light);
    const size_t points = grid.rows * grid.cols;
    Buffer<double> intensity(count * points), coefficients(count * points);
    const long double offset[2] = {light.offset_px[star][0], light.offset_px[star][1]};
    run_jobs(workers, count, [&](size_t j) {
        const long double wavenumber = band.middle + band.reach * std::cos(node_angle(j, count));
        const auto step = static_cast<double>(step_of(pupil, grid, 1));
        MatrixDft dft(pupil, grid, 1);
        dft.transform(wavenumber, offset, {});
        double *const image = intensity.data() + j * points;
        dft.accumulate({{0, 0, 0, step * step / pupil.area}}, &image);
    });
    for (size_t k = 0; k < count; k++)
        for (size_t j = 0; j < count; j++) {
            const double factor = (k == 0 ? 1.0 : 2.0) / static_cast<double>(count) *
                                  std::cos(static_cast<double>(k) * node_angle(j, count));
            for (size_t i = 0; i < points; i++)
                coefficients[k * points + i] += factor * intensity[j * points + i];
        }
    return coefficients;
}

} // namespace

Light project_on_nodes(const Light &light, size_t count) {
    const Band1 band = band_of(light);
    Light result = light;
    std::vector<double> nodes(count), weights(count);
    result.wavelength_m.resize(count);
    for (size_t j = 0; j < count; j++) {
        const double angle = node_angle(j, count);
        result.wavelength_m[j] = 1 / (band.middle + band.reach * std::cos(angle));
        nodes[j] = std::cos(angle);
        weights[j] = (j % 2 == 0 ? 1 : -1) * std::sin(angle);
    }
    for (size_t star = 0; star < 2; star++) {
        if (light.photons[star].empty())
            continue;
        std::vector<double> &photons = result.photons[star];
        photons.assign(count, 0.0);
        // The image carries 1/lambda^2 besides what is band-limited: it goes with the weights.
        for (size_t i = 0; i < light.wavelength_m.size(); i++) {
            const double wavenumber = 1 / light.wavelength_m[i];
            const std::vector<double> share = lagrange(nodes, weights, (wavenumber - band.middle) / band.reach);
            for (size_t j = 0; j < count; j++)
                photons[j] += light.photons[star][i] * (wavenumber * wavenumber) * share[j];
        }
        for (size_t j = 0; j < count; j++)
            photons[j] *= result.wavelength_m[j] * result.wavelength_m[j];
    }
    return result;
}

double rough_peak(const Pupil &pupil, const Light &light, const Grid &grid, unsigned workers) {
    const Light rough = light.wavelength_m.size() > kRough ? project_on_nodes(light, kRough) : light;
    const Engine engine = [&](const Grid &, size_t fields) { return std::make_unique<MatrixDft>(pupil, grid, fields); };
    Buffer<double> both(grid.rows * grid.cols);
    for (size_t star = 0; star < 2; star++)
        if (!light.photons[star].empty()) {
            const StarImages images = propagate(engine, rough, grid, star, 0, Wanted(), workers);
            for (size_t i = 0; i < both.size(); i++)
                both[i] += images.at(0, 0)[i];
        }
    return *std::max_element(both.begin(), both.end());
}

std::vector<double> node_errors(const Pupil &pupil, const Light &light, const Grid &grid, unsigned workers) {
    const size_t count = static_cast<size_t>(std::ceil(band_phase(pupil, light, grid))) + kBeyondPhase;
    // The same field of view in few points; places are in units of the pitch.
    const double coarser = static_cast<double>(std::max<size_t>(std::max(grid.rows, grid.cols), 2) - 1) / (kPoints - 1);
    const Grid points = {kPoints, kPoints, grid.pitch_rad * coarser};
    Light placed = light;
    for (auto &offset : placed.offset_px)
        for (double &place : offset)
            place /= coarser;
    const double unit = static_cast<double>(grid.pitch_rad * grid.pitch_rad / (points.pitch_rad * points.pitch_rad));
    std::vector<double> errors(count, 0.0);
    for (size_t star = 0; star < 2; star++) {
        if (light.photons[star].empty())
            continue;
        const std::vector<double> moments = moments_of(light, star, count);
        const Buffer<double> coefficients = coefficients_of(pupil, placed, points, star, count, workers);
        for (size_t nodes = 1; nodes < count; nodes++) {
            std::vector<double> lost(kPoints * kPoints, 0.0);
            for (size_t k = nodes; k < count; k++)
                for (size_t i = 0; i < lost.size(); i++)
                    lost[i] += coefficients[k * lost.size() + i] * (moments[k] - aliased(moments, k, nodes));
            double worst = 0;
            for (const double value : lost)
                worst = std::max(worst, std::fabs(value));
            errors[nodes] += unit * worst;
        }
    }
    for (size_t nodes = count - 1; nodes-- > 1;) // what is better by chance does not count
        errors[nodes] = std::max(errors[nodes], errors[nodes + 1]);
    return errors;
}

} // namespace toliman::optics
