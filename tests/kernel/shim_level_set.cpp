// C interface of level sets, and of the removal of small features.
#include <algorithm>

#include "mask/features.hpp"
#include "mask/level_set.hpp"

using namespace toliman;
using namespace toliman::mask;

// Returned: covered [coarse][coarse], gradient [points][points] of sum weights * covered, cells [fine][fine], rms.
extern "C" double shim_level_set(int points, double smoothing, int fine, int coarse, int symmetry, double slope,
                                 const double *open, const double *heights, const double *weights, double *covered,
                                 double *gradient, unsigned char *cells) {
    const auto size = [](int side) { return static_cast<size_t>(side) * static_cast<size_t>(side); };
    LevelSet level(static_cast<size_t>(points), smoothing, static_cast<size_t>(fine), static_cast<size_t>(coarse),
                   {open, open + size(fine)}, static_cast<Symmetry>(symmetry));
    const double rms = level.set({heights, heights + size(points)});
    const Buffer<double> fractions = level.covered(slope);
    std::copy(fractions.begin(), fractions.end(), covered);
    const Buffer<double> slopes = level.gradient(slope, {weights, weights + size(coarse)});
    std::copy(slopes.begin(), slopes.end(), gradient);
    const Buffer<uint8_t> found = level.cells();
    std::copy(found.begin(), found.end(), cells);
    return rms;
}

// Returned: the fraction of the open cells in small features; cells without them, in place.
extern "C" double shim_small_features(int samples, int side, const double *open, unsigned char *cells) {
    const auto n = static_cast<size_t>(samples), square = static_cast<size_t>(side);
    const Buffer<uint8_t> given(cells, cells + n * n);
    const Buffer<double> opening(open, open + n * n);
    const Buffer<uint8_t> cleaned = without_small_features(given, n, square, opening);
    std::copy(cleaned.begin(), cleaned.end(), cells);
    return small_fraction(given, n, square, opening);
}
