// What `toliman run` left: images, series, periodograms, tables.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "report/curves.hpp"
#include "report/result_file.hpp"
#include "report/run_images.hpp"
#include "report/sections.hpp"
#include "report/words.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

constexpr size_t kMostDots = 3000;
constexpr double kMeansAPeriod = 24, kMostMeans = 400;

void add_facts(const ResultFile &result, Page &page) {
    page.add_title("toliman run: " + escaped(result.text("scene")));
    const double amplitude = result.number("amplitude_px");
    std::string text = printed("%.0f frames, seed %s, libtoliman %s. ", result.number("frames"),
                               result.digits("seed").c_str(), escaped(result.text("version")).c_str());
    if (amplitude != 0)
        text += "The signal: " + scientific(amplitude) + " px (" + scientific(result.number("amplitude_uas")) +
                " microarcsec) with a period of " + printed("%g", result.number("true_period_days")) + " days. ";
    const double fap = result.number("log10_fap");
    text += fap <= -2 ? "Found: <b>" : "Highest peak: <b>";
    text += fixed(result.number("period_days"), 2) + " &plusmn; " + fixed(result.number("period_error_days"), 2) +
            " days</b>, log<sub>10</sub> FAP " + fixed(fap, 1) + ".";
    if (fap > -2)
        text += " That is no significant period.";
    if (result.flag("at_edge"))
        text += " The peak stands at the edge of the grid, and the period may lie beyond.";
    page.add_text(text);
}

void add_figures_table(const ResultFile &result, Page &page) {
    const double crb = result.number("crb_projected_px");
    const auto over = [&](double sigma) { return fixed(crb / sigma, 3); };
    const double network = result.number("latent_sigma_px"), reference = result.number("template.sigma_px");
    const double untrained = result.number("untrained.sigma_px");
    const double efficiency = result.number("efficiency");
    page.add_table(
        printed("A number for each frame, by who makes it. sigma: its scatter over %.0f frames without signal; "
                "efficiency: the bound over sigma, here known to &plusmn; ",
                result.number("no_signal.frames")) +
            fixed(result.number("efficiency_error"), 3) + ", so that it may exceed 1 by chance.",
        {"", "sigma, px", "efficiency", "period, days", "log<sub>10</sub> FAP"},
        {{"Cram&eacute;r-Rao bound", scientific(crb), "1", "", ""},
         {"network", scientific(network), fixed(efficiency, 3), fixed(result.number("period_days"), 2),
          fixed(result.number("log10_fap"), 1)},
         {"template", scientific(reference), std::isfinite(efficiency) ? over(reference) : fixed(NAN, 3),
          fixed(result.number("template.period_days"), 2), fixed(result.number("template.log10_fap"), 1)},
         {"untrained network", scientific(untrained), std::isfinite(efficiency) ? over(untrained) : fixed(NAN, 3), "",
          fixed(result.number("untrained.log10_fap"), 1)},
         {"network, no signal", scientific(network), "", "", fixed(result.number("no_signal.log10_fap"), 1)}});
    page.add_table(
        "The bound of one frame, and what the network painted.", {"", ""},
        {{"bound, all else known, px", scientific(result.number("crb_px"))},
         {"bound, fluxes and common shift free, px", scientific(result.number("crb_flux_shift_px"))},
         {"bound, all eight nuisances free, px", scientific(result.number("crb_marginal_px"))},
         {"cosine of encoder and ideal, the efficiency to expect", fixed(result.number("cosine"), 4)},
         {"decoder: cosine, gain",
          fixed(result.number("decoder.cosine"), 4) + ", " + fixed(result.number("decoder.gain"), 4)},
         {"MMSE of 110 frames at most; noise alone",
          scientific(result.number("mmse"), 4) + "; " + scientific(result.number("photon_floor"), 4)},
         {"1 &minus; MSSIM", scientific(1 - result.number("mssim"), 2)},
         {"fitted amplitude, px", scientific(result.number("fitted_amplitude_px"))},
         {"seconds in all: set-up, training, frames, encoding, period",
          fixed(result.number("timings.total_s"), 1) + ": " + fixed(result.number("timings.setup_s"), 1) + ", " +
              fixed(result.number("timings.train_s"), 1) + ", " + fixed(result.number("timings.simulate_s"), 1) + ", " +
              fixed(result.number("timings.encode_s"), 1) + ", " + fixed(result.number("timings.period_s"), 1)}});
}

