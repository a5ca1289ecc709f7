"""What the plot methods of the package draw: on axes of the user, in their style, or in a new figure of pyplot, in the
style of the report."""
from __future__ import annotations

import contextlib
import math
import typing

import numpy
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import _arguments, budget as budgets, calibration as calibrations, mask as masks, measure
from .. import periodogram as periodograms, planet as searches, sim
from . import calibration_figures, figures, images, mask_figures, planet_figures, style
from .results import Array
from .text import LOG_FAP, UNITS, fixed, short_unit, with_error

_LIMITS = 50  # periods of limits by default
_BARS = 8  # that fill the width of axes at least
_IMAGE_WIDTH = 5.5  # inch, of an image with its colour bar


@contextlib.contextmanager
def _new(height: float, rows: int = 1, columns: int = 1, width: float = style.WIDTH,
         **options: typing.Any) -> typing.Iterator[list[Axes]]:
    """A new figure of pyplot, with its axes row by row, in the style of the report; none if drawing fails."""
    with style.in_use():
        figure = pyplot.figure(figsize=(width, height))
        try:
            yield list(figure.subplots(rows, columns, squeeze=False, **options).flat)
        except BaseException:
            pyplot.close(figure)
            raise
        for axes in figure.axes:
            style.set_log_ticks(axes)


@contextlib.contextmanager
def _axes_of(ax: Axes | None, height: float, width: float = style.WIDTH) -> typing.Iterator[Axes]:
    """The axes of the user, or those of a new figure."""
    if ax is not None:
        if not isinstance(ax, Axes):
            raise TypeError(f"ax is a {type(ax).__name__}: must be one Axes of matplotlib")
        yield ax
        return
    with _new(height, width=width) as (axes,):
        yield axes


def _legend(ax: Axes | None) -> dict[str, typing.Any]:
    """Options of a legend: outside the axes only in a new figure."""
    return style.OUTSIDE if ax is None else {}


def _label(what: str, unit: str) -> str:
    return f"{what}, {unit}" if unit else f"{what} (no unit)"


def periodogram(view: periodograms.View, ax: Axes | None) -> Axes:
    """View.plot()"""
    frequency = view.frequency
    above = frequency[frequency > 0]
    if len(above) < 2:
        raise ValueError(f"this {view._name} has a grid with {len(above)} frequencies above 0: a plot needs 2")
    peak, unit = view.peak(), view._time_label()
    level = -math.expm1(math.log(10) * view.threshold(-3))
    curve = figures.Power("power", frequency, view.power(), peak.frequency, level=level,
                          fwhm=peak.fwhm if math.isfinite(peak.fwhm) else math.nan,
                          grid_error=peak.half_width_period * peak.frequency**2)
    low, high = float(above[0]), float(above[-1])
    with _axes_of(ax, 3.3) as axes:
        figures.draw_power(axes, curve, low, high, unit)
        figures.draw_frequencies(axes, axes, low, high, unit)
    return axes


def peak(found: periodograms.Peak, ax: Axes | None) -> Axes:
    """Peak.plot()"""
    samples = found._samples
    if samples is None:
        raise ValueError("this Peak has no series: call plot() of a Peak that toliman.period(t, y, dy) or "
                         "Periodogram.fit(t, y, sigma) returned")
    wave = figures.Sinusoid(found.amplitude, found.period, found.phase, found.offset, samples.time_offset)
    factor, unit = short_unit([found.amplitude, float(samples.y.std())], samples.value_label)
    with _axes_of(ax, 4.0) as axes:
        height = figures.draw_folded(axes, samples.t, samples.y, found.period, factor, fit=wave, each="each sample")
        axes.set_ylim(-2 * height or -1, 2.5 * height or 1)
        axes.set_ylabel(style.plain(_label("value less its mean", unit)))
        axes.set_title(f"period {with_error(found.period, found.period_error)} {samples.time_label}, {LOG_FAP} "
                       f"{fixed(found.log10_fap, 1)}", loc="left")
        axes.legend(loc="upper left", ncol=3)
    return axes


def measurements(series: measure.Measurements, ax: Axes | None) -> Axes:
    """Measurements.plot()"""
    t, y, sigma, info = series.t, series.y, series.sigma, series.info
    if len(t) == 0:
        raise ValueError("these Measurements are empty")
    names = info.instrument_names.strip(",").split(",") if info.instruments > 1 else [""]
    number = series.values("instrument") if info.instruments > 1 else numpy.zeros(len(t))
    step, unit = figures.thinned(len(t)), series._value_label()
    with _axes_of(ax, 3.6) as axes:
        for place, name in enumerate(names):
            of = numpy.flatnonzero(number == place)[::step]
            axes.errorbar(t[of], y[of], None if sigma is None else sigma[of], fmt="o", markersize=3, elinewidth=0.8,
                          color=style.CYCLE[place % len(style.CYCLE)], label=style.plain(name) or None)
        what = "reduced separation" if series.kind == "reduced" else series.kind
        axes.set_xlabel(f"time, {series._time_label()}")
        axes.set_ylabel(style.plain(_label(what, unit)))
        axes.ticklabel_format(axis="x", useOffset=False, style="plain")
        if step > 1:
            axes.set_title(f"one of {step} samples", loc="left")
        if len(names) > 1:
            axes.legend(**_legend(ax))
    return axes


