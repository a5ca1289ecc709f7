// What `toliman run` left: images, series, periodograms, tables.
#include <cmath>
#include <cstdlib>

#include "common/input.hpp"
#include "report/glossary.hpp"
#include "report/result_file.hpp"
#include "report/run_curves.hpp"
#include "report/run_images.hpp"
#include "report/sections.hpp"
#include "report/words.hpp"

namespace cli {

namespace {

const std::vector<Word> kWords = {
    kBoundWord,
    {"network", "the autoencoder, trained on the scene and no frame; its latent, the one number that it makes of a "
                "frame, is the separation in px"},
    {"template", "least squares of a frame on the image of what a displacement changes: the yardstick, at the bound"},
    {"untrained network", "the network with random weights: what it finds needs no training"},
    {"network, no signal", "the trained network on frames without planet: its highest peak is one of noise"},
    {"signal", "the true displacements themselves: they have no noise, hence a FAP of all but 0"},
    {"network (atom)", "the network's latents; atom is what the chapter calls the latent"},
    {"the chapter",
     "the book chapter of 2020 whose experiment the scene <code>chapter</code> repeats with a better mask"},
    {"nuisances", "what else changes in a frame: the fluxes of both stars, shift in x and y, roll, scale, focus, "
                  "background"},
    {"decoder: cosine, gain", "how like the derivative image is what the decoder paints for a latent, in shape and in "
                              "size: 1 and 1 where they are the same"},
    {"MMSE", "mean square of frame less reconstruction, both scaled to 0 to 1; the mean of the first 110 frames, or of "
             "all if there are fewer; at best that of noise alone"},
    {"1 &minus; MSSIM", "how unlike frame and reconstruction are in structure (mean structural similarity); 0 at best"},
    kFapWord,
    kFwhmWord,
};

void add_facts(const ResultFile &result, Page &page) {
    page.add_title("toliman run: " + escaped(result.text("scene")));
    const double amplitude = result.number("amplitude_px");
    std::string text = printed("%.0f frames, seed %s, libtoliman %s. ", result.number("frames"),
                               result.digits("seed").c_str(), escaped(result.text("version")).c_str());
    if (has_signal(result))
        text += "The signal: " + scientific(amplitude) + " px (" + scientific(result.number("amplitude_uas")) +
                " microarcsec) with a period of " + printed("%g", result.number("true_period_days")) + " days. ";
    const double fap = result.number("log10_fap");
    text += is_significant(result) ? "Found: <b>" : "Highest peak: <b>";
    text += with_error(result.number("period_days"), result.number("period_error_days")) +
            " days</b>, log<sub>10</sub> FAP " + fixed(fap, 1) + ".";
    if (!is_significant(result))
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
    const bool defined = std::isfinite(efficiency);
    page.add_table(
        printed("A number for each frame, by who makes it (see Words). sigma: its scatter over %.0f frames without "
                "signal; efficiency: the bound over sigma, ",
                result.number("no_signal.frames")) +
            (defined ? "here known to &plusmn; " + fixed(result.number("efficiency_error"), 3) +
                           ", so that it may exceed 1 by chance."
                     : "not given as the bound counts photon noise, which these frames do not have."),
        {"", "sigma, px", "efficiency", "period, days", "log<sub>10</sub> FAP"},
        {{"Cram&eacute;r-Rao bound", exponential(crb), "1", "", ""},
         {"network", exponential(network), fixed(efficiency, 3), period_text(result, result.number("period_days")),
          fixed(result.number("log10_fap"), 1)},
         {"template", exponential(reference), defined ? over(reference) : fixed(NAN, 3),
          period_text(result, result.number("template.period_days")), fixed(result.number("template.log10_fap"), 1)},
         {"untrained network", exponential(untrained), defined ? over(untrained) : fixed(NAN, 3), "",
          fixed(result.number("untrained.log10_fap"), 1)},
         {"network, no signal", exponential(network), "", "", fixed(result.number("no_signal.log10_fap"), 1)}});
    page.add_table(
        "The bound of one frame, and what the network painted.", {"", ""},
        {{"bound, all else known, px", scientific(result.number("crb_px"))},
         {"bound, fluxes and common shift free, px", scientific(result.number("crb_flux_shift_px"))},
         {"bound, all eight nuisances free, px", scientific(result.number("crb_marginal_px"))},
         {"cosine of encoder and ideal, the efficiency to expect", fixed(result.number("cosine"), 4)},
         {"decoder: cosine, gain",
          fixed(result.number("decoder.cosine"), 4) + ", " + fixed(result.number("decoder.gain"), 4)},
         {defined ? "MMSE; noise alone" : "MMSE",
          scientific(result.number("mmse"), 4) + (defined ? "; " + scientific(result.number("photon_floor"), 4) : "")},
         {"1 &minus; MSSIM", scientific(1 - result.number("mssim"), 2)},
         {"fitted amplitude, px", scientific(result.number("fitted_amplitude_px"))},
         {"seconds in all: set-up, training, frames, encoding, period, controls",
          fixed(result.number("timings.total_s"), 1) + ": " + fixed(result.number("timings.setup_s"), 1) + ", " +
              fixed(result.number("timings.train_s"), 1) + ", " + fixed(result.number("timings.simulate_s"), 1) + ", " +
              fixed(result.number("timings.encode_s"), 1) + ", " + fixed(result.number("timings.period_s"), 1) + ", " +
              fixed(result.number("timings.controls_s"), 1)}});
}

// Table 1 of the chapter, periods in units of the time span.
void add_table_1(const ResultFile &result, Page &page) {
    const double span = 1.5 / result.number("grid.f0");
    const bool comparable = has_signal(result); // the chapter's has
    std::vector<std::vector<std::string>> rows;
    const auto add_row = [&](const std::string &name, double period, double half_width, double fap,
                             const std::string &chapter) {
        rows.push_back({name, with_error(period / span, half_width / span, 4), fixed(fap, 1)});
        if (comparable)
            rows.back().push_back(chapter);
    };
    if (result.has("true_series"))
        add_row("signal", result.number("true_series.period_days"), result.number("true_series.half_width_period_days"),
                result.number("true_series.log10_fap"), "0.33 &plusmn; 0.05, FAP 0");
    add_row("network (atom)", result.number("period_days"), result.number("half_width_period_days"),
            result.number("log10_fap"), "0.33 &plusmn; 0.06, &minus;67.1");
    std::vector<std::string> heads = {"", "period", "log<sub>10</sub> FAP"};
    std::string caption =
        "Table 1 as the chapter has it: the period in units of the time span of " + printed("%g", span) +
        " days, with half the width of the peak at half its height, and log<sub>10</sub> of the false alarm "
        "probability.";
    if (comparable) {
        heads.push_back("the chapter");
        caption += " The chapter's column has both for three cycles and 10<sup>&minus;6</sup> px.";
    }
    page.add_table(caption, heads, rows);
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
    const ResultFile result(folder + "/result.json", "toliman-run/2");
    add_facts(result, page);
    add_figures_table(result, page);
    add_table_1(result, page);
    progress.show("report: images", 0.1);
    page.add_heading("Images");
    try_images(folder, result, page);
    progress.show("report: curves", 0.8);
    page.add_heading("The signal");
    add_run_curves(folder, result, page);
    page.explain(kWords);
}

} // namespace cli
