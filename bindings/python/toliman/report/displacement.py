"""Errors of two ways to displace a star: interpolation of an oversampled image, and the simulator's Taylor expansion.

Method: shift and downsample, which the book chapter warns of. A star is computed once, in the centre of the frame, with 5
samples per pixel and axis. Its image at another position is interpolated between these samples along the rows, linearly or by
the cubic convolution of Keys (1981, IEEE Trans. ASSP 29, 1153), and every fifth sample is kept. The reference is the propagated
image at that position. The star is 1/3 px off the grid, because almost no star of a scene is on it; the error of that constant
shift is far above a signal of 1e-6 px. It cancels in the change of the image, whose error remains a fixed part of the signal.
"""
from __future__ import annotations

import math
import typing

import numpy

from .results import Array

SIDE, OVERSAMPLING = 32, 5
FINE_SIDE = SIDE * OVERSAMPLING
ACCURACY = 1e-9
DISPLACEMENTS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # px, the largest one first
PHOTONS = 1e9  # of the star: far above the least that a scene may have
_OFFSET = 1 / 3  # px, of the star
_MOST_STEPS = 1000  # of a band


def single_star(telescope: typing.Any, band: tuple[float, float], side: int, pixel_scale_arcsec: float, accuracy: float,
                amplitude_px: float) -> dict[str, typing.Any]:
    """Returns the scene of a black body of 5790 K in the centre of the frame, seen by point-sampling pixels without noise, in
    a band in nm with steps of about 1 nm. amplitude_px: of the signal along the rows; 0: none."""
    low, high = band
    steps = min(math.ceil(high - low), _MOST_STEPS)
    scene = {
        "schema": "toliman-scene/1", "telescope": telescope,
        "band": {"min_nm": low, "max_nm": high, "step_nm": (high - low) / steps} if steps else {"wavelength_nm": low},
        "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": PHOTONS}},
        "cadence": {"frames": 1, "exposure_s": 1}, "accuracy": accuracy,
        "detector": {"shape": [side, side], "pixel_scale_arcsec": pixel_scale_arcsec},
    }
    if amplitude_px > 0:  # the one frame has the largest displacement
        scene["signal"] = {"kind": "sinusoid", "star": "A", "amplitude_px": amplitude_px, "period_days": 1,
                           "phase_rad": math.pi / 2}
    return scene


def _linear(samples: Array, t: float) -> Array:
    """Interpolates between samples[1] and samples[2], of four neighbours, at 0 <= t < 1."""
    return samples[1] + t * (samples[2] - samples[1])


def _cubic(samples: Array, t: float) -> Array:
    slope_0, slope_1 = (samples[2] - samples[0]) / 2, (samples[3] - samples[1]) / 2
    gap = samples[2] - samples[1]
    return samples[1] + t * (slope_0 + t * (3 * gap - 2 * slope_0 - slope_1 + t * (slope_0 + slope_1 - 2 * gap)))


def _shifted(fine: Array, shift_px: float, interpolate: typing.Callable[[Array, float], Array]) -> Array:
    """The image of a star shifted by at most 1 px, without the two outermost columns, which need samples beyond the frame. A
    sample holds the light of 1/25 px."""
    shift = -shift_px * OVERSAMPLING
    whole = math.floor(shift)
    rows = slice(OVERSAMPLING // 2, None, OVERSAMPLING)
    columns = OVERSAMPLING * numpy.arange(2, SIDE - 2) + OVERSAMPLING // 2 + whole
    samples = numpy.stack([fine[rows][:, columns + k] for k in (-1, 0, 1, 2)])
    return OVERSAMPLING**2 * interpolate(samples, shift - whole)


def errors_of(star: typing.Any, fine_star: typing.Any) -> dict[str, Array]:
    """Returns the errors for each displacement: the largest error of a pixel, divided by the largest change of a pixel that
    the displacement causes. linear, cubic: interpolated images; linear_change, cubic_change: these less that without the
    displacement; taylor: the expansion that frames are made with. fine_star: the same with smaller pixels."""
    def light(displacement: float) -> Array:
        return star.propagate(displacement)[:, 2:-2] / PHOTONS

    fine, centred, still = fine_star.image() / PHOTONS, light(0), light(_OFFSET)
    errors: dict[str, list[float]] = {name: [] for name in ("linear", "cubic", "linear_change", "cubic_change", "taylor")}
    for displacement in DISPLACEMENTS:
        exact, near = light(_OFFSET + displacement), light(displacement)
        change = exact - still
        signal = abs(change).max()
        for name, how in (("linear", _linear), ("cubic", _cubic)):
            moved = _shifted(fine, _OFFSET + displacement, how)
            errors[name].append(abs(moved - exact).max() / signal)
            errors[name + "_change"].append(abs(moved - _shifted(fine, _OFFSET, how) - change).max() / signal)
        expanded = star.expect(displacement)[:, 2:-2] / PHOTONS
        errors["taylor"].append(abs(expanded - near).max() / abs(near - centred).max())
    return {"displacement_px": numpy.array(DISPLACEMENTS)} | {name: numpy.array(found) for name, found in errors.items()}