// Table 1 of the chapter, periods in units of the time span.
void add_table_1(const ResultFile &result, Page &page) {
    const double span = 1.5 / result.number("grid.f0");
    const auto row = [&](const std::string &name, double period, double half_width, double fap,
                         const std::string &chapter) {
        return std::vector<std::string>{name, fixed(period / span, 4) + " &plusmn; " + fixed(half_width / span, 4),
                                        fixed(fap, 1), power_of_ten(fap), chapter};
    };
    std::vector<std::vector<std::string>> rows;
    if (result.has("true_series"))
        rows.push_back(row("signal", result.number("true_series.period_days"),
                           result.number("true_series.period_half_width_days"), result.number("true_series.log10_fap"),
                           "0.33 &plusmn; 0.05, 0"));
    rows.push_back(row("network (atom)", result.number("period_days"), result.number("period_half_width_days"),
                       result.number("log10_fap"), "0.33 &plusmn; 0.06, 7.2 &times; 10<sup>&minus;68</sup>"));
    page.add_table(
        "Table 1 as the chapter has it: the period in units of the time span of " + printed("%g", span) +
            " days, with half the width of the peak at half its height, and the false alarm probability. The "
            "chapter's column is for three cycles and 10<sup>&minus;6</sup> px.",
        {"", "period", "log<sub>10</sub> FAP", "FAP", "the chapter"}, rows);
}

struct RunSeries {
    Numbers t, truth, latent, estimate;
};

RunSeries read_run_series(const std::string &path) {
    Series latent = read_series(path, {"t", "latent"});
    return {std::move(latent.t), column_of(path, "t", "true"), std::move(latent.y), column_of(path, "t", "template")};
}

std::string series_plot(const std::string &what, const Numbers &t, const Numbers &values, const RunSeries &series,
                        size_t means, size_t i, const Figure &figure) {
    const Numbers scaled = standardised(values);
    const Numbers dots_t = thinned(t, kMostDots), dots = thinned(scaled, kMostDots);
    const Means averages = means_of(t, scaled, means);
    const Numbers line_t = thinned(t, kMostDots), line = thinned(standardised(series.truth), kMostDots);
    const std::string number = std::to_string(i);
    return data_block("dots" + number, {&dots_t, &dots}) + data_block("means" + number, {&averages.t, &averages.y}) +
           data_block("truth" + number, {&line_t, &line}) + stacked(i, 2, figure) +
           (i == 0 ? "unset xlabel\nset format x ''\n" : "set xlabel 'time, days'\nset format x '%g'\n") +
           "set ylabel " + gnuplot_text(what + ", standard deviations") + " noenhanced\n" +
           printed(
               "plot [%.10g:%.10g][-4.2:4.8] $dots%zu using 1:2 with points pt 7 ps 0.25 lc rgb '#9db8cf' title 'each "
               "frame', $truth%zu using 1:2 with lines lw 1.5 lc rgb '#d55e00' title 'truth', $means%zu using 1:2 with "
               "linespoints pt 7 ps 0.4 lw 1.2 lc rgb '#0072b2' title 'mean over 1/%g of a period'\n",
               t.front(), t.back(), i, i, i, kMeansAPeriod);
}

