"""Serialises calls on one C object: reader-writer locks, so that threads wait instead of getting TOLIMAN_E_STATE.

The C library never waits: a call that another call excludes fails at once. Python threads usually expect to wait, so
each object has a lock that const functions share and all others hold exclusively.
"""
from __future__ import annotations

import contextlib
import threading
import typing

_thread = threading.local()  # .callbacks: number of callbacks from C that this thread is running, nested


@contextlib.contextmanager
def in_callback() -> typing.Iterator[None]:
    """Marks code that C calls. Calls made there take no lock: waiting for the call that runs the callback would be a
    deadlock. C itself refuses what that call excludes."""
    _thread.callbacks = getattr(_thread, "callbacks", 0) + 1
    try:
        yield
    finally:
        _thread.callbacks -= 1


class ReadWriteLock:
    """A reader-writer lock of one C object. Readers are not held back by a waiting writer."""

    def __init__(self) -> None:
        self._condition, self._calls = threading.Condition(), 0  # number of readers; -1: one writer

    def acquire(self, exclusive: bool) -> None:
        """Waits until the running calls allow this one."""
        with self._condition:
            while self._calls < 0 or (exclusive and self._calls > 0):
                self._condition.wait()
            self._calls = -1 if exclusive else self._calls + 1

    def release(self) -> None:
        """Releases what acquire() took."""
        with self._condition:
            self._calls = 0 if self._calls < 0 else self._calls - 1
            self._condition.notify_all()


def locked(function: typing.Callable[..., typing.Any], changes: bool) -> typing.Callable[..., typing.Any]:
    """Wraps a C function so that it holds the locks of its objects.

    changes: the function modifies its first object, whose lock is then exclusive; those of all others are shared. Locks
    are acquired in the order of their ids, so that two calls on the same objects cannot deadlock.
    """

    def call(*arguments: typing.Any) -> typing.Any:
        if getattr(_thread, "callbacks", 0) > 0:
            return function(*arguments)
        locks: dict[ReadWriteLock, bool] = {}
        for place, argument in enumerate(arguments):
            lock = getattr(argument, "lock", None)
            if lock is not None:
                locks[lock] = locks.get(lock, False) or (changes and place == 0)
        with contextlib.ExitStack() as stack:
            for lock in sorted(locks, key=id):
                lock.acquire(locks[lock])
                stack.callback(lock.release)
            return function(*arguments)

    call.__name__, call.__doc__ = function.__name__, function.__doc__
    return call
