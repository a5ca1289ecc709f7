// Method: counts and variances are linear in the expected electrons m: counts = m/g + bias, variance = (m + added)/g^2.
// The ratio of their ranges is the gain g.
#include "frame/bad_pixels.hpp"

namespace toliman {

PixelNoise::PixelNoise(const Buffer<double> &reference, const Buffer<double> &variance) : tail(variance.size()) {
    size_t darkest = variance.size(), brightest = variance.size();
    for (size_t i = 0; i < variance.size(); i++) {
        if (!std::isfinite(variance[i]))
            continue;
        used++;
        if (darkest == variance.size() || reference[i] < reference[darkest])
            darkest = i;
        if (brightest == variance.size() || reference[i] > reference[brightest])
            brightest = i;
    }
    const double range = used > 0 ? variance[brightest] - variance[darkest] : 0;
    const double gain = range > 0 ? (reference[brightest] - reference[darkest]) / range : 1;
    for (size_t i = 0; i < variance.size(); i++) {
        const double inverse = 1 / (gain * gain * variance[i]); // 0 for a pixel that is not used
        inverse_counts += inverse;
        tail[i] = kBadPixelTail * std::sqrt(inverse);
    }
}

FrameGoodness frame_goodness(double chi_square, double sigma, double largest, size_t bad_pixels,
                             bool few_bad) noexcept {
    FrameGoodness out;
    static_cast<Goodness &>(out) = goodness_of(
        std::isfinite(chi_square) ? chi_square : std::numeric_limits<double>::infinity(), sigma, largest, kFrameSigmas);
    if (!few_bad)
        out.verdict = GoodnessVerdict::poor;
    out.bad_pixels = bad_pixels;
    return out;
}

} // namespace toliman
