// Method: shift and downsample, which the book chapter warns of. A star is computed once, in the centre of the frame,
// with 5 samples per pixel and axis. Its image at another position is interpolated between these samples along the
// rows, linearly or by the cubic convolution of Keys (1981, IEEE Trans. ASSP 29, 1153), and every fifth sample is kept.
// The reference is the propagated image at that position. The star is 1/3 px off the grid, because almost no star of a
// scene is on it; the error of that constant shift is far above a signal of 1e-6 px. It cancels in the change of the
// image, whose error remains a fixed part of the signal.
#include "run/displacement_errors.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/single_star.hpp"

namespace cli {

namespace {

constexpr size_t kSide = 32, kOversampling = 5, kFineSide = kSide * kOversampling;
constexpr double kOffset = 1.0 / 3; // px, of the star
constexpr double kAccuracy = 1e-9;
constexpr double kDisplacements[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}; // px, the largest one first

using Image = std::vector<double>;
using Interpolation = double (*)(const double *sample, double t);

// Both interpolate between sample[0] and sample[1], at 0 <= t < 1.
double linear(const double *sample, double t) {
    return sample[0] + t * (sample[1] - sample[0]);
}

double cubic(const double *sample, double t) {
    const double slope0 = (sample[1] - sample[-1]) / 2, slope1 = (sample[2] - sample[0]) / 2;
    const double gap = sample[1] - sample[0];
    return sample[0] + t * (slope0 + t * (3 * gap - 2 * slope0 - slope1 + t * (slope0 + slope1 - 2 * gap)));
}

// The image of a star shifted by at most 1 px; the two outermost columns, which need samples beyond the frame, are 0. A
// sample holds the light of 1/25 px.
Image shifted(const Image &fine, double shift_px, Interpolation interpolate) {
    Image image(kSide * kSide);
    const double shift = shift_px * kOversampling, whole = std::floor(-shift);
    const auto step = static_cast<std::ptrdiff_t>(whole);
    for (size_t row = 0; row < kSide; row++)
        for (size_t col = 2; col + 2 < kSide; col++) {
            const size_t middle = kOversampling / 2;
            const double *sample = &fine[(row * kOversampling + middle) * kFineSide + col * kOversampling + middle];
            image[row * kSide + col] = kOversampling * kOversampling * interpolate(sample + step, -shift - whole);
        }
    return image;
}

// a - b without the two outermost columns.
Image difference(const Image &a, const Image &b) {
    Image image(a.size());
    for (size_t row = 0; row < kSide; row++)
        for (size_t i = row * kSide + 2; i + 2 < (row + 1) * kSide; i++)
            image[i] = a[i] - b[i];
    return image;
}

double largest(const Image &image) {
    double most = 0;
    for (const double pixel : image)
        most = std::max(most, std::fabs(pixel));
    return most;
}

// `fine`: the image of the star of `scene` with smaller pixels.
std::vector<DisplacementErrors> errors_of(const Scene &scene, const Image &fine) {
    const Image centred = light_fractions(scene, 0, true), still = light_fractions(scene, kOffset, true);
    std::vector<DisplacementErrors> all;
    for (const double displacement : kDisplacements) {
        const Image exact = light_fractions(scene, kOffset + displacement, true), change = difference(exact, still);
        const double signal = largest(change);
        const auto error = [&](Interpolation how) {
            return largest(difference(shifted(fine, kOffset + displacement, how), exact)) / signal;
        };
        const auto change_error = [&](Interpolation how) {
            const Image moved = difference(shifted(fine, kOffset + displacement, how), shifted(fine, kOffset, how));
            return largest(difference(moved, change)) / signal;
        };
        const Image ours = light_fractions(scene, displacement, true);
        const double taylor =
            largest(difference(light_fractions(scene, displacement, false), ours)) / largest(difference(ours, centred));
        all.push_back({displacement, error(linear), error(cubic), change_error(linear), change_error(cubic), taylor});
    }
    return all;
}

} // namespace

std::vector<DisplacementErrors> displacement_errors(const std::string &path, const cJSON *telescope, double min_nm,
                                                    double max_nm, double pixel_scale_arcsec) {
    SingleStar star = {min_nm, max_nm, kSide, pixel_scale_arcsec, kDisplacements[0], kAccuracy};
    try {
        const Scene scene = single_star(path, telescope, star);
        star.side = kFineSide;
        star.pixel_scale_arcsec /= kOversampling;
        star.amplitude_px = 0;
        return errors_of(scene, light_fractions(single_star(path, telescope, star)));
    } catch (const toliman::error &error) {
        if (error.status() != TOLIMAN_E_SCENE)
            throw;
        return {};
    }
}

} // namespace cli
