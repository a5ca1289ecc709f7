"""The section of `toliman run`: the period, the estimators, images, series and periodograms."""
from __future__ import annotations

import math
import pathlib

import numpy

from . import figures, glossary, results, run_chapter, run_images, run_simulation
from .figures import Power, Sinusoid
from .page import Page, add_provenance
from .results import Array, Result, Table
from .text import LOG_FAP, UNKNOWN, decimals_of, exponential, fixed, scaled, scientific, significant, with_error

CHAPTER = ("Delli Veneri et al., Periodic Astrometric Signal Recovery Through Convolutional Autoencoders, in "
           "Intelligent Astrophysics, Springer, 2021, doi:10.1007/978-3-030-65867-0_8")
_WORDS = {
    **glossary.BOUND,
    "network": "the autoencoder, trained on the scene and on no frame; its latent, one number per frame, is the "
               "separation in px",
    "template": "least-squares fit of the derivative image to a frame: the reference method, which reaches the bound",
    "fit": "maximum-likelihood fit of the forward model to a frame: places and fluxes of both stars and the background; it "
           "follows stars that move",
    "untrained network": "the network with random weights, on the frames with signal: a period that it finds needs no "
                         "training",
    "network, no signal": "the trained network on frames without a planet: its highest peak is noise",
    "fit, no signal": "the fit on frames without a planet: its highest peak is noise",
    "bank": "networks trained for the dates and sub-pixel places of the stars; that of the nearest place takes the residual "
            "of the fit with the separation at its prediction, and its latent is the separation minus the prediction, px",
    "bank, no signal": "the bank on frames without a planet: its highest peak is noise",
    "signal": "the true displacements: without noise, hence a FAP of almost 0",
    "the chapter": "the book chapter whose experiment the scene chapter repeats with a better mask: " + CHAPTER,
    "nuisances": "other parameters that change a frame: fluxes of both stars, shift in x and y, roll, scale, focus, "
                 "background",
    "decoder: cosine, gain": "similarity in shape and in size of the decoder's output for a latent and the derivative "
                             "image; 1 and 1 if they are equal",
    "mean squared error": "of the reconstruction: mean square of frame minus reconstruction, both scaled to 0..1; "
                          "mean of the first 110 frames, or of all if there are fewer; with noise alone it would be "
                          "the second number",
    "1 − MSSIM": "structural dissimilarity of frame and reconstruction (MSSIM: mean structural similarity); 0 if equal",
    **glossary.FAP, **glossary.FWHM, **glossary.PEAKS,
}
_CONTROL_WORDS = ("untrained network", "network, no signal", "fit, no signal", "bank, no signal")
_NETWORK_WORDS = ("network", "template", "signal", "untrained network", "network, no signal", "decoder: cosine, gain",
                  "mean squared error", "1 − MSSIM")
_FIT_WORDS = ("fit", "fit, no signal")
_BANK_WORDS = ("bank", "bank, no signal")


