"""The section of `toliman calibrate`: verdict, residuals, aberrations, parameters over time and their correlations."""
from __future__ import annotations

import pathlib

import numpy

from .._failure import malformed
from . import calibration_figures as figures
from . import results
from .images import Panel, images, whiteness
from .page import Page, add_provenance
from .results import Array, Result
from .text import exponential, fixed, scientific, with_error

SCHEMA = "toliman-calibration-result/1"
_SUFFIX = ".calibration.json"
_MOST_TRACKS = 10  # parameters that are drawn over time
_WORDS = {"prior": "what was assumed of a parameter before the calibration: a normal distribution around 0 with this "
                   "standard deviation",
          "chi-square": "sum of squared residuals over their variances, per degree of freedom; 1 if noise is all that is left"}


def files_of(folder: pathlib.Path) -> list[pathlib.Path]:
    """Returns the results of calibrations in a folder."""
    return sorted(folder.glob("*" + _SUFFIX))


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds all calibrations of a folder to the page."""
    for path in files_of(folder):
        _add_calibration(path, page)


def _add_calibration(path: pathlib.Path, page: Page) -> None:
    file = results.load(path, SCHEMA)
    windows = file.items("windows")
    if not windows:
        raise file.fail("windows", "a list of at least one window")
    page.add("title", f"Calibration of {file.text('scene')}: {file.text('out')}")
    add_provenance(page, file)
    page.add("found", "; ".join(_texts(file, "verdict")))
    page.add("text", _summary(file))
    _add_images(path, file, page)
    _add_aberrations(windows[0], page)
    _add_parameters(windows, page)
    if len(windows) > 1:
        _add_windows(windows, page)
    _add_correlations(windows[0], page)
    _add_frames(file, page)
    _add_steps(file, page)
    page.explain(_WORDS)


def _texts(file: Result, key: str) -> list[str]:
    values = file.find(key)
    if not isinstance(values, list) or not values or not all(isinstance(value, str) for value in values):
        raise file.fail(key, "a list of texts")
    return values


def _summary(file: Result) -> str:
    text = (f"{file.whole('frames')} frames of {file.whole('rows')} × {file.whole('cols')} pixels. Chi-square "
            f"{with_error(file.number('chi_square'), file.number('chi_square_sigma'))} per degree of freedom. Separation of a "
            f"frame: σ = {exponential(file.number('separation_sigma_px'))} px; the uncertain instrument adds "
            f"{exponential(file.number('calibration_sigma_px'))} px.")
    if file.number("map_rms_nm") > 0:
        text += f" Map: {scientific(file.number('map_rms_nm'))} nm rms over the open pupil."
    if file.whole("response_pixels") > 0:
        text += (f" Response: {scientific(file.number('response_rms'))} rms of {file.whole('response_pixels')} pixels that the frames "
                 "determine.")
    return text


def _array(path: pathlib.Path, name: str, dimensions: int) -> Array:
    return results.array(path.with_name(path.name[:-len(_SUFFIX)] + f".{name}.npy"), dimensions)


def _panel(title: str, values: Array, unit: str, scale: str = "linear", axis_unit: str = "px") -> Panel:
    rows, columns = values.shape
    return Panel(title, values, -(columns - 1) / 2, -(rows - 1) / 2, 1.0, unit, axis_unit, scale)


def _add_images(path: pathlib.Path, file: Result, page: Page) -> None:
    before, after, chi = (_array(path, name, 2) for name in ("residual_before", "residual_after", "chi_map"))
    opd = 1e9 * _array(path, "opd_change", 3)[0]
    shape = file.whole("rows"), file.whole("cols")
    for name, values in (("residual_before", before), ("residual_after", after), ("chi_map", chi)):
        if values.shape != shape:
            raise malformed(path, f"rows = {shape[0]}, cols = {shape[1]}: must be the shape of {name}.npy, "
                                          f"{values.shape[0]} x {values.shape[1]}")
    page.add_figure("calibration-residuals",
                    images([_panel("before", before, "residual before, σ of the pixel", "difference"),
                            _panel("after", after, "residual after, σ of the pixel", "difference")]),
                    "Residual of the first frame, with the nominal instrument and with the fitted one. Noise alone has no "
                    "pattern and a standard deviation of 1.")
    page.add_figure("calibration-whiteness", whiteness(after[numpy.newaxis]),
                    "Residual of the first frame with the fitted instrument: distribution and power spectrum, and those of "
                    "white noise.")
    closed = numpy.where(opd == 0, numpy.nan, opd)
    page.add_figure("calibration-maps",
                    images([_panel("all frames", chi, "mean of (residual/σ)² (no unit)"),
                            _panel("pupil", closed, "change of the OPD, nm", "difference", "cells")]),
                    "Left: where the frames differ from the model; 1 is noise. Right: fitted change of the optical path "
                    "difference against the nominal scene; its rms over the open pupil is "
                    f"{scientific(float(numpy.nanstd(closed)) if (opd != 0).any() else 0.0)} nm.")


def _add_aberrations(window: Result, page: Page) -> None:
    chosen = [one for one in window.items("parameters") if one.text("name").startswith(("focus", "zernike_"))]
    if chosen:
        values, sigmas = (numpy.array([one.number(key) for one in chosen]) for key in ("value", "sigma"))
        page.add_figure("calibration-aberrations", figures.bars([one.text("name") for one in chosen], values, sigmas, "nm rms"),
                        "Fitted aberrations, coefficients over the full aperture, with their standard deviations.")


def _add_parameters(windows: list[Result], page: Page) -> None:
    several = len(windows) > 1
    rows = []
    for one in windows[0].items("parameters"):
        notes = [word for key, word in (("held", "known by the prior"), ("no_sign", "sign unknown")) if one.flag(key)]
        rows.append([one.text("name"), with_error(one.number("value"), one.number("sigma")),
                     one.text("unit") or "–", scientific(one.number("prior_sigma")), ", ".join(notes)])
    caption = "Parameters of the first window" if several else "Parameters"
    page.add_table(caption + ": changes against the nominal scene", ["parameter", "value", "unit", "prior", "note"], rows)
    if several:
        page.add_table("Windows", ["scene", "first day", "frames", "chi-square"],
                       [[window.text("scene"), scientific(window.number("first_days"), 6), str(window.whole("frames")),
                         fixed(window.number("chi_square"), 4)] for window in windows])


def _add_windows(windows: list[Result], page: Page) -> None:
    """The parameters that change most, in their standard deviations."""
    names = [one.text("name") for one in windows[0].items("parameters")]
    for window in windows[1:]:
        if [one.text("name") for one in window.items("parameters")] != names:
            raise window.fail("parameters", "those of the first window")
    tracks = []
    for i, one in enumerate(windows[0].items("parameters")):
        of = [window.items("parameters")[i] for window in windows]
        values, sigmas = (numpy.array([item.number(key) for item in of]) for key in ("value", "sigma"))
        tracks.append(figures.Track(one.text("name"), one.text("unit"), values, sigmas))
    ranked = sorted(tracks, key=lambda track: -float(numpy.ptp(track.values / numpy.maximum(track.sigmas, 1e-300))))
    chosen = [track for track in tracks if any(track is one for one in ranked[:_MOST_TRACKS])]
    days = numpy.array([window.number("first_days") for window in windows])
    page.add_figure("calibration-windows", figures.windows(days, chosen),
                    "Parameters over time" + (f": the {_MOST_TRACKS} that change most" if len(tracks) > _MOST_TRACKS else "")
                    + ". Changes are against the first window.")


def _add_correlations(window: Result, page: Page) -> None:
    names = [one.text("name") for one in window.items("parameters")]
    try:
        matrix = numpy.array(window.find("covariance"), dtype=float)
    except (TypeError, ValueError):
        matrix = numpy.empty(0)
    sigma = numpy.sqrt(numpy.diag(matrix)) if matrix.shape == (len(names), len(names)) else numpy.zeros(1)
    if not (sigma > 0).all():
        raise window.fail("covariance", f"a positive matrix of {len(names)} x {len(names)} numbers")
    if len(names) > 1:
        page.add_figure("calibration-correlations", figures.correlations(names, matrix / sigma / sigma[:, numpy.newaxis]),
                        "Correlations of the parameters, with those of the frames free.")


def _add_frames(file: Result, page: Page) -> None:
    frames = file.items("separations")
    days, values, sigmas = (numpy.array([frame.number(key) for frame in frames])
                            for key in ("time_days", "displacement_px", "separation_sigma_px"))
    if frames:
        page.add_figure("calibration-separations", figures.separations(days, values, sigmas),
                        "Separation of each frame minus that of the scene at its time, with the fitted instrument.")


def _add_steps(file: Result, page: Page) -> None:
    steps = [step for step in file.items("steps") if step.flag("accepted")]
    points = [numpy.array([[step.whole("iteration"), step.number("chi_square")] for step in steps if step.flag("map") is is_map]).T
              for is_map in (False, True)]
    if steps:
        page.add_figure("calibration-steps", figures.convergence(*points), "Chi-square after each iteration.")
