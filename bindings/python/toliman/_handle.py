"""What all objects share: they own a pointer of C, which is freed when nobody uses it any more."""
from __future__ import annotations

import contextlib
import ctypes
import typing
import weakref

from . import _raw
from ._gate import Gate
from ._library import check, library
from ._shown import Result


def _free(end: str, kind: type, address: int, keep: object) -> None:
    """Ends a C object; `keep`, what it points to, lives until here."""
    if kind is _raw.toliman_track:  # what was told to be accepted is not lost with its tracker
        library.toliman_track_commit(ctypes.cast(address, ctypes.POINTER(kind)))
    getattr(library, end)(ctypes.cast(address, ctypes.POINTER(kind)))


Self = typing.TypeVar("Self", bound="Handle")


class Handle:
    """Owns a C object; close(), a with statement or the garbage collector frees it, at the end of the calls that run in
    other threads. Threads may share it: a call that changes it waits until others end, and these wait for it. A call from
    a callback of its own call does not wait: it fails, unless both only read."""

    _kind: type  # of _raw
    _end: str = ""  # the C function that frees it; none of what belongs to another object

    def __init__(self, pointer: typing.Any):
        self._pointer = pointer
        self._busy = False

    @classmethod
    def _adopt(cls, pointer: typing.Any):
        """An object of a pointer that C made."""
        self = cls.__new__(cls)
        Handle.__init__(self, pointer)
        return self

    @classmethod
    def _made(cls, create: typing.Any, *arguments: typing.Any, keep: object = None,
              check: typing.Callable[[int], None] = check) -> typing.Any:
        """The pointer that a create or load function of C gives as its last argument. It owns the object: calls hold it,
        and so do the pointers of objects that need this one. keep: what must live as long."""
        made: typing.Any = ctypes.POINTER(cls._kind)()
        made.gate = Gate()
        check(create(*arguments, ctypes.byref(made)))
        if cls._end:
            address = ctypes.c_void_p.from_buffer(made).value or 0  # cast() would make it refer to itself
            finalizer = weakref.finalize(made, _free, cls._end, cls._kind, address, keep)
            finalizer.atexit = cls._kind is _raw.toliman_track  # others may be at work in daemon threads
        else:
            made.keep, made.gate = keep, getattr(keep, "gate", made.gate)
        return made

    @property
    def _c(self) -> typing.Any:
        if self._pointer is None:
            raise ValueError(f"this {type(self).__name__} is closed")
        return self._pointer

    def _read(self, function: typing.Any, struct: type, result: type[Result]) -> typing.Any:
        """What a function with one struct as its result tells."""
        filled = struct()
        check(function(self._c, ctypes.byref(filled)))
        return result._of(filled)

    @contextlib.contextmanager
    def _alone(self) -> typing.Iterator[None]:
        """Work that may not be asked for again from its own callbacks."""
        if self._busy:
            raise RuntimeError(f"this {type(self).__name__} is being trained")
        self._busy = True
        try:
            yield
        finally:
            self._busy = False

    def close(self) -> None:
        """Frees the memory; the object is of no use afterwards."""
        self._pointer = None

    def _told(self) -> str:
        """What repr() says of an open object."""
        return type(self).__name__

    def __repr__(self) -> str:
        try:
            return f"<{self._told()}>"
        except ValueError:
            return f"<closed {type(self).__name__}>"

    def __bool__(self) -> bool:
        return True

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> typing.Any:
        raise TypeError(f"a {type(self).__name__} cannot be pickled: make it anew where it is needed")
