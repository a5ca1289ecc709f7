"""Properties of this machine: instruction set, processors, OpenBLAS and FFTW."""
from __future__ import annotations

import ctypes
import functools
import warnings

from . import _raw
from ._library import check, library
from ._results import Machine


def machine() -> Machine:
    """Returns the properties of this machine: processors, instruction set in use, OpenBLAS kernels, FFTW version."""
    found = _raw.toliman_machine()
    check(library.toliman_get_machine(ctypes.byref(found)))
    return Machine._of(found)


@functools.lru_cache(maxsize=None)
def warn_of_slow_blas() -> None:
    """Warns, once per process, if OpenBLAS chose kernels for an older processor. OpenBLAS chooses when it is loaded, so
    the user must set OPENBLAS_CORETYPE before Python starts; the bindings cannot correct it."""
    found = machine()
    if found.blas_is_slow:
        warnings.warn(f"OpenBLAS runs kernels for an older processor ({found.blas_core}) and is slow: set "
                      f"OPENBLAS_CORETYPE={found.blas_better} before starting Python", RuntimeWarning, stacklevel=3)
