"""What machine this is, and what the library makes of it."""
from __future__ import annotations

import ctypes
import functools
import warnings

from . import _raw
from ._library import check, library
from ._results import Machine


def machine() -> Machine:
    """What the library found on this machine: kernels in use, OpenBLAS, FFTW."""
    found = _raw.toliman_machine()
    check(library.toliman_get_machine(ctypes.byref(found)))
    return Machine._of(found)


def blas_speed() -> float:
    """Speed of OpenBLAS in double precision, GFLOP/s; takes about 50 ms."""
    gflops = ctypes.c_double()
    check(library.toliman_get_blas_speed(ctypes.byref(gflops)))
    return gflops.value


@functools.lru_cache(maxsize=None)
def warn_of_slow_blas() -> None:
    """Once: OpenBLAS chooses its kernels where it is loaded, when it is too late to ask for others."""
    found = machine()
    if found.blas_is_slow:
        warnings.warn(f"OpenBLAS takes this processor for an older one ({found.blas_core}) and is slow: set "
                      f"OPENBLAS_CORETYPE={found.blas_better} before Python starts", RuntimeWarning, stacklevel=3)
