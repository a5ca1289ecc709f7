#include "downlink/folder_goodness.hpp"

#include <cmath>

#include "common/library.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

constexpr double kTrendSigmas = 5; // beyond which a trend of chi-square is told,
constexpr double kChange = 3;      // and of a frame's chi-square, by which it has changed since the first frame
constexpr int64_t kLeastFrames = 20;
constexpr double kLeastYears = 0.05; // for which a trend per year is stated

bool has_trend(const toliman_track_goodness &goodness) noexcept {
    const double change = std::fabs(goodness.trend_per_year) * goodness.years;
    return goodness.frames >= kLeastFrames && change > kChange * goodness.chi_square_sigma &&
           std::fabs(goodness.trend_per_year) > kTrendSigmas * goodness.trend_sigma_per_year;
}

std::string calibration_text(const toliman_track_goodness &goodness) {
    return formatted("chi-square %.5g +- %.2g, %s", goodness.calibration_chi_square,
                     goodness.calibration_chi_square_sigma, toliman_constant_name(goodness.calibration_goodness));
}

} // namespace

toliman_track_goodness goodness_of(const toliman::tracker &tracker) {
    return toliman::result<toliman_track_goodness>(toliman_track_query_goodness, tracker.get());
}

std::string goodness_text(const toliman_track_goodness &goodness) {
    const auto number = [](int64_t value) { return static_cast<long long>(value); };
    std::string text = "  chi-square  ";
    if (std::isnan(goodness.chi_square))
        text += "of no frame is known";
    else if (goodness.frames == 0)
        text += formatted("median %.4g of misfits and outliers, %s: no frame is accepted; limit %.4g",
                          goodness.chi_square, toliman_constant_name(goodness.goodness), goodness.chi_limit);
    else
        text +=
            formatted("median %.4g of %lld frames, %s; %lld poor, %lld too good, %lld above the limit of %.4g",
                      goodness.chi_square, number(goodness.frames), toliman_constant_name(goodness.goodness),
                      number(goodness.poor), number(goodness.too_good), number(goodness.misfit), goodness.chi_limit);
    if (std::isfinite(goodness.trend_per_year) && goodness.years >= kLeastYears)
        text += formatted("\n              trend %+.2g +- %.2g per year%s", goodness.trend_per_year,
                          goodness.trend_sigma_per_year, has_trend(goodness) ? ": the model drifts" : "");
    if (goodness.cleaned > 0)
        text += formatted("\n  bad pixels  %lld in %lld frames, left out", number(goodness.bad_pixels),
                          number(goodness.cleaned));
    if (goodness.is_calibrated != 0)
        text += "\n  calibration " + std::string(goodness.is_complete != 0 ? "complete: " : "incomplete: ") +
                calibration_text(goodness);
    return text + "\n";
}

Json goodness_json(const toliman_track_goodness &goodness) {
    std::optional<Json> calibration;
    if (goodness.is_calibrated != 0)
        calibration.emplace("complete", goodness.is_complete != 0, "chi_square", goodness.calibration_chi_square,
                            "chi_square_sigma", goodness.calibration_chi_square_sigma, "goodness",
                            toliman_constant_name(goodness.calibration_goodness));
    return Json("frames", goodness.frames, "chi_square", goodness.chi_square, "chi_square_sigma",
                goodness.chi_square_sigma, "largest_residual", goodness.largest_residual, "goodness",
                toliman_constant_name(goodness.goodness), "trend_per_year", goodness.trend_per_year,
                "trend_sigma_per_year", goodness.trend_sigma_per_year, "poor", goodness.poor, "too_good",
                goodness.too_good, "misfit", goodness.misfit, "chi_limit", goodness.chi_limit, "bad_pixels",
                goodness.bad_pixels, "cleaned", goodness.cleaned, "calibration", std::move(calibration));
}

std::string model_complaint(const toliman_track_goodness &goodness) {
    std::string text;
    const auto add = [&text](const std::string &more) { text += (text.empty() ? "" : "; ") + more; };
    if (goodness.is_calibrated != 0 && goodness.is_complete == 0)
        add("the calibration of its scene is incomplete (" + calibration_text(goodness) + ")");
    if (goodness.goodness == TOLIMAN_GOODNESS_POOR)
        add(formatted(
            "the chi-square of its frames is %.4g, poor: the model lacks an effect, or the counts are damaged "
            "or in another unit: sigmas and values of the frames are not to be trusted",
            goodness.chi_square));
    if (goodness.goodness == TOLIMAN_GOODNESS_TOO_GOOD)
        add(formatted("the chi-square of its frames is %.4g, too good: the noise of the scene is too large; are the "
                      "frames in its unit?",
                      goodness.chi_square));
    if (has_trend(goodness))
        add(formatted("chi-square changes by %+.2g +- %.1g per year: the model drifts", goodness.trend_per_year,
                      goodness.trend_sigma_per_year));
    return text;
}

} // namespace cli
