"""The images of `toliman run`: pupil, point spread functions, frames, reconstructions."""
from __future__ import annotations

import math
import pathlib

import numpy

from . import results
from .images import Panel, Sky, cut, images, whiteness
from .page import Page
from .results import Array, Result
from .text import fixed, scientific, short_unit

_BANDS = ("psf_600nm", "psf_550-600nm", "psf_500-700nm")
_ARCSEC = 3600 * 180 / math.pi


class _Images:
    """The image files that result.json lists."""

    def __init__(self, folder: pathlib.Path, result: Result):
        self.folder, self.result = folder, result
        self.scale = result.positive("geometry.pixel_scale_arcsec")

    def values(self, name: str, dimensions: int = 2) -> Array:
        return results.array(self.folder / self.result.text(f"images.{name}.file"), dimensions)

    def reason(self, name: str) -> str:
        """Why there is no image; "" if there is one."""
        return self.result.text(f"images.{name}.reason") if self.result.has(f"images.{name}.reason") else ""

    def panel(self, name: str, title: str, scale: str = "log", values: Array | None = None, unit: str = "") -> Panel:
        """An image in arcsec or mm."""
        key = f"images.{name}."
        in_px = self.result.text(key + "axis_unit") == "px"
        factor = self.scale if in_px else 1.0
        first_x, first_y, step = (factor * self.result.number(key + part) for part in ("first_x", "first_y", "step"))
        return Panel(title, self.values(name) if values is None else values, first_x, first_y, step,
                     unit or self.result.text(key + "unit"), "arcsec" if in_px else "mm", scale)

    def sky(self) -> Sky:
        number = lambda key: self.result.number("geometry." + key)  # noqa: E731
        stars = {name: (self.scale * number(f"{name.lower()}_x_px"), self.scale * number(f"{name.lower()}_y_px"))
                 for name in "AB" if math.isfinite(number(f"{name.lower()}_x_px"))}
        return Sky(stars, (number("north_x"), number("north_y")), (number("east_x"), number("east_y")))


def add(folder: pathlib.Path, result: Result, page: Page) -> None:
    """Adds the images to the page."""
    if not result.has("images"):
        page.add("text", "No images: this run was made by an earlier version; run it again.")
        return
    files = _Images(folder, result)
    _add_optics(files, page)
    _add_frame(files, page)
    _add_residuals(files, page)


def _band(name: str) -> str:
    return name.removeprefix("psf_").replace("nm", " nm").replace("-", "–")


def _add_optics(files: _Images, page: Page) -> None:
    bands = [name for name in _BANDS if not files.reason(name)]
    panels = [files.panel("pupil_opd", "pupil: optical path difference", "linear")]
    for name in bands[:1]:
        panels.append(files.panel(name, f"point spread function, {_band(name)}", unit="fraction of the light per pixel"))
    page.add_figure("pupil", images(panels),
                    "The mask in the pupil, grey where no light passes" + (
                        ", and the image that it makes of a star, a black body of 5790 K." if bands else "."))
    for name in _BANDS:
        if files.reason(name):
            page.add("text", f"No point spread function of {_band(name)}: {files.reason(name)}")
    if not bands:
        return
    aperture = files.result.positive("geometry.aperture_m")
    middle = [(files.result.number(f"images.{name}.min_nm") + files.result.number(f"images.{name}.max_nm")) / 2
              for name in bands]
    psf = [files.panel(name, "") for name in bands]
    row = int(round(-psf[0].first_y / psf[0].step))
    x = psf[0].first_x + psf[0].step * numpy.arange(psf[0].values.shape[1])
    resolution = middle[0] * 1e-9 / aperture * _ARCSEC
    page.add_figure("cut", cut({_band(name): panel.values[row] for name, panel in zip(bands, psf)}, x, resolution),
                    f"Cut through the star's image along x. λ/D at {middle[0]:g} nm is {fixed(resolution, 2)} arcsec, "
                    f"{fixed(resolution / files.scale, 2)} px.")


def _add_frame(files: _Images, page: Page) -> None:
    result = files.result
    unit = result.text("unit")
    panels = [files.panel("frame", "frame 0", unit=unit)]
    caption = f"The first frame as the detector records it; brightest expected pixel {scientific(result.number('peak_counts'))} {unit}."
    if result.number("amplitude_px") != 0:
        difference = files.values("difference")
        factor, short = short_unit(difference.ravel().tolist(), unit)
        panels.append(files.panel("difference", "change by the signal", "difference", factor * difference, short))
        caption += (f" Right: the expected frame at the signal's largest displacement minus that without displacement, "
                    f"{scientific(float(difference.min()))} to {scientific(float(difference.max()))} {unit}.")
    if result.has("peak_sigma"):
        caption += f" The noise of the brightest pixel has a standard deviation of {scientific(result.number('peak_sigma'))} {unit}."
    page.add_figure("frame", images(panels, files.sky()), caption + " N, E: directions on the sky.")


def _add_residuals(files: _Images, page: Page) -> None:
    residuals = files.values("residuals", 3)
    if not numpy.isfinite(residuals).any():
        return
    result = files.result
    page.add_figure("whiteness", whiteness(residuals),
                    f"Residuals (frame minus reconstruction, over the sigma of each pixel) of {len(residuals)} frames against "
                    f"white noise. Over {result.whole('residuals.frames')} validation frames their mean is "
                    f"{scientific(result.number('residuals.mean'), 2)}, their rms {fixed(result.number('residuals.rms'), 4)} and the "
                    f"correlation of neighbours in a row {scientific(result.number('residuals.correlation'), 2)}; for white noise "
                    "0, 1 and 0.")