class _Run:
    """Numbers that several parts use."""

    def __init__(self, folder: pathlib.Path):
        self.folder = folder
        self.result = result = results.load(folder / "result.json", "toliman-run/2")
        self.amplitude = result.number("amplitude_px")
        self.true_period = result.number("true_period_days")
        self.period, self.error = result.number("period_days"), result.number("period_error_days")
        self.log10_fap = result.number("log10_fap")
        self.has_signal = self.amplitude != 0
        self.found = significant(self.log10_fap)
        self.has_network = result.find("estimator", "network") == "network"
        self.has_fit = result.has("fit")
        self.has_bank = result.has("bank")
        self.headline = "Network: fit" if self.has_network else \
            "Bank of networks: period" if self.has_bank else "Fit of each frame: period"

    @property
    def has_controls(self) -> bool:
        """Whether there are frames without signal and an untrained network."""
        return bool(self.result.find("controls", "full") != "none")

    @property
    def following(self) -> list[str]:
        """Estimators that follow moving stars."""
        return [name for name, there in (("bank", self.has_bank), ("fit", self.has_fit)) if there]

    @property
    def series_names(self) -> dict[str, str]:
        """Columns of series.csv with the values of the estimators, by title."""
        names = {"network (latents)": "latent", "template": "template"} if self.has_network else \
            {"bank (latents)": "latent"} if self.has_bank else {}
        return {**names, "fit": "fit"} if self.has_fit else names

    def explains(self, word: str) -> bool:
        """Whether the page uses this word."""
        return (self.has_controls or word not in _CONTROL_WORDS) and (self.has_network or word not in _NETWORK_WORDS) \
            and (self.has_fit or word not in _FIT_WORDS) and (self.has_bank or word not in _BANK_WORDS)

    @property
    def is_right(self) -> bool:
        """Whether the period found is that of the signal, as `toliman.experiment` decides it."""
        return self.has_signal and self.found and abs(self.period / self.true_period - 1) < 0.05

    def period_text(self, period: float, error: float) -> str:
        return with_error(period, error) if math.isfinite(error) else fixed(period, decimals_of(self.error))


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds the results of a run to the page."""
    run = _Run(folder)
    page.add("title", "toliman run: " + run.result.text("scene"))
    _add_summary(run, page)
    _add_estimators(run, page)
    if run.has_network:
        _add_chapter_table(run, page)
    page.add("heading", "The signal")
    _add_series(run, page)
    _add_periodograms(run, page)
    if run.has_bank:
        page.add("heading", "The bank of networks")
        _add_bank(run, page)
    page.add("heading", "Images")
    pictures, reason = run_simulation.simulate(folder, run.result)
    if pictures is None:
        page.add("text", f"No images: {reason}")
    else:
        images = run_images.Images(run.result, pictures)
        run_images.add(images, page)
        run_chapter.add(folder, images, page)
    if run.has_network and (folder / "training.csv").exists():
        page.add("heading", "Training")
        _add_training(run, page)
    page.explain({word: text for word, text in _WORDS.items() if run.explains(word)})


def _distance(value: float, error: float, truth: float) -> str:
    """How far a value is from the truth."""
    if not (error > 0 and math.isfinite(value)):
        return ""
    sigmas = (value - truth) / error
    return f"{fixed(abs(sigmas), 1)} sigma {'above' if sigmas > 0 else 'below'} the true value, {scientific(truth)}"


def _add_summary(run: _Run, page: Page) -> None:
    result = run.result
    text = ("Period found: " if run.found else "Highest peak: ") + with_error(run.period, run.error) + " days"
    if run.has_signal and run.found:
        text += f" ({_distance(run.period, run.error, run.true_period)})"
    text += f", {LOG_FAP} {fixed(run.log10_fap, 1)}." + ("" if run.found else " This is not a significant period.")
    page.add("found", text)
    if result.flag("at_edge"):
        page.add("text", "The peak is at the edge of the frequency grid: the period may be outside it.")
    text = f"{result.whole('frames')} frames, seed {result.whole('seed')}."
    if run.has_signal:
        error = result.number("fitted_amplitude_error_px")
        text += (f" Signal: amplitude {scientific(run.amplitude)} px ({scientific(result.number('amplitude_uas'))} "
                 f"µas), period {run.true_period:g} days. Fitted amplitude: "
                 f"{scaled(result.number('fitted_amplitude_px'), error)} px, "
                 f"{_distance(result.number('fitted_amplitude_px'), error, run.amplitude)} px.")
    page.add("text", text)
    add_provenance(page, result)


def _efficiency(run: _Run, sigma: float) -> str:
    defined = math.isfinite(run.result.number("efficiency"))
    return fixed(run.result.number("crb_projected_px") / sigma, 3) if defined and sigma > 0 else UNKNOWN


def _scatter_words(run: _Run) -> str:
    result = run.result
    if not run.has_controls:
        return ("Controls were left out (--controls none): without frames without signal, sigma and efficiency are "
                "unknown" + (", and there is no untrained network." if run.has_network else "."))
    text = (f"sigma: its standard deviation over {result.whole('no_signal.frames')} frames without signal. "
            "efficiency: the bound divided by sigma")
    if math.isfinite(result.number("efficiency")):
        return f"{text}, known to ± {fixed(result.number('efficiency_error'), 3)}: it may exceed 1 by chance."
    return text + "; not given, because the bound assumes photon noise, which these frames do not have."


def _row(run: _Run, name: str, sigma: float, efficiency: str, prefix: str) -> list[str]:
    """A row of the estimators, with the period and FAP of keys that begin with `prefix`."""
    period, error = (run.result.number(f"{prefix}{key}_days") for key in ("period", "period_error"))
    return [name, exponential(sigma), efficiency, run.period_text(period, error),
            fixed(run.result.number(prefix + "log10_fap"), 1)]


def _network_rows(run: _Run) -> list[list[str]]:
    result = run.result
    template = result.number("template.sigma_px")
    return [["Cramér-Rao bound", exponential(result.number("crb_projected_px")), "1", "", ""],
            _row(run, "network", result.number("latent_sigma_px"), fixed(result.number("efficiency"), 3), ""),
            _row(run, "template", template, _efficiency(run, template), "template.")]


def _fit_rows(run: _Run) -> list[list[str]]:
    result = run.result
    return [["bound of the fit", exponential(result.number("fit.bound_px")), "1", "", ""]] \
        + [_row(run, name, result.number(f"{name}.sigma_px"), fixed(result.number(f"{name}.efficiency"), 3), f"{name}.")
           for name in run.following]


def _add_bank(run: _Run, page: Page) -> None:
    """Latents against the fit, and efficiency, frame by frame."""
    result, table = run.result, Table(run.folder / "series.csv")
    t, latent, fit, efficiency = (table.numbers(name, finite=name == "t") for name in ("t", "latent", "fit", "efficiency"))
    kept: Array = numpy.isfinite(latent)
    figure = figures.bank(t[kept], latent[kept], fit[kept], efficiency[kept])
    page.add_figure("bank", figure, "Left: the latent of each frame against its fit; both measure the separation less its "
                    "prediction, and have most of their noise in common. Right: efficiency of the network for the state of "
                    "each frame: the bound over the standard deviation of the latent, from the model images. It is highest "
                    f"near the {result.whole('bank.dates')} dates, and the {result.whole('bank.places')} sub-pixel places, "
                    f"of the networks; at least {fixed(result.number('bank.least_efficiency'), 3)}, on average "
                    f"{fixed(result.number('bank.mean_efficiency'), 3)}. The dashed line, 0.95, is where a bank is renewed.")


def _control_rows(run: _Run) -> list[list[str]]:
    result, rows = run.result, []
    if run.has_network:
        untrained = result.number("untrained.sigma_px")
        rows += [["untrained network", exponential(untrained), _efficiency(run, untrained), "",
                  fixed(result.number("untrained.log10_fap"), 1)],
                 ["network, no signal", exponential(result.number("latent_sigma_px")), "", "",
                  fixed(result.number("no_signal.log10_fap"), 1)]]
    for name in run.following:
        rows.append([f"{name}, no signal", exponential(result.number(f"{name}.sigma_px")), "", "",
                     fixed(result.number(f"{name}.no_signal_log10_fap"), 1)])
    return rows


def _add_estimators(run: _Run, page: Page) -> None:
    result = run.result
    rows = (_network_rows(run) if run.has_network else []) + (_fit_rows(run) if run.has_fit else [])
    if run.has_controls:
        rows += _control_rows(run)
    page.add_table("Estimators: one number per frame (see Words). " + _scatter_words(run)
                   + (" The fit has a bound of its own: places, fluxes and background are free." if run.has_fit else ""),
                   ["", "sigma, px", "efficiency", "period, days", LOG_FAP], rows)
    rows = [["bound, all other parameters known, px", scientific(result.number("crb_px"))],
            ["bound, fluxes and common shift free, px", scientific(result.number("crb_flux_shift_px"))],
            ["bound, all eight nuisances free, px", scientific(result.number("crb_marginal_px"))]]
    rows += _network_properties(run) if run.has_network else []
    rows += _fit_properties(run) if run.has_fit else []
    page.add_table(f"The bound of one frame{'' if run.has_network else ' at time 0'}, and the estimators.", ["", ""], rows)
    _add_seconds(run, page)


def _network_properties(run: _Run) -> list[list[str]]:
    result = run.result
    defined = math.isfinite(result.number("efficiency"))
    squared = scientific(result.number("mmse"), 4)
    return [["cosine of encoder and ideal: the expected efficiency, no unit", fixed(result.number("cosine"), 4)],
            ["decoder: cosine, gain, no unit",
             f"{fixed(result.number('decoder.cosine'), 4)}, {fixed(result.number('decoder.gain'), 4)}"],
            ["mean squared error; noise alone, no unit" if defined else "mean squared error, no unit",
             squared + (f"; {scientific(result.number('photon_floor'), 4)}" if defined else "")],
            ["1 − MSSIM, no unit", scientific(1 - result.number("mssim"), 2)]]


def _fit_properties(run: _Run) -> list[list[str]]:
    result = run.result
    bank = [["bank: networks; smallest cosine of a gradient and the ideal one, no unit",
             f"{result.whole('bank.networks')}; {fixed(result.number('bank.least_cosine'), 4)}"]] if run.has_bank else []
    return bank + [["fit: chi-square per degree of freedom, mean, no unit", fixed(result.number("fit.chi_square"), 4)],
            ["fit: Gauss-Newton steps per frame; frames lost, no unit",
             f"{fixed(result.number('fit.iterations'), 1)}; {result.whole('fit.lost')}"]]


def _add_seconds(run: _Run, page: Page) -> None:
    result = run.result
    spent = [(name, result.number(f"timings.{key}_s")) for name, key in
             (("set-up", "setup"), ("training", "train"), ("frames", "simulate"), ("encoding", "encode"),
              ("fit", "fit"), ("period", "period"), ("controls", "controls"))
             if result.has(f"timings.{key}_s") and (run.has_network or key not in ("train", "encode"))
             or run.has_bank and key == "train"]
    page.add("text", f"Time: {fixed(result.number('timings.total_s'), 1)} s in total; "
             + ", ".join(f"{name} {fixed(seconds, 1)}" for name, seconds in spent) + ".")


def _half_width(value: float, half: float) -> str:
    decimals = decimals_of(half, 4)
    return f"{fixed(value, decimals)}; {fixed(half, decimals)}"


def _add_chapter_table(run: _Run, page: Page) -> None:
    """Table 1 of the chapter: periods in units of the time span."""
    result = run.result
    span = 1.5 / result.positive("grid.f0")
    rows = []
    for name, prefix, of_chapter in (("signal", "true_series.", "0.33; 0.05, FAP 0"),
                                     ("network (atom)", "", f"0.33; 0.06, {LOG_FAP} −67.1")):
        if prefix and not result.has("true_series"):
            continue
        rows.append([name, _half_width(result.number(prefix + "period_days") / span,
                                       result.number(prefix + "half_width_period_days") / span),
                     fixed(result.number(prefix + "log10_fap"), 1)] + ([of_chapter] if run.has_signal else []))
    page.add_table(
        f"Table 1 of the chapter: the period in units of the time span of {span:g} days; half the FWHM of the peak (a "
        f"width, not an error); {LOG_FAP}. The chapter calls the latent an atom."
        + (" The chapter's values are for three cycles and 10⁻⁶ px." if run.has_signal else ""),
        ["", "period; half width", LOG_FAP] + (["the chapter"] if run.has_signal else []), rows)


def _add_series(run: _Run, page: Page) -> None:
    result, table = run.result, Table(run.folder / "series.csv")
    kept: Array = numpy.isfinite(table.numbers("fit" if run.has_fit else "t", finite=False))
    t, truth = table.numbers("t")[kept], table.numbers("true")[kept]
    panels = {title: table.numbers(name, finite=not run.has_fit)[kept] for title, name in run.series_names.items()}
    uas = result.number("amplitude_uas") / run.amplitude if run.has_signal else 0.0
    period = run.period if run.is_right else run.true_period
    cycles = numpy.ptp(t) / period if period > 0 else 0
    step = figures.thinned(len(t))
    thinned = f" One of {step} frames is drawn." if step > 1 else ""
    *others, last = (title.partition(" (")[0] for title in panels)
    listed = f"the {', the '.join(others)} and the {last}" if others else f"the {last}"
    caption = "Values of each frame less their mean, for " + listed
    truth_words = f" The truth, in the same unit, is the displacement without noise{_noise(run)}." \
        if run.has_signal else ""
    if cycles <= figures.MOST_CYCLES:
        figure = figures.series(t, panels, truth if run.has_signal else None, uas, period if cycles else math.nan)
        page.add_figure("series", figure, f"{caption}, with means and their standard errors.{truth_words}{thinned}")
    if period > 0:
        which = "found" if run.is_right else "true"
        true_wave = _true_wave(run, t, truth) if run.has_signal else None
        fits = {next(iter(panels)): _fit(run)} if run.is_right else {}
        figure = figures.folded(t, panels, period, true_wave, uas, fits)
        shown = run.period_text(period, math.nan) if run.is_right else f"{period:g}"
        page.add_figure("folded", figure, f"The same folded: all {cycles:.1f} cycles over one period, the {which} one, "
                        f"{shown} days, each frame at its phase.{truth_words}{thinned}")


def _noise(run: _Run) -> str:
    if not run.has_controls:
        return ""
    has_latents = run.has_network or run.has_bank
    sigma = run.result.number("latent_sigma_px" if has_latents else "fit.sigma_px")
    value = "latent" if has_latents else "value"
    return f": its amplitude is {scientific(run.amplitude / sigma)} of the scatter of one {value} without signal"


def _true_wave(run: _Run, t: Array, truth: Array) -> Sinusoid:
    """The sinusoid of the true displacements, from the displacements themselves."""
    angle = 2 * numpy.pi * (t - t.min()) / run.true_period
    columns = numpy.stack([numpy.sin(angle), numpy.cos(angle), numpy.ones(len(t))], axis=1)
    sine, cosine, offset = numpy.linalg.lstsq(columns, truth, rcond=None)[0]
    return Sinusoid(math.hypot(sine, cosine), run.true_period, math.atan2(cosine, sine), offset, float(t.min()))


def _fit(run: _Run) -> Sinusoid:
    result = run.result
    return Sinusoid(result.number("fitted_amplitude_px"), run.period, result.number("fitted_phase_rad"),
                    result.number("fitted_offset_px"), result.number("fitted_time_offset_days"))


def _power(name: str, frequency: Array, values: Array, result: Result, prefix: str, level: float = math.nan) -> Power:
    """A periodogram with the marks of keys of the result that begin with `prefix`."""
    period = result.number(prefix + "period_days")
    error = result.number(prefix + "period_error_days", math.nan)
    return Power(name, frequency, values, float(frequency[int(values.argmax())]), 1 / period, error / period**2,
                 result.number(prefix + "fwhm_period_days") / period**2, level)


def _add_periodograms(run: _Run, page: Page) -> None:
    result, table = run.result, Table(run.folder / "periodogram.csv")
    frequency, level = table.numbers("frequency"), result.number("power_at_fap_1e-3")
    curves = []
    if run.has_network:
        curves += [_power("network's latents", frequency, table.numbers("power"), result, "", level),
                   _power("template's values", frequency, table.numbers("template"), result, "template.", level)]
    if run.has_bank:
        curves.append(_power("latents of the bank", frequency, table.numbers("power"), result, "bank.", level))
    if run.has_fit:
        curves.append(_power("values of the fit", frequency, table.numbers("fit"), result, "fit.", level))
    if result.has("true_series"):
        curves.insert(0, _power("true displacements", frequency, table.numbers("true"), result, "true_series."))
    figure = figures.periodogram(curves)
    if figure is None:
        page.add("text", "No figure of the periodogram: its grid does not have two frequencies above 0.")
        return
    page.add_figure("periodogram", figure, f"Lomb-Scargle periodograms. {run.headline} "
                                           f"{with_error(run.period, run.error)} "
                    f"days, FWHM {_two_digits(result.number('fwhm_period_days'))} days, {LOG_FAP} "
                    f"{fixed(run.log10_fap, 1)}. Noise alone exceeds the dashed line once in a thousand series.")


def _two_digits(value: float) -> str:
    return fixed(value, decimals_of(value))


def _add_training(run: _Run, page: Page) -> None:
    table = Table(run.folder / "training.csv")
    loss = table.numbers("loss")
    page.add_figure("training", figures.training(table.numbers("step"), loss),
                    f"Loss after each of {len(loss)} training steps: 1 − cosine² between the network's derivative "
                    "image and the exact one, 0 if they are equal in shape; at the end "
                    f"{scientific(float(loss[-1]))}. The cosine of the encoder, the efficiency that it predicts, is "
                    f"{fixed(run.result.number('cosine'), 4)}.")