void add_series(const ResultFile &result, const RunSeries &series, Page &page) {
    const double span = series.t.back() - series.t.front(), period = result.number("true_period_days");
    const double cycles = period > 0 ? span / period : 3;
    const size_t means = static_cast<size_t>(std::clamp(cycles * kMeansAPeriod, 1.0, kMostMeans));
    Figure figure = {"series", "", 520, "set key horizontal top right samplen 1.5\nset multiplot\n", {}};
    figure.caption = "The network's latent of each frame and the template's value, each less its mean and over its "
                     "standard deviation, and so the truth, which has no noise: its amplitude is " +
                     scientific(result.number("amplitude_px") / result.number("latent_sigma_px")) +
                     " of the latent's noise, and the smaller that is, the flatter the means lie.";
    if (series.t.size() > kMostDots)
        figure.caption += printed(" Of %zu frames every %zuth is drawn.", series.t.size(),
                                  (series.t.size() + kMostDots - 1) / kMostDots);
    figure.script += series_plot("latent", series.t, series.latent, series, means, 0, figure) +
                     series_plot("template", series.t, series.estimate, series, means, 1, figure) + "unset multiplot\n";
    page.add(std::move(figure));
}

// "363.11 days"
std::string days(double period) {
    return printed("%.2f days", period);
}

void add_periodograms(const std::string &folder, const ResultFile &result, Page &page) {
    const std::string path = folder + "/periodogram.csv";
    const double period = result.number("period_days"), fwhm = result.number("period_fwhm_days");
    Series latent = read_series(path, {"frequency", "power"});
    std::vector<PowerCurve> curves(1);
    curves[0] = {"network's latents",
                 latent.t,
                 latent.y,
                 1 / period,
                 fwhm / (period * period),
                 result.number_or("power_at_fap_1e-3", NAN),
                 days(period)};
    const std::vector<std::string> header = header_of(path);
    if (std::find(header.begin(), header.end(), "template") != header.end()) {
        const double other = result.number("template.period_days"),
                     other_fwhm = result.number_or("template.period_fwhm_days", NAN);
        curves.push_back({"template's values", latent.t, column_of(path, "frequency", "template"), 1 / other,
                          other_fwhm / (other * other), curves[0].level, days(other)});
    }
    page.add(
        power_figure("periodogram",
                     "Lomb-Scargle power on the grid, of each of many narrow intervals the highest. Network: peak at " +
                         days(period) + ", full width at half maximum " + fixed(fwhm, 1) +
                         " days, log<sub>10</sub> FAP " + fixed(result.number("log10_fap"), 1) +
                         "; the least-squares error of the period is " + fixed(result.number("period_error_days"), 2) +
                         " days. Noise alone exceeds the dashed line "
                         "once in a thousand series.",
                     "1/day", curves));
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

// Images need what older versions did not leave, and files that the scene names.
void try_images(const std::string &folder, const ResultFile &result, Page &page) {
    if (!exists(folder + "/scene.json") || !exists(folder + "/weights.tlmw") || !result.has("scene_folder")) {
        page.add_text("No images: the folder has no scene.json and weights.tlmw, which <code>toliman run</code> leaves "
                      "since 0.1.0; run it again.");
        return;
    }
    const uint64_t seed = std::strtoull(result.digits("seed").c_str(), nullptr, 10);
    try {
        add_run_images(folder, result.text("scene_folder"), seed, page);
    } catch (const toliman::error &error) {
        if (error.status() != TOLIMAN_E_NOT_FOUND)
            throw;
        page.add_text("No images: a file that the scene names is gone: " + escaped(error.what()));
    }
}

} // namespace

void add_run_section(const std::string &folder, Page &page, Progress &progress) {
    const ResultFile result(folder + "/result.json", "toliman-run/1");
    const RunSeries series = read_run_series(folder + "/series.csv");
    add_facts(result, page);
    add_figures_table(result, page);
    add_table_1(result, page);
    progress.show("report: images", 0.1);
    page.add_heading("Images");
    try_images(folder, result, page);
    progress.show("report: curves", 0.8);
    page.add_heading("The signal");
    add_series(result, series, page);
    add_periodograms(folder, result, page);
    if (exists(folder + "/training.csv"))
        add_training(folder, result, page);
}

} // namespace cli
