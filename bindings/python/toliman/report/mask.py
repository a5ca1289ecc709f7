"""The section of a folder of `toliman pupil --out`: bounds, light and mask of a design, and where its information is."""
from __future__ import annotations

import math
import pathlib
import typing

import numpy

from . import glossary, mask_figures, results
from .mask_information import Simulated, simulate
from .page import Page, add_provenance
from .results import Array, Result, malformed
from .text import UNITS, UNKNOWN, exponential, fixed, scientific

SCHEMA = "toliman-pupil/1"
_MASKS = {"scene's mask": "scene_mask", "designed mask": "designed"}
# Free parameters: keys of the bound and, if there is one, of the quantum bound.
_SETS = {"none": ("crb_alone_px", "quantum_px"), "fluxes, shift": ("crb_flux_shift_px", "quantum_flux_shift_px"),
         "all of the design": ("crb_px", "")}
_WORDS = {
    **glossary.BOUND,
    "quantum bound": "the smallest bound for this pupil with any mask that only delays light, if no light is lost",
    "factor in photons": "square of the ratio of the two bounds: how many times the photons the scene's mask needs for the "
                         "bound of the designed mask",
    "peak-to-mean ratio": "brightest pixel over mean pixel of the noise-free frame: the dynamic range that the detector needs",
    "gradient energy": "mean square gradient of the light over the square of the mean light: fine structure of the frame",
}


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds the design of a mask to the page."""
    file = results.load(folder / "pupil.json", SCHEMA)
    places, free = file.items("places"), _free(file)
    if not places:
        raise file.fail("places", "a list of at least one place")
    page.add("title", f"Mask designed for {file.text('scene')}")
    page.add("found", _found(file, places[0]))
    add_provenance(page, file)
    page.add("text", _design(file, free))
    _add_bounds(places, page)
    _add_light(places, page)
    descent = _descent(file)
    _add_images(folder, file, free, page)
    if numpy.isfinite(descent).any():
        page.add_figure("mask-descent", mask_figures.descent(descent),
                        "Bound in each iteration of the design. It is that of a sketch of the scene, with fewer cells, pixels "
                        "and wavelengths, and differs from the bounds of the table.")
    page.explain(_WORDS)


def _free(file: Result) -> list[str]:
    names = file.find("free")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise file.fail("free", "a list of names")
    return names


def _descent(file: Result) -> Array:
    """The bounds of the sketch; NaN where they are infinite."""
    try:
        bounds = numpy.array(file.find("descent_px"), dtype=float)
    except (TypeError, ValueError):
        bounds = numpy.zeros(1)
    if bounds.ndim != 1 or (bounds <= 0).any() or numpy.isinf(bounds).any():
        raise file.fail("descent_px", "a list of numbers above 0")
    return bounds


def _bound(of: Result, key: str) -> float:
    """A bound, infinite if it is null."""
    value = of.number(key)
    if value <= 0:
        raise of.fail(key, "above 0, or null")
    return math.inf if math.isnan(value) else value


def _px(bound: float) -> str:
    return "∞" if math.isinf(bound) else exponential(bound)


def _percent(fraction: float) -> str:
    return f"{scientific(100 * fraction)} %"


def _bounds(place: Result, key: str) -> list[float]:
    """The bounds of the two masks."""
    return [_bound(place, f"{mask}.{key}") for mask in _MASKS.values()]


def _photons(own: float, designed: float) -> str:
    """The factor in photons that equals the change of the bound."""
    if math.isinf(designed):
        return UNKNOWN
    return "∞" if math.isinf(own) else scientific((own / designed) ** 2)


def _place(place: Result) -> str:
    """A place of the stars; "" for that of the scene."""
    if place.has("date"):
        return f"date {place.number('date'):.10g}"
    if place.has("position_angle_deg"):
        return f"position angle {place.number('position_angle_deg'):.10g}°"
    return ""


def _found(file: Result, place: Result) -> str:
    own, designed = _bounds(place, "crb_px")
    at = f" at {_place(place)}" if _place(place) else ""
    text = (f"Bound of the separation in one frame{at}: {_px(own)} px with the scene's mask, {_px(designed)} px with the "
            "designed mask.")
    if math.isfinite(own) and math.isfinite(designed):
        text += f" The change equals a factor of {_photons(own, designed)} in photons."
    if not file.flag("improved"):
        text += (" The designed mask is not better: its bound is not smaller at every place, or its peak-to-mean ratio exceeds "
                 "the limit.")
    return text + (" The design was stopped before its end." if file.flag("stopped") else "")


def _design(file: Result, free: list[str]) -> str:
    return (f"Free parameters of the design: {', '.join(free) or 'none'}. Seed {file.whole('seed')}, "
            f"{file.whole('iterations')} iterations. {_percent(file.number('small_features'))} of the open cells are in "
            "features below the smallest size.")


def _add_by_place(caption: str, first: str, heads: list[str], rows: list[list[str]], page: Page) -> None:
    """Adds a table whose second column is the place, unless that is the scene's."""
    if any(row[1] for row in rows):
        page.add_table(caption, [first, "place", *heads], rows)
    else:
        page.add_table(caption, [first, *heads], [[row[0], *row[2:]] for row in rows])


