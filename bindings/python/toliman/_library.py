"""Finds libtoliman.so, once, and turns its failures into exceptions."""
from __future__ import annotations

import ctypes
import errno
import os
import pathlib
import sys
import types
import typing

from . import _raw
from ._gate import gated

SONAME = f"libtoliman.so.{_raw.TOLIMAN_VERSION_MAJOR}.{_raw.TOLIMAN_VERSION_MINOR}"


class Error(Exception):
    """A failed library call: the message says what was wrong; `status` is the code, `name` its name in C; `field` names
    the argument, member, key of a scene or file that was wrong, "" where there is none; `outcomes`, of
    Tracker.push_many, what became of the frames before."""

    outcomes: list[typing.Any]

    def __init__(self, status: int, message: str, field: str = ""):
        super().__init__(message)
        self.status = status
        self.name = library.toliman_status_name(status).decode()
        self.field = field

    def __str__(self):
        return self.args[0]

    def __reduce__(self):
        return type(self), (self.status, str(self), self.field)


class _FileError(Error, OSError):
    """An OSError: `filename` is the file, `errno` the reason where the file system still shows it, else None."""

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
    """An argument, scene or file that says something impossible, or two that do not belong together."""


class NotFoundError(_FileError, FileNotFoundError):
    """A file, `filename`, that is missing or cannot be read."""


class WriteError(_FileError):
    """A file, `filename`, that cannot be written."""

    def _find_errno(self, path: str) -> int | None:
        return _errno_of(os.path.join(os.path.dirname(path) or ".", ""), os.W_OK)


class LostError(_FileError):
    """A file, `filename`, that no longer has what it had: another program or the disk has changed it."""


class NoMemoryError(Error, MemoryError):
    """Out of memory."""


class UnsupportedError(Error, NotImplementedError):
    """Valid, but this version cannot do it."""


class StateError(Error, RuntimeError):
    """The object is not ready for this call: too few samples, nothing trained yet, or in use by another call."""


class CapacityError(Error):
    """A capacity that was fixed when the object was made is used up."""


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
    """Raises the Error of a call that failed."""
    if status != _raw.TOLIMAN_OK:
        raise _KINDS.get(status, Error)(status, library.toliman_last_error().decode(errors="replace"),
                                        os.fsdecode(library.toliman_last_error_field()))


def above(levels: int) -> pathlib.Path:
    """The folder so many levels above this package's."""
    parents = pathlib.Path(__file__).resolve().parents
    return parents[min(levels, len(parents) - 1)]


def _candidates() -> typing.Iterator[str]:
    """Where the library may be: as it was told, beside these files, in their prefix or source tree, in Python's prefix,
    and wherever the system looks."""
    if os.environ.get("TOLIMAN_LIBRARY"):
        yield os.environ["TOLIMAN_LIBRARY"]
        return
    yield str(above(0) / SONAME)
    yield str(above(3) / SONAME)  # installed: lib/python3/dist-packages/toliman
    yield str(above(3) / "build" / "lib" / SONAME)  # the source tree
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
                      "Set TOLIMAN_LIBRARY to the path of one that does")


def _fit(found: ctypes.CDLL) -> ctypes.CDLL:
    """The library with the types of its functions, or ImportError if it is not of this table."""
    try:
        _raw.declare(found)
    except AttributeError as error:
        _refuse(found, str(error))
    if found.toliman_abi_version() != _raw.TOLIMAN_ABI_VERSION:
        _refuse(found, f"its ABI is {found.toliman_abi_version()}, theirs {_raw.TOLIMAN_ABI_VERSION}")
    for name, kind in vars(_raw).items():
        if isinstance(kind, type) and issubclass(kind, ctypes.Structure) and getattr(kind, "_fields_", None):
            size = found.toliman_get_struct_size(name.encode())
            if name != "Sized" and size < ctypes.sizeof(kind):
                _refuse(found, f"its {name} has {size} bytes, theirs {ctypes.sizeof(kind)}")
    return found


_found = _fit(_load())


def _functions() -> types.SimpleNamespace:
    """Functions of the library; those of objects wait for their turn."""
    made = {name: getattr(_found, name) for name in _raw.FUNCTIONS}
    made.update((name, gated(made[name], changes)) for name, changes in _raw.OF_OBJECTS.items())
    return types.SimpleNamespace(**made)


library = _functions()


def version() -> str:
    """Version of the library, such as "0.1.0"."""
    return library.toliman_version().decode()


def abi_version() -> int:
    """Number of the binary interface."""
    return library.toliman_abi_version()


def library_path() -> str:
    """Where the library was found; a bare name is one that the system found."""
    return _found._name
