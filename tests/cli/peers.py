"""The Python package of the same build, and what else reads and writes the mission's files: None where it is missing."""
import os
import pathlib
import sys

from program import PROGRAM, ROOT

os.environ.setdefault("TOLIMAN_LIBRARY", str(pathlib.Path(PROGRAM).parents[1] / "lib" / "libtoliman.so"))
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402

try:
    from astropy.io import fits
except ImportError:
    fits = None
try:
    import netCDF4
except ImportError:
    netCDF4 = None
