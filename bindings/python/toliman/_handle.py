"""Base class of all objects: owns a pointer to a C object and destroys it once nothing uses it any more."""
from __future__ import annotations

import contextlib
import ctypes
import html
import typing
import weakref

from . import _raw
from ._library import check, library
from ._lock import ReadWriteLock
from ._result_base import Result
from ._shown import public_name


def _free(destroy: str, kind: type, address: int, keep: object) -> None:
    """Destroys a C object. The argument `keep` holds what the object points to, which must live until here."""
    if kind is _raw.toliman_track:  # frames reported as accepted must not be lost with an unclosed Tracker
        library.toliman_track_commit(ctypes.cast(address, ctypes.POINTER(kind)))
    getattr(library, destroy)(ctypes.cast(address, ctypes.POINTER(kind)))


Self = typing.TypeVar("Self", bound="Handle")


class Handle:
    """Owns a C object.

    close(), a with statement or the garbage collector destroys it, after the calls still running in other threads.
    Threads may share an object: a call that modifies it runs alone, others run concurrently, and whichever comes second
    waits. A call from a callback of the object's own running call does not wait: it raises, unless both only read.
    """

    _kind: type  # the handle type in _raw
    _destroy: str = ""  # the C function that destroys the object; "" if another object owns it

    def __init__(self, pointer: typing.Any):
        self._pointer = pointer
        self._busy = False

    @classmethod
    def _adopt(cls, pointer: typing.Any):
        """Wraps a pointer returned by _create()."""
        self = cls.__new__(cls)
        Handle.__init__(self, pointer)
        return self

    @classmethod
    def _create(cls, create: typing.Any, *arguments: typing.Any, keep: object = None,
                check: typing.Callable[[int], None] = check) -> typing.Any:
        """Calls a create or load function of C and returns the pointer that it writes to its last argument.

        The pointer owns the object: running calls hold a reference to it, and so do the pointers of objects that need
        this one, so that closing an object in one thread cannot free it under a call in another. keep: an object that
        must live as long.
        """
        pointer: typing.Any = ctypes.POINTER(cls._kind)()
        pointer.lock = ReadWriteLock()
        check(create(*arguments, ctypes.byref(pointer)))
        if cls._destroy:
            # ctypes.cast() would keep a reference to the pointer, which then would never be collected.
            address = ctypes.c_void_p.from_buffer(pointer).value or 0
            finalizer = weakref.finalize(pointer, _free, cls._destroy, cls._kind, address, keep)
            # At exit only trackers are finalised, to commit: daemon threads may still use other objects.
            finalizer.atexit = cls._kind is _raw.toliman_track
        else:
            pointer.keep, pointer.lock = keep, getattr(keep, "lock", pointer.lock)
        return pointer

    @property
    def _name(self) -> str:
        return public_name(type(self))

    @property
    def _c(self) -> typing.Any:
        """The C pointer; ValueError once the object is closed."""
        if self._pointer is None:
            raise ValueError(f"this {self._name} is closed")
        return self._pointer

    def _read(self, function: typing.Any, struct: type, result: type[Result], *arguments: typing.Any) -> typing.Any:
        """Calls a C function that fills one struct, its last argument, and converts the struct to a result."""
        filled = struct()
        check(function(self._c, *arguments, ctypes.byref(filled)))
        return result._of(filled)

    @contextlib.contextmanager
    def _exclusive(self) -> typing.Iterator[None]:
        """Raises RuntimeError if a callback of this work starts the same work again."""
        if self._busy:
            raise RuntimeError(f"this {self._name} is being trained")
        self._busy = True
        try:
            yield
        finally:
            self._busy = False

    def close(self) -> None:
        """Destroys the object and frees its memory; later calls raise ValueError. Closing twice is allowed."""
        self._pointer = None

    @property
    def _is_open(self) -> bool:
        try:
            return self._c is not None
        except ValueError:
            return False

    def _summary(self) -> str:
        """Text of repr() for an open object."""
        return self._name

    def __repr__(self) -> str:
        return f"<{self._summary()}>" if self._is_open else f"<closed {self._name}>"

    def _repr_html_(self) -> str:
        """The properties of an open object; a notebook shows them."""
        info = getattr(self, "info", None) if self._is_open else None
        return f"<p>{html.escape(repr(self))}</p>" + (info._repr_html_() if isinstance(info, Result) else "")

    def __bool__(self) -> bool:
        return True

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> typing.Any:
        raise TypeError(f"a {self._name} cannot be pickled: create it in each process")
