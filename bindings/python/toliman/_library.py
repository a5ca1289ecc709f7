"""Loads libtoliman.so, checks that it fits these bindings, and converts status codes to exceptions."""
from __future__ import annotations

import ctypes
import errno
import os
import pathlib
import sys
import types
import typing

from . import _raw
from ._lock import locked

SONAME = f"libtoliman.so.{_raw.TOLIMAN_VERSION_MAJOR}.{_raw.TOLIMAN_VERSION_MINOR}"


class Error(Exception):
    """Raised when a library call fails; base class of all exceptions of the library.

    The message names the argument, struct member, scene key or file, its value, and what is allowed. Attributes:

    status: status code. name: name of the code in C ("TOLIMAN_E_RANGE"). field: name of the argument, member, scene key
    or file at fault, "" if there is none. outcomes: only after Tracker.push and push_many, the outcomes of the frames
    processed before the failure.
    """

    outcomes: list[typing.Any]

    def __init__(self, status: int, message: str, field: str = ""):
        super().__init__(message)
        self.status = status
        self.name = library.toliman_constant_name(status).decode()
        self.field = field

    def __str__(self):
        return self.args[0]

    def __reduce__(self):
        return type(self), (self.status, str(self), self.field)


class _FileError(Error, OSError):
    """An OSError. filename: the file. errno: the cause, found by examining the file after the failure; None if the file
    system no longer shows one."""

    def __init__(self, status: int, message: str, field: str = ""):
        super().__init__(status, message, field)
        self.filename = field or None
        reason = self._find_errno(field) if field else None
        if reason is not None:
            self.errno = reason

    def _find_errno(self, path: str) -> int | None:
        return _errno_of(path, os.R_OK)


def _errno_of(path: str, mode: int) -> int | None:
    try:
        os.stat(path)
    except OSError as error:
        return error.errno
    return None if os.access(path, mode) else errno.EACCES


class InputError(Error, ValueError):
    """An argument, scene or file has an invalid value, or two of them do not match; also a ValueError."""


class NotFoundError(_FileError, FileNotFoundError):
    """The file `filename` is missing or cannot be read; also a FileNotFoundError."""


class WriteError(_FileError):
    """The file `filename` cannot be written; also an OSError."""

    def _find_errno(self, path: str) -> int | None:
        return _errno_of(os.path.join(os.path.dirname(path) or ".", ""), os.W_OK)


class LostError(_FileError):
    """The file `filename` has lost data that it contained before: another program or the disk changed it."""


class NoMemoryError(Error, MemoryError):
    """Memory, or another resource of the system, is exhausted; also a MemoryError."""


class UnsupportedError(Error, NotImplementedError):
    """The request is valid but not supported by this version; also a NotImplementedError."""


class StateError(Error, RuntimeError):
    """The object is not ready for this call: too few samples, not trained yet, or in use by another call; also a
    RuntimeError."""


class CapacityError(Error):
    """A capacity fixed when the object was created is exhausted."""


class Cancelled(Error):
    """The progress callback asked to stop."""


for _kind in (Error, InputError, NotFoundError, WriteError, NoMemoryError, UnsupportedError, StateError, CapacityError,
              LostError, Cancelled):
    _kind.__module__ = "toliman"  # as who catches them writes it

_KINDS: dict[int, type[Error]] = {
    _raw.TOLIMAN_E_ARGUMENT: InputError,
    _raw.TOLIMAN_E_MEMORY: NoMemoryError,
    _raw.TOLIMAN_E_NOT_FOUND: NotFoundError,
    _raw.TOLIMAN_E_FORMAT: InputError,
    _raw.TOLIMAN_E_SCENE: InputError,
    _raw.TOLIMAN_E_UNSUPPORTED: UnsupportedError,
    _raw.TOLIMAN_E_WRITE: WriteError,
    _raw.TOLIMAN_E_CANCELLED: Cancelled,
    _raw.TOLIMAN_E_RANGE: InputError,
    _raw.TOLIMAN_E_MISMATCH: InputError,
    _raw.TOLIMAN_E_CAPACITY: CapacityError,
    _raw.TOLIMAN_E_STATE: StateError,
    _raw.TOLIMAN_E_LOST: LostError,
}


