#include "downlink/folder_facts.hpp"

#include "downlink/state_folder.hpp"
#include "series/fap.hpp"
#include "series/goodness.hpp"

namespace cli {

namespace {

using PeakMember = std::pair<const char *, double toliman_period_peak::*>;
constexpr PeakMember kPeak[] = {{"period", &toliman_period_peak::period},
                                {"fwhm_period", &toliman_period_peak::fwhm_period},
                                {"frequency", &toliman_period_peak::frequency},
                                {"power", &toliman_period_peak::power},
                                {"log10_fap", &toliman_period_peak::log10_fap}};
constexpr PeakMember kFit[] = {
    {"period", &toliman_period_peak::period},       {"period_error", &toliman_period_peak::period_error},
    {"amplitude", &toliman_period_peak::amplitude}, {"amplitude_error", &toliman_period_peak::amplitude_error},
    {"phase", &toliman_period_peak::phase},         {"offset", &toliman_period_peak::offset},
    {"log10_fap", &toliman_period_peak::log10_fap}};

template <size_t N>
void add_members(Json &json, const PeakMember (&members)[N], const std::optional<toliman_period_peak> &peak) {
    for (const auto &[name, member] : members)
        json.set(name, peak ? (*peak).*member : NAN);
}

// The peak that query(&peak) finds; nothing for too few frames, or values that are all equal.
template <class Query> std::optional<toliman_period_peak> peak_of(Query query) {
    auto peak = toliman::sized<toliman_period_peak>();
    const toliman_status status = query(&peak);
    if (status == TOLIMAN_E_STATE || status == TOLIMAN_E_RANGE)
        return std::nullopt;
    toliman::check(status);
    return peak;
}

std::string unit_text(double unit_ns) {
    constexpr double kDay = 86400e9;
    return unit_ns == kDay ? "d" : formatted("units of %g s", unit_ns * 1e-9);
}

constexpr double kTrendSigmas = 5; // beyond which a trend of chi-square is told,
constexpr double kChange = 3;      // and of a frame's chi-square, by which it has changed since the first frame

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

PeriodFacts::PeriodFacts(const toliman::tracker &tracker, Fit fit, Progress &progress) {
    const toliman_period *period = nullptr;
    toliman::check(toliman_track_get_period(tracker.get(), &period));
    const auto info = toliman::result<toliman_period_info>(toliman_period_get_info, period);
    count_ = info.count;
    unit_ = unit_text(info.unit_ns);
    peak_ = peak_of([&](toliman_period_peak *peak) { return toliman_period_query_peak(period, peak); });
    if (!peak_)
        return;
    const auto k = static_cast<int64_t>(std::lround((peak_->frequency - info.f0) / info.df));
    fitted_ = coefficients_at(period, k, element_columns(tracker));
    toliman::check(
        toliman_period_query_fap(period, TOLIMAN_PERIOD_FAP_SEQUENTIAL, peak_->log10_residual, &sequential_));
    if (fit != Fit::none)
        fit_ = peak_of([&](toliman_period_peak *peak) { return toliman_track_query_fit(tracker.get(), peak); });
    if (fit_ && !std::isfinite(fit_->period))
        fit_.reset();
    if (fit != Fit::none)
        aliases_ = aliases_of(period, fit_ ? fit_->frequency : peak_->frequency);
    if (fit == Fit::tested) {
        const toliman::measurements series = accepted_frames(tracker, TOLIMAN_SERIES_PLAIN_TIMES);
        const Noise noise({}, {}, series.get(), {info.f0, info.df, info.nf}, peak_->frequency, progress);
        if (noise.known())
            log10_p_white_ = noise.log10_p_white();
    }
}

void PeriodFacts::add_to(Json &json) const {
    std::optional<Json> fit;
    if (fit_)
        add_members(fit.emplace(), kFit, fit_);
    json.set("n", count_);
    add_members(json, kPeak, peak_);
    json.set("log10_fap_sequential", sequential_, "at_edge", peak_ && (peak_->flags & TOLIMAN_PERIOD_AT_EDGE) != 0,
             "fit", std::move(fit));
    set_flags(peak_ ? peak_->flags : 0, json);
    json.set("log10_p_white", log10_p_white_, "functions", if_known(!fitted_.all.empty(), json_of(fitted_)), "aliases",
             if_known(aliases_.has_value(), json_of(aliases_.value_or(Aliases{}))));
}

std::string PeriodFacts::functions_text() const {
    return fitted_.all.empty() ? "" : text_of(fitted_);
}

std::string PeriodFacts::aliases_text() const {
    return aliases_ && sequential_ <= kSignificant ? text_of(*aliases_) : "";
}

std::string PeriodFacts::text() const {
    if (!peak_ || !std::isfinite(peak_->log10_fap))
        return "no period yet";
    const toliman_period_peak &best = fit_ ? *fit_ : *peak_;
    return "period " + text_with_error(best.period, best.period_error) + " " + unit_ +
           formatted(", log10 FAP %.2f, sequential %.2f", best.log10_fap, sequential_) +
           (sequential_ > kSignificant ? ": no significant period" : flags_text(best.flags)) +
           (log10_p_white_ && *log10_p_white_ < Noise::kNotWhite
                ? formatted("; values are correlated (whiteness: log10 p = %.3g), so the FAP is too small",
                            *log10_p_white_)
                : "") +
           ((peak_->flags & TOLIMAN_PERIOD_INACCURATE) != 0 ? "; the power may be wrong by more than 0.001" : "");
}

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
            "the chi-square of its frames is %.4g, poor: the model lacks an effect%s, or the counts are damaged "
            "or in another unit: sigmas and values of the frames are not to be trusted",
            goodness.chi_square,
            goodness.is_calibrated != 0 ? "" : ", as its scene is not calibrated (toliman calibrate)"));
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
