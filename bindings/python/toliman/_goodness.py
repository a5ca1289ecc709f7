"""Warns of frames that the model does not explain."""
from __future__ import annotations

import warnings

import numpy
from numpy.typing import NDArray

from . import _raw


class FitWarning(RuntimeWarning):
    """The chi-square of frames is not that of their noise: the values or their standard deviations may be wrong."""


FitWarning.__module__ = "toliman"


def warn_of(fits: NDArray, stacklevel: int) -> None:
    """Warns once if the goodness of some of the fits, which have the members of toliman_frame_goodness, is "poor" or
    "too good", or if some did not converge."""
    parts = []
    if "displacement_px" in (fits.dtype.names or ()):
        lost = int(numpy.isnan(fits["displacement_px"]).sum())
        if lost > 0:
            parts.append(f"of {lost} did not converge, their values are NaN: are times, orientation and unit those of the scene?")
    for verdict, text in ((_raw.TOLIMAN_GOODNESS_POOR, "poor: the frames are damaged, or the scene lacks an effect"),
                          (_raw.TOLIMAN_GOODNESS_TOO_GOOD, "too good: are the counts in the unit of the scene?")):
        squares = fits["chi_square"][fits["goodness"] == verdict]
        if len(squares) > 0:
            parts.append(f"of {len(squares)}, with a median chi-square of {numpy.median(squares):.3g}, is {text}")
    if parts:
        warnings.warn(f"{len(fits)} frames: the fit " + "; the fit ".join(parts), FitWarning, stacklevel=stacklevel)
