"""What a spacecraft in a low orbit sees of alpha Centauri, compared with the centre of the Earth, in a day of 2027."""
import logging
import pathlib
import sys

import numpy

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.append(str(TOP.parent / "build" / "python"))  # if it is not installed
from toliman import Sky, parse_time

logging.basicConfig(format="%(message)s")  # the library's warnings: here, that nobody observes from the Earth's centre

earth = Sky("alpha-cen")
spacecraft = Sky("alpha-cen", altitude_km=600)
minutes = numpy.arange(0, 1440, 60)
times = parse_time("2027-05-01") + minutes * 60 * 10**9

from_earth, seen = earth.predict(times), spacecraft.predict(times)
difference = (seen["separation_arcsec"] - from_earth["separation_arcsec"]) * 1e6
for minute, row, uas in zip(minutes, seen, difference):
    print(f"{minute // 60:2d} h  {row['separation_arcsec']:.9f} arcsec  factor {row['factor']:.9f}  {uas:+7.1f} uas")
print(f"spacecraft minus Earth: {difference.min():.0f} to {difference.max():.0f} uas")

# A measured separation is divided by the factor of its exposure; what is left after the orbit are planets and noise.
exposure = [times[3], times[3] + 600 * 10**9]
mean = spacecraft.predict_mean(exposure)
measured = mean.separation_arcsec * (1 + 2.5e-6 / mean.geometric_arcsec)  # with an Earth
print(f"reduced: {(measured / mean.factor - mean.geometric_arcsec) * 1e6:.2f} uas")
