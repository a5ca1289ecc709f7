"""Finds and loads libtoliman.so, once."""
import ctypes
import os
import pathlib

from . import _raw


class Error(Exception):
    """A failed library call; `status` is its code."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status = status


def _candidates():
    if "TOLIMAN_LIBRARY" in os.environ:
        yield os.environ["TOLIMAN_LIBRARY"]
        return
    here = pathlib.Path(__file__).resolve()
    yield str(here.parents[3] / "libtoliman.so.0.1")  # installed: lib/python3/dist-packages/toliman
    for folder in (here.parent, here.parents[3] / "build" / "lib"):
        yield str(folder / "libtoliman.so")
    yield "libtoliman.so.0.1"


def _load():
    tried = []
    for path in _candidates():
        try:
            return ctypes.CDLL(path)
        except OSError as error:
            tried.append(f"{path}: {error}")
    raise ImportError("libtoliman.so was not found; set TOLIMAN_LIBRARY to its path. Tried:\n  " + "\n  ".join(tried))


library = _load()
if library.toliman_abi_version() != _raw.TOLIMAN_ABI_VERSION:
    raise ImportError(f"libtoliman has ABI {library.toliman_abi_version()}, these bindings need "
                      f"{_raw.TOLIMAN_ABI_VERSION}")
_raw.declare(library)


def check(status):
    """Raises Error unless the call succeeded."""
    if status != 0:
        raise Error(status, library.toliman_last_error().decode())


def version():
    """Version of the library, such as "0.1.0"."""
    return library.toliman_version().decode()


def abi_version():
    """Number of the binary interface."""
    return library.toliman_abi_version()
