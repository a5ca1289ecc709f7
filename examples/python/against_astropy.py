"""Compares streaming and batch periodograms of nu Ophiuchi's radial velocities with astropy: power, period, FAP, time.

    python3 against_astropy.py                  needs python3-astropy
"""
import math
import pathlib
import sys
import time

import numpy
from astropy.timeseries import LombScargle

root = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(root / "build" / "python"))  # if it is not installed
import toliman


def timed(work):
    """Returns the result of work() and the best time of three runs, in ms."""
    times = []
    for _ in range(3):
        start = time.perf_counter()
        result = work()
        times.append(1e3 * (time.perf_counter() - start))
    return result, min(times)


def streamed():
    """Returns a periodogram after pushing the samples one at a time. Times are relative to the first one, which makes phases
    refer to it; powers do not depend on the origin."""
    periodogram = toliman.Periodogram(**grid, time_offset=t[0], sigma_floor=sigma.min(), sigma_ceiling=sigma.max())
    for sample in zip(t, y, sigma):
        periodogram.push(*sample)
    return periodogram


t, y, sigma = numpy.genfromtxt(root / "examples" / "data" / "nu_oph_rv.csv", delimiter=",", skip_header=3, unpack=True)
grid = {"f0": 1e-4, "df": 2e-5, "nf": 2500}
frequency = grid["f0"] + grid["df"] * numpy.arange(grid["nf"])
astropy = LombScargle(t, y, sigma)

exact, exact_ms = timed(lambda: astropy.power(frequency, method="slow"))
for name, work in (
    ("toliman, one by one", lambda: streamed().power()),
    ("toliman.batch, tolerance 1e-9", lambda: toliman.batch(**grid, t=t, y=y, sigma=sigma)),
    ("astropy, fast", lambda: astropy.power(frequency, method="fast", assume_regular_frequency=True)),
):
    power, ms = timed(work)
    print(f"{name:30} {ms:7.2f} ms, power within {abs(power - exact).max():.0e} of astropy's slow one ({exact_ms:.0f} ms)")

periodogram = streamed()
fit, peak = periodogram.fit(t, y, sigma), periodogram.peak()
fap = astropy.false_alarm_probability(peak.power, method="baluev", maximum_frequency=frequency[-1])
print(f"period {fit.period:.2f} +- {fit.period_error:.2f} days, amplitude {fit.amplitude:.1f} m/s, from {t.size} velocities")
print(f"log10 FAP {peak.log10_fap:.2f}, astropy's {math.log10(fap):.2f}")
