"""Series of separations that a spacecraft measures, and its observer file, for the tests of commands that reduce them."""
import os
import pathlib
import sys

import numpy
from program import PROGRAM, ROOT

os.environ.setdefault("TOLIMAN_LIBRARY", str(pathlib.Path(PROGRAM).parents[1] / "lib" / "libtoliman.so"))
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402

SECOND, DAY = 10**9, 86400 * 10**9
SCALE = 0.375  # arcsec per px
EXPOSURE = 60  # s
START = toliman.parse_time("2027-01-01", scale="tai")
SYSTEM = ROOT / "examples" / "systems" / "alpha-cen.json"


def write_orbit(path, start, minutes):
    """An observer file: a state per minute of a circular orbit of 7000 km."""
    lines = ["t_tai_ns,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s"]
    for i in range(minutes):
        c, s = numpy.cos(0.00107801 * 60 * i), numpy.sin(0.00107801 * 60 * i)
        lines.append(f"{start + i * 60 * SECOND},{7000 * c:.6f},{7000 * s:.6f},0,{-7.54607 * s:.9f},{7.54607 * c:.9f},0")
    path.write_text("\n".join(lines) + "\n")


def measured(sky, tai_ns, planet_uas=0):
    """Separations in arcsec: the mean of 15 instants of the exposure, with a planet that changes that on the orbit."""
    steps = ((numpy.arange(15) + 0.5) / 15 - 0.5) * EXPOSURE * SECOND
    seen = sky.predict(tai_ns[:, None] + numpy.rint(steps).astype(numpy.int64))
    return (seen["factor"] * (seen["geometric_arcsec"] + 1e-6 * numpy.reshape(planet_uas, (-1, 1)))).mean(axis=1)


def mjd(tai_ns):
    return 40587 + tai_ns / DAY


def write_series(path, times, separations, sigma=None, name="mjd"):
    """times: numbers or texts; separations in the unit of the series."""
    end = "" if sigma is None else f",{sigma!r}"
    lines = [f"{name},y" + (",sigma" if sigma else "")]
    lines += [f"{t if isinstance(t, str) else repr(float(t))},{float(y)!r}{end}" for t, y in zip(times, separations)]
    path.write_text("\n".join(lines) + "\n")
