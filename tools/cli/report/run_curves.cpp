#include "report/run_curves.hpp"

#include <algorithm>
#include <cmath>

#include "common/input.hpp"
#include "common/text.hpp"
#include "frames/frame_loop.hpp"
#include "report/curves.hpp"
#include "report/words.hpp"
#include "series/fap.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

constexpr size_t kMostDots = 3000;
constexpr double kMostSpreads = 4.2; // of the axis on either side
constexpr size_t kMeansAPeriod = 24, kMeansOfTruth = 48, kMeansWithoutPeriod = 72;

// Of each frame.
struct RunSeries {
    Numbers t, truth, latent, estimate;
};

RunSeries read_run_series(const std::string &path) {
    Series latent = read_series(path, {"t", "latent"});
    return {std::move(latent.t), column_of(path, "t", "true"), std::move(latent.y), column_of(path, "t", "template")};
}

// How the series are drawn.
struct View {
    TimeAxis axis;
    size_t means = kMeansWithoutPeriod;
    std::string of_means, of_axis = "time, days"; // words on the figure
    std::string remark;                           // of its caption
    ShortUnit px;                                 // of all values
    double spread = 1;                            // of a frame's value in it, at least a quarter of the truth
    double uas = 0;                               // microarcsec of it, 0 unknown
};

// Whether the period found is that of the signal, as `experiment` counts it.
bool is_right(const ResultFile &result) {
    constexpr double most = 0.05;
    return has_signal(result) && is_significant(result) &&
           std::fabs(result.number("period_days") / result.number("true_period_days") - 1) < most;
}

void set_unit(View &view, const ResultFile &result, const RunSeries &series) {
    const auto [low, high] = std::minmax_element(series.truth.begin(), series.truth.end());
    const double spread = std::max({deviation(series.latent), deviation(series.estimate), (*high - *low) / 8});
    view.px = short_unit({kMostSpreads * spread}, "px");
    view.spread = spread > 0 ? spread * view.px.factor : 1;
    if (has_signal(result))
        view.uas = result.number("amplitude_uas") / result.number("amplitude_px") / view.px.factor;
}

// In the unit of the figure, about the mean.
Numbers shown(Numbers values, const View &view) {
    const double centre = mean(values);
    for (double &value : values)
        value = (value - centre) * view.px.factor;
    return values;
}

View view_of(const ResultFile &result, const RunSeries &series) {
    const Numbers &t = series.t;
    View view;
    set_unit(view, result, series);
    const double truth = has_signal(result) ? result.number("true_period_days") : 0;
    const double period = is_right(result) ? result.number("period_days") : truth;
    const double cycles = (t.back() - t.front()) / period;
    view.axis = time_axis(t, period, kMeansAPeriod);
    view.of_means = truth > 0 ? printed("mean over 1/%zu of a period", kMeansAPeriod)
                              : printed("mean over 1/%zu of the time", kMeansWithoutPeriod);
    if (view.axis.folded) {
        view.means = kMeansAPeriod;
        view.of_axis = printed("phase, days of the %s period", is_right(result) ? "found" : "true");
        view.remark = printed(" Folded: all %.0f periods lie over one, ", cycles) +
                      (is_right(result) ? "that found, " + period_text(result, period) + " days"
                                        : printed("the true one, %g days", period)) +
                      ", each frame at its phase.";
    } else if (truth > 0) {
        view.means = static_cast<size_t>(std::max(1.0, cycles * kMeansAPeriod));
    }
    return view;
}

// None without signal. Along time as it is; folded over its own period, as wide as the axis, and once more on either
// side.
Means truth_of(const ResultFile &result, const RunSeries &series, const View &view) {
    if (!has_signal(result))
        return {};
    const TimeAxis &axis = view.axis;
    const Numbers truth = shown(series.truth, view);
    if (!axis.folded)
        return {thinned(axis.x, kMostDots), thinned(truth, kMostDots)};
    const double own = result.number("true_period_days");
    const Means once = means_of(time_axis(series.t, own, INFINITY), truth, kMeansOfTruth);
    Means thrice;
    for (const double turn : {-1, 0, 1})
        for (size_t i = 0; i < once.x.size(); i++) {
            thrice.x.push_back((once.x[i] / own + turn) * axis.last);
            thrice.y.push_back(once.y[i]);
        }
    return thrice;
}

