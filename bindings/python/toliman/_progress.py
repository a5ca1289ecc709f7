"""Progress reports and cancellation of long calls: callbacks, progress bars, Ctrl-C."""
from __future__ import annotations

import html
import itertools
import os
import signal
import sys
import threading
import time
import typing

from . import _raw
from ._library import Cancelled, check
from ._lock import in_callback

# Called with the stage, such as "frames" or "train: epoch 3 of 300", and the fraction done in [0, 1]. A true return
# value cancels the call.
Progress = typing.Callable[[str, float], typing.Any]


class _Lines:
    """One line per finished stage, for a file or a pipe."""

    _finished = ""

    def show(self, stage: str, fraction: float) -> None:
        if fraction >= 1 and stage != self._finished:
            print(_text(stage, fraction), file=sys.stderr, flush=True)
            self._finished = stage

    def close(self) -> None:
        pass


class _Terminal:
    """One line of a terminal, drawn again."""

    _shown = ""

    def show(self, stage: str, fraction: float) -> None:
        text = _text(stage, fraction)[:_columns() - 1]  # a wrapped line could not be drawn again
        print("\r" + text.ljust(len(self._shown)), end="", file=sys.stderr, flush=True)
        self._shown = text

    def close(self) -> None:
        if self._shown:
            print(file=sys.stderr)


class _Notebook:
    """A bar below the cell of a notebook."""

    def __init__(self) -> None:
        from IPython.display import HTML, display  # type: ignore[import]
        self._html, self._display = HTML, display(HTML(""), display_id=True)

    def show(self, stage: str, fraction: float) -> None:
        self._display.update(self._html(f"<progress value='{fraction:.4f}'></progress> {html.escape(stage)}"))

    def close(self) -> None:
        pass


class _Tqdm:
    """A bar of tqdm, with the remaining time, in a terminal or a notebook."""

    def __init__(self, kind: typing.Any) -> None:
        self._bar = kind(total=1.0, bar_format="{desc}: {percentage:3.0f}% |{bar}| {elapsed}<{remaining}")

    def show(self, stage: str, fraction: float) -> None:
        if fraction < self._bar.n:  # of the next stage
            self._bar.reset()
        self._bar.set_description_str(stage, refresh=False)
        self._bar.update(fraction - self._bar.n)
        self._bar.refresh()

    def close(self) -> None:
        self._bar.close()


def _view() -> typing.Any:
    """Returns the best of these for where the program runs."""
    in_notebook = _is_notebook()
    if not (in_notebook or sys.stderr.isatty()):
        return _Lines()
    try:
        from tqdm.auto import tqdm  # type: ignore[import]
        return _Tqdm(tqdm)
    except ImportError:
        return _Notebook() if in_notebook else _Terminal()


def _is_notebook() -> bool:
    try:
        from IPython import get_ipython  # type: ignore[import]
    except ImportError:
        return False
    shell = get_ipython()
    return shell is not None and bool(shell.has_trait("kernel"))


def _text(stage: str, fraction: float) -> str:
    return f"{100 * fraction:3.0f} % {stage}"


def _columns() -> int:
    """Returns the current width of the terminal on stderr, or 80 if unknown."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (OSError, ValueError):
        return 80


class Bar:
    """Shows progress; created by progress=True. On a terminal and in a notebook a bar, of tqdm if it is installed; a file
    or pipe gets one line per finished stage."""

    def __init__(self) -> None:
        self._stage, self._next, self._view = "", 0.0, _view()

    def __call__(self, stage: str, fraction: float) -> None:
        now, self._stage = time.monotonic(), stage
        if now >= self._next or fraction >= 1:
            self._next = now + 0.1
            self._view.show(stage, fraction)

    def close(self, succeeded: bool) -> None:
        if succeeded and self._stage:
            self._view.show(self._stage, 1)
        self._view.close()


class Watch:
    """Reports the progress of calls and re-raises exceptions of callbacks, KeyboardInterrupt included.

    An exception cannot propagate through C. A callback therefore stores it and returns "cancel"; check() raises it once
    the C call has returned.

    with Watch(progress) as watch:
        options.progress = watch.callback
        watch.check(library.toliman_...)
    """

    def __init__(self, progress: Progress | bool | None):
        self._bar = Bar() if progress is True else None
        self._progress: typing.Any = self._bar if progress is True else progress or None
        self._raised: BaseException | None = None
        self._before: typing.Any = None  # the previous SIGINT handler
        self._outside = False  # running the user's callback, which Ctrl-C may interrupt directly
        self.callback = _raw.toliman_progress_fn(self._call)

    def _call(self, stage: bytes, fraction: float, _: object) -> int:
        if self.run(lambda: int(self.show(stage.decode(errors="replace"), fraction))):
            return 1
        return int(self._raised is not None)

    def show(self, stage: str, fraction: float) -> bool:
        """Calls the user's progress function or the bar; whether it asks to stop."""
        return bool(callable(self._progress) and self._progress(stage, fraction))

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C was pressed or a callback raised since the last check()."""
        return self._raised is not None

    def run(self, work: typing.Callable[..., int], *arguments: typing.Any) -> int:
        """Runs the user's code inside a callback from C; stores the first exception for check() and returns
        TOLIMAN_E_CANCELLED."""
        try:
            self._outside = True
            with in_callback():
                return work(*arguments)
        except BaseException as raised:
            self._raised = self._raised or raised
            return _raw.TOLIMAN_E_CANCELLED
        finally:
            self._outside = False

    def take(self, items: typing.Iterator[typing.Any], most: int) -> tuple[list[typing.Any], BaseException | None]:
        """Returns up to `most` items of the user's iterator, which Ctrl-C interrupts at once, and the exception that it
        raised after them."""
        taken: list[typing.Any] = []
        try:
            self._outside = True
            for item in itertools.islice(items, most):
                taken.append(item)
        except BaseException as raised:
            return taken, raised
        finally:
            self._outside = False
        return taken, None

    def step(self, stage: str, fraction: float) -> None:
        """Reports progress between the C calls of work that Python splits; raises Cancelled if progress asks to
        stop."""
        self.check(_raw.TOLIMAN_OK)
        if self.show(stage, fraction):
            raise Cancelled(_raw.TOLIMAN_E_CANCELLED, f"{stage}: cancelled")

    def check(self, status: int) -> None:
        """Raises the exception stored by a callback, else the exception of a failed status."""
        raised, self._raised = self._raised, None
        if raised is not None:
            raise raised
        check(status)

    def _interrupt(self, *_: object) -> None:
        if self._outside:
            raise KeyboardInterrupt
        self._raised = self._raised or KeyboardInterrupt()

    def __enter__(self) -> Watch:
        # Without this handler Python raises KeyboardInterrupt before the callback's first statement, where no code of
        # ours can catch it, and ctypes drops it.
        if threading.current_thread() is threading.main_thread():
            if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
                self._before = signal.signal(signal.SIGINT, self._interrupt)
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
            self._before = None
        if self._bar is not None:
            self._bar.close(kind is None)
        if kind is None:
            self.check(_raw.TOLIMAN_OK)
