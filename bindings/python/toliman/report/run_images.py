"""The images of `toliman run`: pupil, point spread functions, frames, reconstructions."""
from __future__ import annotations

import math

import numpy

from .images import Panel, Sky, cut, images, whiteness
from .page import Page
from .results import Array, Result
from .run_simulation import BANDS, Pictures
from .text import fixed, scientific, short_unit

_ARCSEC = 3600 * 180 / math.pi


class Images:
    """The images of a run's scene."""

    def __init__(self, result: Result, pictures: Pictures):
        self.result, self.pictures = result, pictures
        self.scale = result.positive("geometry.pixel_scale_arcsec")

    def values(self, name: str) -> Array:
        """Returns the array of an image."""
        return self.pictures.images[name].values

    def panel(self, name: str, title: str, scale: str = "log", values: Array | None = None, unit: str = "") -> Panel:
        """An image in arcsec or mm."""
        image = self.pictures.images[name]
        in_px = image.axis_unit == "px"
        factor = self.scale if in_px else 1.0
        return Panel(title, image.values if values is None else values, factor * image.first_x, factor * image.first_y,
                     factor * image.step, unit or image.unit, "arcsec" if in_px else "mm", scale)

    def sky(self) -> Sky:
        """Returns the positions of the stars and the directions on the sky."""
        a, b, north, east = (
            (self.result.number(f"geometry.{name}_x{unit}"), self.result.number(f"geometry.{name}_y{unit}"))
            for name, unit in (("a", "_px"), ("b", "_px"), ("north", ""), ("east", "")))
        stars = {name: (self.scale * x, self.scale * y) for name, (x, y) in (("A", a), ("B", b)) if math.isfinite(x)}
        return Sky(stars, north, east)


def add(files: Images, page: Page) -> None:
    """Adds the images to the page."""
    _add_optics(files, page)
    _add_frame(files, page)
    _add_residuals(files, page)


def band(name: str) -> str:
    """The wavelengths of a point spread function as text."""
    return name.removeprefix("psf_").replace("nm", " nm").replace("-", "–")


def _add_optics(files: Images, page: Page) -> None:
    reasons = files.pictures.reasons
    bands = [name for name in BANDS if not reasons[name]]
    panels = [files.panel("pupil_opd", "pupil: optical path difference", "linear")]
    for name in bands[:1]:
        panels.append(files.panel(name, f"point spread function, {band(name)}", unit="fraction of the light per pixel"))
    page.add_figure("pupil", images(panels),
                    "The mask in the pupil, grey where no light passes" + (
                        ", and the image that it makes of a star, a black body of 5790 K." if bands else "."))
    for name in BANDS:
        if reasons[name]:
            page.add("text", f"No point spread function of {band(name)}: {reasons[name]}")
    if not bands:
        return
    aperture = files.result.positive("geometry.aperture_m")
    middle = [sum(BANDS[name]) / 2 for name in bands]
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
    if not files.pictures.samples:
        return
    residuals = files.values("residuals")
    if not numpy.isfinite(residuals).any():
        return
    result = files.result
    page.add_figure("whiteness", whiteness(residuals),
                    f"Residuals (frame minus reconstruction, over the sigma of each pixel) of {len(residuals)} frames "
                    f"against white noise. Over {result.whole('residuals.frames')} validation frames their mean is "
                    f"{scientific(result.number('residuals.mean'), 2)}, their rms "
                    f"{fixed(result.number('residuals.rms'), 4)} and the correlation of neighbours in a row "
                    f"{scientific(result.number('residuals.correlation'), 2)}; for white noise 0, 1 and 0.")