std::string series_plot(const std::string &what, const Numbers &values, const Means &truth, const View &view, size_t i,
                        const Figure &figure) {
    constexpr double right = 72; // px for the right axis
    const Numbers scaled = shown(values, view);
    const Numbers dots_x = thinned(view.axis.x, kMostDots), dots = thinned(scaled, kMostDots);
    const Means averages = means_of(view.axis, scaled, view.means);
    const std::string number = std::to_string(i);
    std::string blocks =
        data_block("dots" + number, {&dots_x, &dots}) + data_block("means" + number, {&averages.x, &averages.y});
    std::string plots = printed("$dots%zu using 1:2 with points pt 7 ps 0.25 lc rgb '#9db8cf' title 'each frame', ", i);
    if (!truth.x.empty()) {
        blocks += data_block("truth" + number, {&truth.x, &truth.y});
        plots += printed("$truth%zu using 1:2 %swith lines lw 1.5 lc rgb '#d55e00' title 'truth', ", i,
                         view.axis.folded ? "smooth csplines " : "");
    }
    plots += printed("$means%zu using 1:2 with linespoints pt 7 ps 0.4 lw 1.2 lc rgb '#0072b2' title ", i) +
             gnuplot_text(view.of_means);
    const std::string right_axis =
        view.uas > 0 ? printed("set link y2 via y*%.10g inverse y/%.10g\nset y2tics\nset y2label 'microarcsec'\n",
                               view.uas, view.uas)
                     : "";
    return blocks + (view.uas > 0 ? stacked(i, 2, figure, right) : stacked(i, 2, figure)) + right_axis +
           (i == 0 ? "unset xlabel\nset format x ''\n"
                   : "set xlabel " + gnuplot_text(view.of_axis) + "\nset format x '%g'\n") +
           "set ylabel " + gnuplot_text(what + ", " + view.px.name) + "\n" +
           printed("plot [%.10g:%.10g][%.10g:%.10g] ", view.axis.first, view.axis.last, -kMostSpreads * view.spread,
                   (kMostSpreads + 0.6) * view.spread) +
           plots + "\n";
}

void add_series(const ResultFile &result, const RunSeries &series, Page &page) {
    const View view = view_of(result, series);
    const Means truth = truth_of(result, series, view);
    Figure figure = {
        "series", "", 520, "set key horizontal top right samplen 1.5\nset samples 1000\nset multiplot\n", {}};
    figure.caption = "The network's latent of each frame and the template's value, each less its mean";
    figure.caption += has_signal(result)
                          ? ", and the truth likewise, which has no noise. Its amplitude is " +
                                scientific(result.number("amplitude_px") / result.number("latent_sigma_px")) +
                                " of the scatter of the latent without signal."
                          : ".";
    figure.caption += view.remark + thinning_remark(series.t.size(), kMostDots);
    figure.script += series_plot("latent", series.latent, truth, view, 0, figure) +
                     series_plot("template", series.estimate, truth, view, 1, figure) + "unset multiplot\n";
    page.add(std::move(figure));
}

void add_periodograms(const std::string &folder, const ResultFile &result, Page &page) {
    const std::string path = folder + "/periodogram.csv";
    const double period = result.number("period_days"), fwhm = result.number("fwhm_period_days");
    Series latent = read_series(path, {"frequency", "power"});
    std::vector<PowerCurve> curves(1);
    curves[0] = {"network's latents",
                 latent.t,
                 latent.y,
                 1 / period,
                 fwhm / (period * period),
                 result.number_or("power_at_fap_1e-3", NAN),
                 period_text(result, period) + " days"};
    const std::vector<std::string> header = header_of(path);
    if (std::find(header.begin(), header.end(), "template") != header.end()) {
        const double other = result.number("template.period_days"),
                     other_fwhm = result.number_or("template.fwhm_period_days", NAN);
        curves.push_back({"template's values", latent.t, column_of(path, "frequency", "template"), 1 / other,
                          other_fwhm / (other * other), curves[0].level, period_text(result, other) + " days"});
    }
    add_power_figure("periodogram",
                     "Lomb-Scargle power on the grid, of each of many narrow intervals the highest. Network: peak "
                     "at " +
                         period_text(result, period) + " days" + ", full width at half maximum " +
                         fixed(fwhm, decimals_of(fwhm)) + " days, log<sub>10</sub> FAP " +
                         fixed(result.number("log10_fap"), 1) + "; the least-squares error of the period is " +
                         fixed(result.number("period_error_days"), decimals_of(result.number("period_error_days"))) +
                         " days. Noise alone exceeds the dashed line once in a thousand series.",
                     "1/day", curves, page);
}

void add_training(const std::string &folder, const ResultFile &result, Page &page) {
    const Series training = read_series(folder + "/training.csv", {"step", "loss"});
    Figure figure = {"training", "", 320, "", {}};
    figure.caption =
        "Loss of training: the part of the derivative image that the network's own does not hold, after each "
        "of " +
        printed("%zu", training.t.size()) + " steps; at the end " + scientific(training.y.back()) + ", cosine " +
        fixed(result.number("cosine"), 4) + ".";
    figure.script = data_block("loss", {&training.t, &training.y}) + stacked(0, 1, figure) +
                    "set logscale y\nset xlabel 'step'\nset ylabel 'loss (no unit)'\nunset key\n" +
                    printed("plot $loss using 1:2 with lines lw 1.6 lc rgb '%s'\n", line_colour(0));
    page.add(std::move(figure));
}

} // namespace

std::string period_text(const ResultFile &result, double period) {
    return fixed(period, decimals_of(result.number("period_error_days")));
}

bool has_signal(const ResultFile &result) {
    return result.number("amplitude_px") != 0;
}

bool is_significant(const ResultFile &result) {
    return result.number("log10_fap") <= kSignificant;
}

void add_run_curves(const std::string &folder, const ResultFile &result, Page &page) {
    add_series(result, read_run_series(folder + "/series.csv"), page);
    add_periodograms(folder, result, page);
    if (exists(folder + "/training.csv"))
        add_training(folder, result, page);
}

} // namespace cli
