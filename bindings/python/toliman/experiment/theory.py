"""Results expected in theory of estimates that scatter by the Cramer-Rao bound, and a test for uniformity.

A method that reaches the bound leaves the residual fraction sigma^2 / (sigma^2 + var(signal)) at the true period; Baluev's
FAP of that residual on the experiment's grid is the expected one, and bisection gives the amplitude of FAP = 1e-3. For
principal components the threshold is the phase transition of Baik, Ben Arous and Peche (2005), Ann. Probab. 33, 1643: the
signal's variance over sigma^2 must exceed sqrt(pixels/frames). Uniformity of FAPs: Kolmogorov-Smirnov D with Stephens'
effective argument (sqrt n + 0.12 + 0.11/sqrt n) D, and the alternating series p = 2 sum (-1)^(k-1) exp(-2 k^2 x^2).
"""
from __future__ import annotations

import math

import numpy

from .._arguments import Doubles
from ..periodogram import Grid, Periodogram

FOUND = -3.0  # log10 FAP below which a period counts as found


class Theory:
    """For one cadence and the shape of one signal, which is the signal of amplitude 1 at the times."""

    def __init__(self, times: Doubles, shape: Doubles, grid: Grid):
        self._periodogram = Periodogram(*grid, time_offset=times.min())
        self._periodogram.push_many(times, shape)
        self._frames, self._variance = len(times), float(shape.var())

    def log10_fap(self, amplitude_px: float, sigma_px: float) -> float:
        """Returns log10 of Baluev's FAP of a method with this scatter."""
        ratio = amplitude_px / sigma_px
        return self._periodogram.log10_fap(-math.log1p(ratio * ratio * self._variance) / math.log(10))

    def threshold_px(self, sigma_px: float) -> float:
        """Returns the amplitude at which log10_fap() is FOUND."""
        low, high = 0.0, sigma_px
        while self.log10_fap(high, sigma_px) > FOUND and high < 1e6 * sigma_px:
            high *= 2
        for _ in range(60):
            middle = (low + high) / 2
            if self.log10_fap(middle, sigma_px) > FOUND:
                low = middle
            else:
                high = middle
        return high

    def pca_threshold_px(self, sigma_px: float, pixels: int) -> float:
        """Returns the amplitude above which the signal is the first principal component of whitened frames. For a
        sinusoid A = sigma sqrt(2 sqrt(pixels/frames))."""
        return sigma_px * math.sqrt(math.sqrt(pixels / self._frames) / self._variance)


def uniformity(values: Doubles) -> float:
    """Returns the p-value of the Kolmogorov-Smirnov test that values are drawn from the uniform distribution on [0, 1],
    with the correction of Stephens (1970) for their number."""
    values, n = numpy.sort(values), len(values)
    steps = numpy.arange(n + 1) / n
    gap = max((values - steps[:-1]).max(), (steps[1:] - values).max())
    x = (math.sqrt(n) + 0.12 + 0.11 / math.sqrt(n)) * gap
    if x < 0.2:
        return 1.0  # to 1e-12; the series would need more terms
    chance = sum((2 if k % 2 else -2) * math.exp(-2 * k * k * x * x) for k in range(1, 41))
    return min(max(chance, 0.0), 1.0)
