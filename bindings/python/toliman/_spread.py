"""Sums of frames whose places differ. Reference: include/toliman/spread.h."""
from __future__ import annotations

import dataclasses
import typing

from . import _raw
from ._arguments import real, shaped
from ._shown import Shown

CUMULANTS = _raw.TOLIMAN_SPREAD_CUMULANTS


@dataclasses.dataclass(frozen=True, repr=False)
class Spread(Shown):
    """Number of the short frames of a sum, and distribution of the stars' places in them: the known jitter of a fit.

    frames: number of frames; a long exposure with known pointing jitter is 1 frame.
    xx, yy, xy: covariance of the places, px^2.
    cumulants: of order 3 to 6, xxx, xxy ... yyyyyy, 22 numbers; empty: those of a normal distribution.
    """

    frames: float = 1
    xx: float = 0
    yy: float = 0
    xy: float = 0
    cumulants: tuple[float, ...] = ()

    def struct(self) -> typing.Any:
        """The struct of the C interface."""
        made = _raw.toliman_spread(frames=real("frames", self.frames), xx_px2=real("xx", self.xx),
                                   yy_px2=real("yy", self.yy), xy_px2=real("xy", self.xy))
        if len(self.cumulants) > 0:
            made.cumulants[:] = shaped("cumulants", self.cumulants, (CUMULANTS,)).tolist()
        return made

    @classmethod
    def of(cls, struct: typing.Any) -> Spread:
        """The spread of a struct."""
        return cls(struct.frames, struct.xx_px2, struct.yy_px2, struct.xy_px2, tuple(struct.cumulants))