def _finite(values: typing.Any) -> Array:
    """Returns an array of a calibration. ValueError if it did not converge."""
    array = numpy.asarray(values)
    if not numpy.isfinite(array).all():
        raise ValueError("this Calibration did not converge: its numbers are NaN, see verdict")
    return array


def calibration(found: calibrations.Calibration, ax: Axes | None, unit: str | None, window: int) -> Axes:
    """Calibration.plot()"""
    every = found.values(window)
    units = [value.unit for value in every.values()]
    chosen = max(dict.fromkeys(units), key=units.count, default="") if unit is None else unit
    values = {name: value for name, value in every.items() if value.unit == chosen}
    if not values:
        raise ValueError(f"unit = {chosen!r}: must be one of {', '.join(map(repr, dict.fromkeys(units)))}")
    changes, sigmas = (_finite([getattr(value, key) for value in values.values()]) for key in ("value", "sigma"))
    with _axes_of(ax, 3.4) as axes:
        calibration_figures.draw_bars(axes, list(values), changes, sigmas, chosen.replace("^2", "²"))
        margin = max(0.7, (_BARS - len(values)) / 2)
        axes.set_xlim(-margin, len(values) - 1 + margin)
        if ax is not None:  # which may be narrow
            axes.tick_params("x", rotation=90)
        axes.set_title("change against the nominal scene", loc="left")
    return axes


def _image(title: str, values: Array, unit: str, scale: str, axis_unit: str = "px", step: float = 1.0) -> images.Panel:
    """An image around the optical axis."""
    rows, columns = values.shape
    return images.Panel(title, values, -step * (columns - 1) / 2, -step * (rows - 1) / 2, step, unit, axis_unit, scale)


def _draw_image(panel: images.Panel, ax: Axes | None) -> Axes:
    with _axes_of(ax, images.height_of([panel]), _IMAGE_WIDTH) as axes:
        images.draw_images([axes], [panel])
    return axes


def calibration_opd(found: calibrations.Calibration, ax: Axes | None, window: int) -> Axes:
    """Calibration.plot_opd()"""
    opd = 1e9 * _finite(found.opd(window))
    return _draw_image(_image("pupil", numpy.where(opd == 0, numpy.nan, opd), "change of the OPD, nm", "difference",
                              "cells"), ax)


def calibration_residual(found: calibrations.Calibration) -> Figure:
    """Calibration.plot_residual()"""
    panels = [_image(name, _finite(found.residual(fitted)), f"residual {name}, σ of the pixel", "difference")
              for name, fitted in (("before", False), ("after", True))]
    with _new(images.height_of(panels), 1, 2) as axes:
        images.draw_images(axes, panels)
    return axes[0].figure


def calibration_correlations(found: calibrations.Calibration, ax: Axes | None, window: int) -> Axes:
    """Calibration.plot_correlations()"""
    names, covariance = list(found.values(window)), _finite(found.covariance(window))
    sigma = numpy.sqrt(numpy.diag(covariance))
    height = calibration_figures.height_of_correlations(names)
    with _axes_of(ax, height, min(style.WIDTH, height + 1.5)) as axes:
        calibration_figures.draw_correlations(axes, names, covariance / sigma / sigma[:, numpy.newaxis])
    return axes


class _Units:
    """Factors from the numbers of Planets to those of their plots, and names of units. size: of amplitudes."""

    def __init__(self, given: searches.Given, size: float):
        self.days, self.amplitude, self.unit = given.time_unit_days, 1e6 * given.unit_arcsec, "µas"
        if given.unit_arcsec == 0:
            self.amplitude, self.unit = short_unit([size], style.plain(given.unit))
        self.mass = "mass, Earths" if given.is_velocity else "mass on A, Earths"


def _candidate(found: searches.Planets, index: int) -> searches.Planet:
    candidates = found.candidates
    if not candidates:
        raise ValueError("these Planets have no candidate")
    return candidates[_arguments.whole("index", index, len(candidates))]


def corner(found: searches.Planets, index: int) -> Figure:
    """Planets.plot_corner()"""
    candidate, samples = _candidate(found, index), found.samples(index)
    units = _Units(found._given, candidate.amplitude[1])
    columns = [("period, days", units.days * samples["period"]), ("eccentricity", samples["eccentricity"]),
               (_label("amplitude", units.unit), units.amplitude * samples["amplitude"])]
    columns += [(label, samples[name]) for label, name in (
        (units.mass, "mass_a"), ("inclination, degrees", "inclination_deg")) if numpy.isfinite(samples[name]).all()]
    size = len(columns)
    with _new(2.0 * size, size, size) as axes:
        planet_figures.draw_corner(axes, columns)
    return axes[0].figure


