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

BANDS = ("psf_600nm", "psf_550-600nm", "psf_500-700nm")
_ARCSEC = 3600 * 180 / math.pi


class Images:
    """The image files that result.json lists."""

    def __init__(self, folder: pathlib.Path, result: Result):
        self.folder, self.result = folder, result
        self.scale = result.positive("geometry.pixel_scale_arcsec")

    def values(self, name: str, dimensions: int = 2) -> Array:
        """Returns the array of an image."""
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
        """Returns the positions of the stars and the directions on the sky."""
        a, b, north, east = (
            (self.result.number(f"geometry.{name}_x{unit}"), self.result.number(f"geometry.{name}_y{unit}"))
            for name, unit in (("a", "_px"), ("b", "_px"), ("north", ""), ("east", "")))
        stars = {name: (self.scale * x, self.scale * y) for name, (x, y) in (("A", a), ("B", b)) if math.isfinite(x)}
        return Sky(stars, north, east)


def add(folder: pathlib.Path, result: Result, page: Page) -> None:
    """Adds the images to the page."""
    if not result.has("images"):
        page.add("text", "No images: this run was made by an earlier version; run it again.")
        return
    files = Images(folder, result)
    _add_optics(files, page)
    _add_frame(files, page)
    _add_residuals(files, page)


def band(name: str) -> str:
    """The wavelengths of a point spread function as text."""
    return name.removeprefix("psf_").replace("nm", " nm").replace("-", "–")


def _add_optics(files: Images, page: Page) -> None:
    bands = [name for name in BANDS if not files.reason(name)]
    panels = [files.panel("pupil_opd", "pupil: optical path difference", "linear")]
    for name in bands[:1]:
        panels.append(files.panel(name, f"point spread function, {band(name)}", unit="fraction of the light per pixel"))
    page.add_figure("pupil", images(panels),
                    "The mask in the pupil, grey where no light passes" + (
                        ", and the image that it makes of a star, a black body of 5790 K." if bands else "."))
    for name in BANDS:
        if files.reason(name):
            page.add("text", f"No point spread function of {band(name)}: {files.reason(name)}")
    if not bands:
        return
    aperture = files.result.positive("geometry.aperture_m")
    middle = [(files.result.number(f"images.{name}.min_nm") + files.result.number(f"images.{name}.max_nm")) / 2
              for name in bands]
    psf = [files.panel(name, "") for name in bands]
    row = int(round(-psf[0].first_y / psf[0].step))
    x = psf[0].first_x + psf[0].step * numpy.arange(psf[0].values.shape[1])
    resolution = middle[0] * 1e-9 / aperture * _ARCSEC
    page.add_figure("cut", cut({band(name): panel.values[row] for name, panel in zip(bands, psf)}, x, resolution),
                    f"Cut through the star's image along x. λ/D at {middle[0]:g} nm is {fixed(resolution, 2)} arcsec, "
                    f"{fixed(resolution / files.scale, 2)} px.")


def _add_frame(files: Images, page: Page) -> None:
    result = files.result
    unit = result.text("unit")
    panels = [files.panel("frame", "frame 0", unit=unit)]
    caption = ("The first frame as the detector records it; brightest expected pixel "
               f"{scientific(result.number('peak_counts'))} {unit}.")
    if result.number("amplitude_px") != 0:
        difference = files.values("difference")
        factor, short = short_unit(difference.ravel().tolist(), unit)
        panels.append(files.panel("difference", "change by the signal", "difference", factor * difference, short))
        caption += (f" Right: the expected frame at the signal's largest displacement minus that without displacement, "
                    f"{scientific(float(difference.min()))} to {scientific(float(difference.max()))} {unit}.")
    if result.has("peak_sigma"):
        caption += (" The noise of the brightest pixel has a standard deviation of "
                    f"{scientific(result.number('peak_sigma'))} {unit}.")
    page.add_figure("frame", images(panels, files.sky()), caption + " N, E: directions on the sky.")


def _add_residuals(files: Images, page: Page) -> None:
    if not files.result.has("residuals"):
        return
    residuals = files.values("residuals", 3)
    if not numpy.isfinite(residuals).any():
        return
    result = files.result
    page.add_figure("whiteness", whiteness(residuals),
                    f"Residuals (frame minus reconstruction, over the sigma of each pixel) of {len(residuals)} frames "
                    f"against white noise. Over {result.whole('residuals.frames')} validation frames their mean is "
                    f"{scientific(result.number('residuals.mean'), 2)}, their rms "
                    f"{fixed(result.number('residuals.rms'), 4)} and the correlation of neighbours in a row "
                    f"{scientific(result.number('residuals.correlation'), 2)}; for white noise 0, 1 and 0.")
