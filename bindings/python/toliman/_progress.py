"""Progress of long calls, and the way out of them."""
from __future__ import annotations

import html
import os
import signal
import sys
import threading
import time
import typing

from . import _raw
from ._gate import in_callback
from ._library import Cancelled, check

# Called with a stage, as "frames" or "train: epoch 3 of 300", and the fraction done; a true answer stops.
Progress = typing.Callable[[str, float], typing.Any]


def _columns() -> int:
    """Columns of the terminal on stderr now, 80 where it does not know."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (OSError, ValueError):
        return 80


class Bar:
    """A line on a terminal, else a line a finished stage on stderr, or a bar in a notebook; progress=True makes one."""

    def __init__(self) -> None:
        self._shown, self._told, self._stage, self._next, self._html = "", "", "", 0.0, None
        try:
            from IPython import get_ipython  # type: ignore[import]
            from IPython.display import HTML, display  # type: ignore[import]
            shell = get_ipython()
            if shell is not None and shell.has_trait("kernel"):
                self._html, self._display = HTML, display(HTML(""), display_id=True)
        except ImportError:
            pass

    def __call__(self, stage: str, fraction: float) -> None:
        now, self._stage = time.monotonic(), stage
        if now >= self._next or fraction >= 1:
            self._next = now + 0.1
            self._show(stage, fraction)

    def _show(self, stage: str, fraction: float) -> None:
        if self._html is not None:
            self._display.update(self._html(f"<progress value='{fraction:.4f}'></progress> {html.escape(stage)}"))
            return
        text = f"{100 * fraction:3.0f} % {stage}"
        if not sys.stderr.isatty():
            if fraction >= 1 and stage != self._told:
                print(text, file=sys.stderr, flush=True)
                self._told = stage
            return
        text = text[:_columns() - 1]  # a line that wraps could not be drawn over
        print("\r" + text.ljust(len(self._shown)), end="", file=sys.stderr, flush=True)
        self._shown = text

    def close(self, succeeded: bool) -> None:
        if succeeded and self._stage:
            self._show(self._stage, 1)
        if self._shown:
            print(file=sys.stderr)


class Watch:
    """Shows the progress of the calls made within it and lets what its callbacks raise, as KeyboardInterrupt, through.

    with Watch(progress) as watch:
        options.progress = watch.callback
        watch.check(library.toliman_...)
    """

    def __init__(self, progress: Progress | bool | None):
        self._bar = Bar() if progress is True else None
        self._progress = self._bar if progress is True else progress or None
        self._raised: BaseException | None = None
        self._before: typing.Any = None  # the handler of Ctrl-C
        self._outside = False  # in code of the caller's, which Ctrl-C may break off
        self.callback = _raw.toliman_progress_fn(self._call)

    def _call(self, stage: bytes, fraction: float, _: object) -> int:
        progress: typing.Any = self._progress
        if callable(progress) and self.run(lambda: int(bool(progress(stage.decode(errors="replace"), fraction)))):
            return 1
        return int(self._raised is not None)

    def run(self, work: typing.Callable[..., int], *arguments: typing.Any) -> int:
        """Code of the caller's that C calls. C cannot carry what it raises: check() raises the first of it again."""
        try:
            self._outside = True
            with in_callback():
                return work(*arguments)
        except BaseException as raised:
            self._raised = self._raised or raised
            return _raw.TOLIMAN_E_CANCELLED
        finally:
            self._outside = False

    def step(self, stage: str, fraction: float) -> None:
        """Progress of work that is done in parts by Python."""
        self.check(_raw.TOLIMAN_OK)
        if self._progress and self._progress(stage, fraction):
            raise Cancelled(_raw.TOLIMAN_E_CANCELLED, f"{stage}: cancelled")

    def check(self, status: int) -> None:
        """Raises what a callback raised, or the Error of a call that failed."""
        raised, self._raised = self._raised, None
        if raised is not None:
            raise raised
        check(status)

    def _interrupt(self, *_: object) -> None:
        if self._outside:
            raise KeyboardInterrupt
        self._raised = self._raised or KeyboardInterrupt()

    def __enter__(self) -> Watch:
        # Python would raise it in front of the callback's first statement, where nothing can catch it.
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
