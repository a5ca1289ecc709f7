"""Searches for a phase mask with a smaller Cramer-Rao bound. Reference: include/toliman/mask.h."""
from __future__ import annotations

import ctypes
import json
import typing

from . import _raw
from ._arguments import of_kind, options_of, real, whole
from ._handle import Handle
from ._library import library
from ._progress import Progress, Watch
from ._results import MaskInfo
from .sim import Simulator


class FoundMask(typing.NamedTuple):
    """Result of search_mask: the mask, as telescope.mask of a scene, or None if no better one was found; its scores."""

    mask: dict[str, typing.Any] | None
    info: MaskInfo


class _Mask(Handle):
    _kind, _destroy = _raw.toliman_mask, "toliman_mask_destroy"

    def found(self) -> FoundMask:
        text = library.toliman_mask_get_json(self._c)
        info = self._read(library.toliman_mask_get_info, _raw.toliman_mask_info, MaskInfo)
        return FoundMask(json.loads(text) if text else None, info)


def search_mask(simulator: Simulator, *, seed: int = 0, count: int = 0, minutes: float = 0, threads: int = 0,
                progress: Progress | bool | None = None) -> FoundMask:
    """Searches for a spiral mask with a smaller Cramer-Rao bound than the mask of a scene.

        found = toliman.search_mask(toliman.Simulator("chapter.json"), minutes=10)
        scene["telescope"]["mask"] = found.mask

    Parameters

    simulator: Simulator of the scene.
    seed: seed of the random masks.
    count: largest number of masks to draw and vary; 0 means 4000, or no limit with minutes.
    minutes: time limit; 0 means none. Without one the result depends on the scene, seed and count only.

    A true return value of progress ends the search: the result is the best mask so far, with info.stopped. Ctrl-C
    raises KeyboardInterrupt.
    """
    of_kind("simulator", simulator, Simulator)
    with Watch(progress) as watch:
        options = options_of(
            _raw.toliman_mask_options, library.toliman_mask_options_init, seed=whole("seed", seed, 2**64),
            count=whole("count", count, 2**64), minutes=real("minutes", minutes),
            threads=whole("threads", threads, 2**32), progress=watch.callback)
        made = _Mask._create(library.toliman_mask_search, simulator._c, ctypes.byref(options))
    return _Mask._adopt(made).found()
