#include "series/diagnosis.hpp"

#include "common/text.hpp"
#include "series/measure.hpp"

namespace cli {

namespace {

// hypotheses: NULL for the goodness only.
toliman_sky_diagnosis diagnose(const toliman_measure *measured, const toliman_sky *sky, double scale_sigma,
                               toliman_sky_hypothesis *hypotheses) {
    auto result = toliman::sized<toliman_sky_diagnosis>();
    toliman::check(toliman_sky_diagnose(sky, measured, scale_sigma, &result, hypotheses));
    return result;
}

} // namespace

std::optional<Json> diagnosis_of(const toliman_measure *measured, const toliman_sky *sky, double scale_sigma,
                                 Progress &progress) {
    if (info_of(measured).is_weighted == 0 ||
        diagnose(measured, sky, scale_sigma, nullptr).goodness != TOLIMAN_GOODNESS_POOR)
        return std::nullopt;
    std::vector<toliman_sky_hypothesis> hypotheses(TOLIMAN_SKY_HYPOTHESES, toliman::sized<toliman_sky_hypothesis>());
    const toliman_sky_diagnosis found = diagnose(measured, sky, scale_sigma, hypotheses.data());
    if (found.cause == TOLIMAN_SKY_CAUSE_NONE)
        return std::nullopt;
    const toliman_sky_hypothesis &cause = hypotheses[static_cast<size_t>(found.cause - TOLIMAN_SKY_CAUSE_TIME)];
    const std::string text = cause.text;
    progress.warn(text + (text.back() == '?' ? "" : ".") +
                  formatted(" The residuals about the orbit have a chi-square of %.3g per "
                            "degree of freedom; %.3g if this is true",
                            found.chi_square, cause.chi_square));
    return Json("cause", toliman_constant_name(found.cause), "text", cause.text, "value", cause.value, "sigma",
                cause.sigma, "chi_square_before", found.chi_square, "chi_square", cause.chi_square, "significance",
                cause.significance);
}

} // namespace cli
