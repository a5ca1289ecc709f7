"""The section of `toliman run` with the figures of the book chapter."""
from __future__ import annotations

import pathlib

import numpy

from . import chapter
from .images import images
from .page import Page
from .results import Array, Result, Table
from .run_images import Images, band
from .run_simulation import BANDS
from .text import scientific

_EXAMPLE = numpy.array([[1, 3, 2, 0], [5, 2, 4, 4], [0, 1, 7, 3], [2, 1, 2, 0]])  # of pooling


def add(folder: pathlib.Path, files: Images, page: Page) -> None:
    """Adds the figures to the page."""
    page.add("heading", "Figures of the chapter")
    has_network = bool(files.pictures.samples)
    if has_network and files.result.has("true_series"):
        _add_signal(folder, files.result, page)
    _add_bandwidths(files, page)
    if has_network:
        _add_reconstructions(files, page)
    if files.pictures.displacement:
        _add_displacement(files.pictures.displacement, page)
    if has_network:
        _add_network(chapter.layout_of(files.pictures.images["reconstructions"].values.shape[-1]), page)


def _add_network(layout: str, page: Page) -> None:
    page.add_figure("architecture", chapter.architecture((layout, "paper")),
                    "The network, as the chapter draws its own. Boxes are images, rows × columns × channels; "
                    "a dense layer "
                    "compresses the last to one number, the latent, which the chapter calls an atom. This run "
                    "used the layout "
                    f"{layout}; paper is that of the chapter, where a maximum is pooled and its place kept for "
                    "un-pooling.")
    page.add_figure("pooling", chapter.pooling(_EXAMPLE),
                    "Pooling of 2 × 2 pixels, an example. Maxima do not change linearly with an image and "
                    "lose a signal far below "
                    "the noise; means keep it. This is the main difference of the layouts.")
    page.add_figure("activations", chapter.activations(),
                    "The chapter's reason for ELU, the exponential linear unit: negative values keep a "
                    "gradient, so that they "
                    "can be trained. ReLU has none below 0.")


def _add_signal(folder: pathlib.Path, result: Result, page: Page) -> None:
    series, table = Table(folder / "series.csv"), Table(folder / "periodogram.csv")
    frequency = table.numbers("frequency")
    above = frequency > 0
    if above.sum() < 2:
        return
    figure = chapter.signal_and_atom(series.numbers("t"), series.numbers("true"), series.numbers("latent"),
                                     frequency[above], table.numbers("true")[above], table.numbers("power")[above],
                                     (result.number("true_series.fwhm_period_days"), result.number("fwhm_period_days")))
    page.add_figure("signal-and-atom", figure,
                    "The chapter's figure of its result. Left: the signal without noise and its periodogram. "
                    "Right: the latents "
                    "and theirs. Series are standardised: less their mean, over their standard deviation. The "
                    "full width at half "
                    "maximum (FWHM) is that of the peak, in days: its frequency width over the square of the "
                    "frequency.")


def _add_bandwidths(files: Images, page: Page) -> None:
    shown = [name for name in BANDS if not files.pictures.reasons[name]]
    if shown:
        panels = [files.panel(name, band(name), unit="fraction of the light per pixel") for name in shown]
        page.add_figure("bandwidths", images(panels),
                        "A star in the chapter's three bands, same colours: far from the middle, fringes of "
                        "different wavelengths "
                        "overlap and wash out; those near it stay. The step of the mask is half a wave at one "
                        "wavelength only; the "
                        "others also leave light in the core.")


def _add_reconstructions(files: Images, page: Page) -> None:
    result, numbers = files.result, files.pictures.samples
    frames, again, residuals = (files.values(name) for name in ("frames", "reconstructions", "residuals"))
    panel = files.panel("frames", "")
    place = (panel.first_x, panel.first_y, panel.step)
    rms = scientific(float(numpy.sqrt(numpy.mean(residuals**2))), 4)
    noise = f"the noise of each pixel; their rms is {rms}, and 1 for noise alone." if result.has("efficiency") else \
        f"the noise that the bound assumes; their rms is {rms}" + \
        (", because these frames lack photon noise." if result.find("controls", "full") != "none" else ".")
    figure = chapter.reconstructions(numbers, frames, again, residuals, place, result.text("unit"))
    page.add_figure("reconstructions", figure,
                    f"{len(numbers)} random frames, and what the network reconstructs of the one number to "
                    "which it compresses "
                    f"each, as in the chapter; the middle {chapter.SHOWN_SIDE} × {chapter.SHOWN_SIDE} px. "
                    f"Residuals are divided by "
                    + noise)


def _add_displacement(errors: dict[str, Array], page: Page) -> None:
    shown = {name: errors[name] for name in chapter.DISPLACEMENTS}
    page.add_figure("displacement", chapter.displacement(errors["displacement_px"], shown),
                    "Images that are shifted and downsampled are inaccurate, as the chapter warns: largest "
                    "error of a pixel over the "
                    "largest change of a pixel by the displacement, for a star 1/3 px off the grid and an "
                    "image with 5 samples per "
                    "pixel. In a series the constant part of the error cancels; that of the change (dotted) remains.")