def _add_bounds(places: list[Result], page: Page) -> None:
    rows = []
    for name, (key, quantum) in _SETS.items():
        for place in places:
            own, designed = _bounds(place, key)
            least = exponential(place.number(quantum)) if quantum else UNKNOWN
            rows.append([name, _place(place), _px(own), _px(designed), _photons(own, designed), least])
    _add_by_place("Bounds of the separation in one frame, px", "free parameters",
                  [*_MASKS, "factor in photons", "quantum bound"], rows, page)


def _add_light(places: list[Result], page: Page) -> None:
    lines: dict[str, tuple[str, typing.Callable[[float], str]]] = {
        "peak-to-mean ratio": ("peak_to_mean", lambda value: fixed(value, 1)),
        "light in the frame": ("light_in_frame", _percent),
        "gradient energy, px⁻²": ("gradient_energy", scientific),
        "radius with 50 % of the light, px": ("radius_50_px", lambda value: fixed(value, 1)),
        "radius with 80 % of the light, px": ("radius_80_px", lambda value: fixed(value, 1)),
    }
    rows = [[name, _place(place), *(shown(place.number(f"{mask}.{key}")) for mask in _MASKS.values())]
            for name, (key, shown) in lines.items() for place in places]
    _add_by_place("Light of the noise-free frame", "", list(_MASKS), rows, page)


def _cells(path: pathlib.Path, scene: Result) -> Array:
    cells = results.array(path, 2)
    side = scene.whole("telescope.pupil_samples")
    if cells.shape != (side, side):
        raise malformed(path, f"has {cells.shape[0]} x {cells.shape[1]} cells: must be {side} x {side}, "
                              "telescope.pupil_samples of scene.json")
    if not numpy.isin(cells, (0, 1)).all():
        raise malformed(path, "must contain 0 and 1 only")
    return cells


def _add_images(folder: pathlib.Path, file: Result, free: list[str], page: Page) -> None:
    """Adds the mask and, unless the library or a file of the scene is missing, what the scene with it gives."""
    path = folder / "scene.json"
    cells = _cells(folder / "mask.npy", results.load(path, "toliman-scene/1"))
    simulated, reason = simulate(path, free)
    page.add_figure("mask", mask_figures.mask(cells, None if simulated is None else simulated.amplitude),
                    f"The mask in the pupil{_step(file)}.")
    if simulated is None:
        page.add("text", f"No figure of the frame, no map of the information and no costs of the parameters: {reason}")
    elif math.isinf(simulated.information.bound_px):
        page.add("text", "No map of the information: the bound is infinite with these parameters free.")
    else:
        _add_information(simulated, page)


def _step(file: Result) -> str:
    for key, what in (("opd_nm", "optical path difference"), ("height_nm", "height")):
        if file.has(f"mask.{key}"):
            return f". Step of the {what}: {scientific(file.number(f'mask.{key}'), 5)} nm"
    return ""


def _add_information(simulated: Simulated, page: Page) -> None:
    information = simulated.information
    half = _pixels_with_half(information.share)
    page.add_figure("mask-information",
                    mask_figures.information(simulated.frame, UNITS[simulated.unit], information.share,
                                             simulated.stars),
                    "Left: the noise-free frame with the mask. Right: share of each pixel in the information on the "
                    "separation. The share is r²/V over its sum: r is the derivative image by the separation less its weighted "
                    "least-squares fit by those of the free parameters, V the variance. Half of the information is in "
                    f"{half} pixels, {_percent(half / information.share.size)} of the frame. Place of the stars: that "
                    "of scene.json.")
    ranked = sorted(information.known_px.items(), key=lambda item: item[1])
    if ranked:
        page.add_table(f"Cost of each free parameter: the bound with all free, {exponential(information.bound_px)} px, over "
                       "that with this one known. Place of the stars: that of scene.json.",
                       ["parameter", "bound if known, px", "cost"],
                       [[name, exponential(bound), fixed(information.bound_px / bound, 4)] for name, bound in ranked])


def _pixels_with_half(share: Array) -> int:
    """The smallest number of pixels with half of the information."""
    return int(numpy.searchsorted(numpy.cumsum(numpy.sort(share, axis=None)[::-1]), 0.5)) + 1
