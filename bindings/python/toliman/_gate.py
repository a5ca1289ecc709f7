"""Threads in one object: calls that change it run alone, others side by side; who comes too early waits."""
from __future__ import annotations

import contextlib
import threading
import typing

_here = threading.local()  # callbacks: how deep this thread is in code that C calls


@contextlib.contextmanager
def in_callback() -> typing.Iterator[None]:
    """Code that C calls. It never waits for the call that runs it: C refuses what that call excludes."""
    _here.callbacks = getattr(_here, "callbacks", 0) + 1
    try:
        yield
    finally:
        _here.callbacks -= 1


class Gate:
    """Of one C object."""

    def __init__(self) -> None:
        self._condition, self._calls = threading.Condition(), 0  # calls that change nothing; -1: one that changes it

    def enter(self, changes: bool) -> None:
        """Waits until the calls that run allow this one."""
        with self._condition:
            while self._calls < 0 or (changes and self._calls > 0):
                self._condition.wait()
            self._calls = -1 if changes else self._calls + 1

    def leave(self) -> None:
        with self._condition:
            self._calls = 0 if self._calls < 0 else self._calls - 1
            self._condition.notify_all()


def gated(function: typing.Callable[..., typing.Any], changes: bool) -> typing.Callable[..., typing.Any]:
    """A function of C that waits at the gates of its objects. changes: its first object. Gates are entered in one order,
    so that no two calls wait for each other."""

    def call(*arguments: typing.Any) -> typing.Any:
        if getattr(_here, "callbacks", 0) > 0:
            return function(*arguments)
        gates: dict[Gate, bool] = {}
        for place, argument in enumerate(arguments):
            gate = getattr(argument, "gate", None)
            if gate is not None:
                gates[gate] = gates.get(gate, False) or (changes and place == 0)
        with contextlib.ExitStack() as stack:
            for gate in sorted(gates, key=id):
                gate.enter(gates[gate])
                stack.callback(gate.leave)
            return function(*arguments)

    call.__name__, call.__doc__ = function.__name__, function.__doc__
    return call