def folded(found: searches.Planets, index: int, ax: Axes | None) -> Axes | Figure:
    """Planets.plot_folded()"""
    candidate, given = _candidate(found, index), found._given
    period, eccentricity, periastron_deg, epoch, amplitude = candidate.best
    units = _Units(given, amplitude)
    orbit = planet_figures.Orbit(period, eccentricity, math.radians(periastron_deg), epoch, units.amplitude * amplitude,
                                 given.is_velocity)
    signal = units.amplitude * found.signal(index, given.t, given.position_angle_deg)
    residual = units.amplitude * found.residuals()[:len(given.t)]
    if planet_figures.BELOW in candidate.reasons:
        residual = residual - signal
    shown = with_error(units.days * period, units.days * candidate.best_error[0])
    title = f"{candidate.verdict} {index + 1}, period {shown} days"
    if ax is not None:
        with _axes_of(ax, 0) as axes:
            planet_figures.draw_folded(axes, given.t, signal + residual, orbit, units.unit)
            planet_figures.label_phase(axes)
            axes.set_title(title, loc="left")
        return axes
    with _new(planet_figures.HEIGHT_OF_FOLDED, 2, sharex=True) as (top, bottom):
        planet_figures.draw_folded(top, given.t, signal + residual, orbit, units.unit)
        planet_figures.draw_residuals(bottom, given.t, residual, orbit, units.unit)
        planet_figures.label_phase(bottom)
        top.set_title(title, loc="left")
    return top.figure


def limits(found: searches.Planets, periods: typing.Any, ax: Axes | None) -> Axes:
    """Planets.plot_limits()"""
    info = found.info
    if periods is None:
        periods = numpy.geomspace(info.period_min, info.period_max, _LIMITS)
    chosen = numpy.unique(_arguments.plain("periods", periods, found._units["t"]))
    if len(chosen) < 2:
        raise ValueError(f"periods: {len(chosen)} different ones: must be at least 2")
    values = found.limits(chosen)
    masses = bool(numpy.isfinite(values["upper_mass_a"]).any())
    units = _Units(found._given, float(numpy.median(values["upper"])))
    end, factor, key = ("_mass_a", 1.0, "mass_a") if masses else ("", units.amplitude, "amplitude")
    upper, detectable = (factor * numpy.where(numpy.isfinite(values[name + end]), values[name + end], numpy.nan)
                         for name in ("upper", "detectable"))
    if not numpy.isfinite(upper).any():
        raise ValueError("these Planets have no upper limit at these periods: the functions leave nothing of a signal")
    planets = [(units.days * one.period[1], factor * getattr(one, key)[1]) for one in found.planets]
    with _axes_of(ax, planet_figures.HEIGHT_OF_LIMITS) as axes:
        planet_figures.draw_limits(axes, units.days * chosen, upper, detectable,
                                   units.mass if masses else _label("amplitude", units.unit), planets, masses)
        axes.legend(**_legend(ax))
    return axes


def frame(simulator: sim.Simulator, k: int, ax: Axes | None) -> Axes:
    """Simulator.plot_frame()"""
    return _draw_image(_image(f"frame {k}", simulator.frame(k), UNITS[simulator.info.unit], "log"), ax)


def pupil(simulator: sim.Simulator, ax: Axes | None) -> Axes:
    """Simulator.plot_pupil()"""
    amplitude, opd_m = simulator.pupil()
    opd, step = numpy.where(amplitude > 0, 1e9 * opd_m, numpy.nan), 1e3 * simulator.info.aperture_m / len(amplitude)
    return _draw_image(_image("pupil", opd, "optical path difference, nm", "linear", "mm", step), ax)


def mask(designed: masks.DesignedMask, ax: Axes | None) -> Axes:
    """DesignedMask.plot()"""
    with _axes_of(ax, mask_figures.HEIGHT_OF_MASK, _IMAGE_WIDTH) as axes:
        mask_figures.draw_mask(axes, designed.cells, **_legend(ax))
    return axes


def budget(made: budgets.Budget, ax: Axes | None) -> Axes:
    """Budget.plot()"""
    bounds = [step.crb_px if math.isfinite(step.crb_px) else math.nan for step in made.steps]
    if numpy.isnan(bounds).all():
        raise ValueError("this Budget has no finite bound")
    names = [step.name for step in made.steps]
    with _axes_of(ax, figures.height_of_bounds(names)) as axes:
        figures.draw_bounds(axes, names, {"bound of a frame": bounds}, made.summary.earth_px)
        axes.legend(**_legend(ax))
    return axes
