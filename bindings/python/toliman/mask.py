"""Designs a phase mask with a smaller Cramer-Rao bound. Reference: include/toliman/mask.h."""
from __future__ import annotations

import ctypes
import functools
import json
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import options_of, pointer, real, shaped, text, whole
from ._handle import Handle
from ._library import check, library
from ._plots import Axes, plots
from ._progress import Progress, Watch
from ._results import MaskInfo
from ._shown import brief_repr, documented, members_html
from ._table import Rows
from ._words import number
from .sim import Scene, Simulator, simulator_of


@documented(cells="[row][column] of the pupil: 1 where the mask steps", mask="telescope.mask of a scene",
            places="scores at each place of the stars", descent="bound of the sketch in each iteration, px")
class DesignedMask(typing.NamedTuple):
    """Result of design_mask.

    cells: [row][column] of the pupil, uint8: 1 where the mask steps. mask: telescope.mask of a scene, whose file
    mask.npy is numpy.save("mask.npy", cells). places: scores at each place of the stars. descent: the bound of the sketch
    in each iteration, px.
    """

    cells: NDArray[numpy.uint8]
    mask: dict[str, typing.Any]
    places: Rows[MaskInfo]
    descent: NDArray[numpy.float64]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the cells. ax: Axes to draw into, in their style; None: a new figure of pyplot."""
        return plots().mask(self, ax)

    def __repr__(self) -> str:
        return brief_repr(self)

    def _repr_html_(self) -> str:
        return members_html(self)


class _Mask(Handle):
    _kind, _destroy = _raw.toliman_mask, "toliman_mask_destroy"

    def designed(self, side: int, places: int) -> DesignedMask:
        cells = numpy.empty((side, side))
        check(library.toliman_mask_get_cells(self._c, side, pointer(cells)))
        infos = Rows(self._read(functools.partial(_get_place, place), _raw.toliman_mask_info, MaskInfo)
                     for place in range(places))
        descent = numpy.empty(infos[0].iterations)
        check(library.toliman_mask_get_descent(self._c, len(descent), pointer(descent)))
        return DesignedMask(cells.astype(numpy.uint8), json.loads(library.toliman_mask_get_json(self._c)), infos, descent)


def _get_place(place: int, mask: typing.Any, info: typing.Any) -> int:
    return library.toliman_mask_get_place(mask, place, info)


def design_mask(simulator: Simulator | Scene, *, free: typing.Iterable[str] | None = None, dates: ArrayLike | None = None,
                position_angles: ArrayLike | None = None, peak_to_mean: float = 0, light_in_frame: float = 0,
                feature_cells: int = 0, symmetry: str = "none", iterations: int = 0, seed: int = 0, threads: int = 0,
                progress: Progress | bool | None = None) -> DesignedMask:
    """Designs a mask by the gradient of the Cramer-Rao bound.

        made = toliman.design_mask(toliman.Simulator("mission.json"))
        numpy.save("mask.npy", made.cells)
        scene["telescope"]["mask"] = made.mask

    Parameters

    simulator: the scene, as a Simulator, a file or a dict.
    free: parameters that are fitted together with the separation; None means fluxes, shifts, roll, scale, focus and
        background.
    dates, position_angles: places of the stars, in Julian years for a scene with an orbit, or position angles in
        degrees; None means the scene's own place.
    peak_to_mean: largest ratio of the brightest pixel to the mean; 0 means that of the scene's mask.
    light_in_frame: smallest fraction of the light in the frame; 0 means 0.875, or no limit in a scene with peak_photons.
    feature_cells: side of the smallest feature, in cells of the pupil; 0 means 2.
    symmetry: under a rotation of the pupil by 180 degrees: "none", "even" or "odd".
    iterations: of the first descent; 0 means 250.
    seed: seed of the random spirals that it starts from.

    A true return value of progress ends the design: the result is the mask so far, with places[0].stopped. Ctrl-C
    raises KeyboardInterrupt.
    """
    simulator = simulator_of("simulator", simulator)
    lists = {name: None if values is None else shaped(name, values, (-1,), unit)
             for name, values, unit in (("dates", dates, ""), ("position_angles", position_angles, "deg"))}
    counts = {name: 0 if values is None else len(values) for name, values in lists.items()}
    with Watch(progress) as watch:
        options = options_of(
            _raw.toliman_mask_options, seed=whole("seed", seed, 2**64),
            free=None if free is None else text("free", " ".join(free)), dates=pointer(lists["dates"]),
            date_count=counts["dates"], position_angles_deg=pointer(lists["position_angles"]),
            position_angle_count=counts["position_angles"], peak_to_mean=real("peak_to_mean", peak_to_mean),
            light_in_frame=real("light_in_frame", light_in_frame),
            feature_cells=whole("feature_cells", feature_cells, 2**32),
            symmetry=number("symmetry", symmetry, "TOLIMAN_MASK_SYMMETRY"),
            iterations=whole("iterations", iterations, 2**32), threads=whole("threads", threads, 2**32),
            progress=watch.callback)
        made = _Mask._create(library.toliman_mask_create, simulator._c, ctypes.byref(options))
    return _Mask._adopt(made).designed(simulator.info.pupil_samples, max(1, *counts.values()))
