"""What the figures of `toliman run` show of its scene, simulated from the files of the run: pupil, point spread functions,
frames with their reconstructions. The package loads libtoliman for this and for mask_information."""
from __future__ import annotations

import json
import math
import pathlib
import typing

import numpy

from .._output import signals_deferred
from . import displacement
from .results import Array, Result

BANDS = {"psf_600nm": (600, 600), "psf_550-600nm": (550, 600), "psf_500-700nm": (500, 700)}  # nm, of the book chapter's figure
_SIDE = 256  # rows and columns of the point spread functions
_SAMPLES = 5  # random frames
_ACCURACY = 1e-6  # of point spread functions
_MOST_DISPLACEMENT = 0.1  # px, of the Taylor expansion


class Image(typing.NamedTuple):
    """An array [..][rows][columns]: pixel [i][j] is at (first_x + j step, first_y + i step) from the optical axis."""

    values: Array
    unit: str
    first_x: float
    first_y: float
    step: float = 1.0
    axis_unit: str = "px"


class Pictures(typing.NamedTuple):
    """Images by name; why there is no image, by name; numbers of the random frames; errors of displaced images by name, empty
    where the pixels are too small to be divided."""

    images: dict[str, Image]
    reasons: dict[str, str]
    samples: list[int]
    displacement: dict[str, Array]


def simulate(folder: pathlib.Path, result: Result) -> tuple[Pictures | None, str]:
    """Simulates the scene of a run; None and the reason if that is not possible."""
    if not (folder / "scene.json").exists():
        return None, "the folder has no scene.json."
    try:
        from .. import Error
    except ImportError as error:
        return None, "libtoliman cannot be loaded. " + " ".join(str(error).split())
    with signals_deferred() as received:  # an exception of a signal handler cannot propagate through C
        try:
            scene = dict(json.loads((folder / "scene.json").read_text()))
            return _Run(folder, result, scene, lambda *_: bool(received)).pictures(), ""
        except (OSError, ValueError, TypeError, Error) as error:
            return None, str(error)


class _Run:
    """A run's scene and network."""

    def __init__(self, folder: pathlib.Path, result: Result, scene: dict[str, typing.Any], progress: typing.Any):
        from .. import Simulator
        self.folder, self.seed = folder, result.whole("seed")
        self.base, self.progress = result.text("scene_folder"), progress
        self.simulator = Simulator(scene, folder=self.base, progress=progress)
        self.telescope = scene["telescope"]
        self.info, self.unit = self.simulator.info, result.text("unit")
        self.has_network = result.find("estimator", "network") == "network"

    def pictures(self) -> Pictures:
        images, reasons = {**self.pupil(), **self.frames()}, {}
        for name, band in BANDS.items():
            star, reasons[name] = self.star(band, _SIDE, self.info.pixel_scale_arcsec, _ACCURACY)
            if star is not None:
                images[name] = self.image(star.image() / displacement.PHOTONS, "fraction of light")
        samples = self.samples() if self.has_network else []
        if samples:
            images.update(self.reconstructions(samples))
        return Pictures(images, reasons, samples, self.displacement_errors())

    def star(self, band: tuple[float, float], side: int, scale_arcsec: float, accuracy: float,
             amplitude_px: float = 0.0) -> tuple[typing.Any, str]:
        """A simulator of a star alone behind the telescope; None and the reason if the library refuses the band or the
        pixels, as it does where the pupil has too few samples."""
        from .. import InputError, Simulator
        try:
            return Simulator(displacement.single_star(self.telescope, band, side, scale_arcsec, accuracy, amplitude_px),
                             folder=self.base, progress=self.progress), ""
        except InputError as error:
            return None, str(error)

    def image(self, values: Array, unit: str, first: tuple[float, float] = (0, 0),
              shape: tuple[int, int] | None = None) -> Image:
        """An image whose first pixel is pixel `first`, (row, column), of a frame of this shape, by default its own."""
        rows, cols = shape or values.shape
        return Image(values, unit, first[1] - (cols - 1) / 2, first[0] - (rows - 1) / 2)

    def pupil(self) -> dict[str, Image]:
        amplitude, opd_m = self.simulator.pupil()
        step = 1e3 * self.info.aperture_m / len(amplitude)
        first = -step * (len(amplitude) - 1) / 2
        opd = numpy.where(amplitude > 0, 1e9 * opd_m, numpy.nan)
        return {"pupil_amplitude": Image(amplitude, "", first, first, step, "mm"),
                "pupil_opd": Image(opd, "nm", first, first, step, "mm")}

    def frames(self) -> dict[str, Image]:
        """The frame without noise, its change at the largest displacement of the cadence, and frame 0."""
        low, high = self.info.min_displacement_px, self.info.max_displacement_px
        largest = low if -low > high else high
        still = self.simulator.expect(0)
        moved = self.simulator.expect if abs(largest) <= _MOST_DISPLACEMENT else self.simulator.propagate
        return {name: self.image(values, self.unit) for name, values in (
            ("expected", still), ("frame", self.simulator.frame(0, seed=self.seed)), ("difference", moved(largest) - still))}

    def samples(self) -> list[int]:
        """Numbers of random frames, one from each fifth of the cadence."""
        edges = numpy.arange(_SAMPLES + 1) * self.info.frames // _SAMPLES
        return numpy.random.default_rng(self.seed).integers(edges[:-1], edges[1:]).tolist()

    def reconstructions(self, samples: list[int]) -> dict[str, Image]:
        """Frames as the network crops them, what it reconstructs of them, and the rest over the noise of each pixel."""
        from .. import CAE
        network = CAE.load(self.folder / "weights.tlmw")
        first = network.info.crop_row, network.info.crop_col
        crop = tuple(slice(start, start + network.info.side) for start in first)
        whole = [self.simulator.frame(k, seed=self.seed) for k in samples]
        frames = numpy.stack([frame[crop] for frame in whole])
        again = numpy.stack([network.reconstruct(frame).image for frame in whole])
        residuals = (frames - again) / numpy.sqrt(self.simulator.image("variance")[crop])
        return {name: self.image(values, unit, first, self.simulator.shape) for name, values, unit in (
            ("frames", frames, self.unit), ("reconstructions", again, self.unit),
            ("residuals", residuals, "sigma of the pixel"))}

    def displacement_errors(self) -> dict[str, Array]:
        wavelengths = 1e9 * self.simulator.spectrum().wavelength_m
        band, scale = (wavelengths.min(), wavelengths.max()), self.info.pixel_scale_arcsec
        star, _ = self.star(band, displacement.SIDE, scale, displacement.ACCURACY, displacement.DISPLACEMENTS[0])
        fine, _ = self.star(band, displacement.FINE_SIDE, scale / displacement.OVERSAMPLING, displacement.ACCURACY)
        return {} if star is None or fine is None else displacement.errors_of(star, fine)