def check(status: int) -> None:
    """Raises the exception that belongs to a status code, unless it is TOLIMAN_OK."""
    if status != _raw.TOLIMAN_OK:
        raise _KINDS.get(status, Error)(status, library.toliman_last_error().decode(errors="replace"),
                                        os.fsdecode(library.toliman_last_error_field()))


def check_asked(status: int) -> None:
    """The same for a call that asks for the number of results: TOLIMAN_E_CAPACITY is the answer that there are some."""
    if status != _raw.TOLIMAN_E_CAPACITY:
        check(status)


def above(levels: int) -> pathlib.Path:
    """Returns the folder `levels` above this package's folder, or the root."""
    folder = pathlib.Path(__file__).parent.resolve()  # in a build folder, the file is a link to the sources
    return [folder, *folder.parents][min(levels, len(folder.parents))]


def _candidates() -> typing.Iterator[str]:
    """Yields the places to look for the library: TOLIMAN_LIBRARY alone if it is set; else the package's folder (as in a
    wheel), the installation prefix, the build folder, Python's prefix, and the loader's search
    path."""
    if os.environ.get("TOLIMAN_LIBRARY"):
        yield os.environ["TOLIMAN_LIBRARY"]
        return
    yield str(above(0) / SONAME)
    yield str(above(3) / SONAME)  # installed: lib/python3/dist-packages/toliman
    yield str(above(2) / "lib" / SONAME)  # a build folder: python/toliman
    yield str(pathlib.Path(sys.prefix).resolve() / "lib" / SONAME)
    yield SONAME


def _load() -> ctypes.CDLL:
    tried = []
    for path in dict.fromkeys(_candidates()):
        try:
            return ctypes.CDLL(path)
        except OSError as error:
            tried.append(str(error) if path in str(error) else f"{path}: {error}")
    raise ImportError(f"{SONAME} was not found: build it, install it, or set TOLIMAN_LIBRARY to its path. Tried:\n  "
                      + "\n  ".join(tried))


def _refuse(found: ctypes.CDLL, why: str) -> typing.NoReturn:
    raise ImportError(f"{found._name} does not fit these bindings, which are of version {_raw.TOLIMAN_VERSION}: {why}. "
                      "Set TOLIMAN_LIBRARY to the path of a matching library")


def _fit(found: ctypes.CDLL) -> ctypes.CDLL:
    """Declares the functions' types and checks the ABI number and the size of every struct; ImportError if they differ.
    Structs larger than ours are allowed: a newer library only appends members."""
    try:
        _raw.declare(found)
    except AttributeError as error:
        _refuse(found, str(error))
    if found.toliman_abi_version() != _raw.TOLIMAN_ABI_VERSION:
        _refuse(found, f"its ABI is {found.toliman_abi_version()}, expected {_raw.TOLIMAN_ABI_VERSION}")
    for name, kind in vars(_raw).items():
        if isinstance(kind, type) and issubclass(kind, ctypes.Structure) and getattr(kind, "_fields_", None):
            size = found.toliman_get_struct_size(name.encode())
            if name != "Sized" and size < ctypes.sizeof(kind):
                _refuse(found, f"its {name} has {size} bytes, expected {ctypes.sizeof(kind)}")
    return found


_found = _fit(_load())


def _functions() -> types.SimpleNamespace:
    """Returns the library's functions; those that take objects hold the objects' locks."""
    functions = {name: getattr(_found, name) for name in _raw.FUNCTIONS}
    functions.update((name, locked(functions[name], changes)) for name, changes in _raw.OF_OBJECTS.items())
    return types.SimpleNamespace(**functions)


library = _functions()


def version() -> str:
    """Returns the version of the loaded library, such as "0.3.0"."""
    return library.toliman_version().decode()


def netcdf_version() -> str:
    """Returns the version of netCDF, which reads batches of frames, such as "4.9.0"; "" if there is none."""
    return library.toliman_ingest_netcdf_version().decode()


def abi_version() -> int:
    """Returns the number of the binary interface (ABI) of the loaded library."""
    return library.toliman_abi_version()


def library_path() -> str:
    """Returns the path from which the library was loaded; a bare file name if the system's loader found it."""
    return _found._name
