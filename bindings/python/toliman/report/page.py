"""The page: texts, tables and figures in their order, written as one HTML file and the figures' own files."""
from __future__ import annotations

import base64
import contextlib
import dataclasses
import fcntl
import os
import pathlib
import re
import signal
import stat
import threading
import typing

import jinja2
from matplotlib.figure import Figure

from . import style
from .results import OUTPUT, Failure, Result, readable

MARK = ('<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="generator" content="toliman report">\n')  # by which a page is known to be replaceable
_FIGURE = re.compile(r'<figure id="([A-Za-z0-9-]+)">\n<img alt="\1" ')


@dataclasses.dataclass(frozen=True)
class Block:
    """A part of the page; the template shows it by its kind: title, heading, text, found, figure or table."""

    kind: str
    text: str
    name: str = ""
    svg: str = ""
    heads: typing.Sequence[str] = ()
    rows: typing.Sequence[typing.Sequence[str]] = ()


class Page:
    """Collects what the sections add; write() makes the files. All texts are plain: the template escapes them."""

    def __init__(self, folder: pathlib.Path, formats: typing.Sequence[str] = ("svg",), force: bool = False):
        self.folder, self.formats, self.force = folder, formats, force
        self.prefix = ""
        self.blocks: list[Block] = []
        self.words: dict[str, str] = {}
        self.files: dict[str, bytes] = {}
        self._names: set[str] = set()

    def add(self, kind: str, text: str) -> None:
        """Adds a title, heading, text, or `found`: the text with the result."""
        self.blocks.append(Block(kind, readable(text)))

    def add_figure(self, name: str, figure: Figure, caption: str) -> None:
        """Draws a figure at once; a second one of a name gets a number."""
        name = self._unique(re.sub("[^A-Za-z0-9-]", "-", self.prefix + name))
        files = {kind: style.drawn(figure, kind) for kind in self.formats}
        self.files.update((f"{name}.{kind}", data) for kind, data in files.items())
        svg = base64.b64encode(files["svg"]).decode()
        self.blocks.append(Block("figure", readable(caption), name, svg))

    def _unique(self, name: str) -> str:
        tried, number = name, 1
        while tried in self._names:
            number += 1
            tried = f"{name}-{number}"
        self._names.add(tried)
        return tried

    def add_table(self, caption: str, heads: typing.Sequence[str], rows: typing.Sequence[typing.Sequence[str]]) -> None:
        """Adds a table: the first column is text, the others are numbers."""
        cells = [[readable(cell) for cell in row] for row in rows]
        self.blocks.append(Block("table", readable(caption), heads=heads, rows=cells))

    def explain(self, words: typing.Mapping[str, str]) -> None:
        """Adds terms and their meanings to the glossary at the end of the page, each once."""
        for name, meaning in words.items():
            self.words.setdefault(readable(name), readable(meaning))

    def html(self) -> str:
        """Returns the page as text."""
        here = jinja2.Environment(loader=jinja2.PackageLoader(__name__.rpartition(".")[0], "."), autoescape=True,
                                  trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
        title = next((block.text for block in self.blocks if block.kind == "title"), "toliman report")
        return MARK + here.get_template("page.html").render(title=title, blocks=self.blocks, words=self.words) + "\n"

    def write(self) -> pathlib.Path:
        """Writes all files or none, the page last, removes figures of the page that it replaces; returns its path."""
        path, inner = self.folder / "report.html", self.folder / "figures"
        before = _figures_of(path)
        owned = {inner / f"{name}.{kind}" for name in before for kind in style.FORMATS}
        files = {inner / name: data for name, data in self.files.items()}
        for target in () if self.force else (path, *files):
            if target not in owned and not (target == path and _is_page(path)):
                _check_free(target)
        with signals_deferred() as received:
            if self._replace(path, inner, files, received):
                for old in owned - set(files):
                    old.unlink(missing_ok=True)
        return path

    def _replace(self, path: pathlib.Path, inner: pathlib.Path, files: dict[pathlib.Path, bytes],
                 received: list[int]) -> bool:
        """Writes all files, the page last, or none if a signal was received before the last is written; whether it did."""
        made = [folder for folder in (self.folder, inner) if _make(folder)]
        written: list[tuple[_Temporary, pathlib.Path]] = []
        try:
            for target, data in [*files.items(), (path, self.html().encode())]:
                if received:
                    return False
                written.append((_Temporary(target, data), target.resolve()))
            for temporary, target in written:
                os.replace(temporary.path, target)
            made.clear()
            return True
        except OSError as error:
            raise Failure(OUTPUT, f"{readable(target)}: cannot be written: {error.strerror}") from None
        finally:
            for temporary, _ in written:
                temporary.close()
            for folder in reversed(made):
                folder.rmdir()


@contextlib.contextmanager
def signals_deferred() -> typing.Iterator[list[int]]:
    """Signals that Python code handles are handled after the block, which gets the list of them: it completes its files or
    removes them. Python allows this on the main thread, which alone handles signals."""
    numbers = [number for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
               if callable(signal.getsignal(number)) and threading.current_thread() is threading.main_thread()]
    received: list[int] = []
    before = {number: signal.signal(number, lambda number, _: received.append(number)) for number in numbers}
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if received:
        signal.raise_signal(received[0])


def add_provenance(page: Page, result: Result) -> None:
    """Adds command, date, processor and version of a result; results of earlier versions have the last only."""
    keys = ("command", "date", "processor") if result.has("provenance") else ()
    parts = [result.text("provenance." + key) for key in keys]
    page.add("provenance", " · ".join([*parts, "libtoliman " + result.text("version")]))


def _figures_of(path: pathlib.Path) -> list[str]:
    """Figures of a page that another report left, also of an earlier version."""
    return _FIGURE.findall(_text(path))


def _is_page(path: pathlib.Path) -> bool:
    return _text(path).startswith(MARK) or bool(_figures_of(path))


def _text(path: pathlib.Path) -> str:
    try:
        return path.read_text(errors="replace") if path.is_file() else ""
    except OSError:
        return ""


def _make(folder: pathlib.Path) -> bool:
    """Makes a folder; false if it exists."""
    try:
        folder.mkdir()
        return True
    except FileExistsError:
        pass
    except OSError as error:
        raise Failure(OUTPUT, f"{readable(folder)}: cannot be created: {error.strerror}") from None
    if not folder.is_dir():
        raise Failure(OUTPUT, f"{readable(folder)}: is not a folder")
    return False


def _check_free(target: pathlib.Path) -> None:
    if target.exists() and not (target.is_file() and target.stat().st_size == 0):
        raise Failure(OUTPUT, f"{readable(target)}: exists and was not written by toliman: give --force to replace it")


class _Temporary:
    """Data next to its target, in a file that is locked until close(), which removes it unless it was renamed. Files that
    are not locked were left by processes that died; they are removed. As lib/backend/temporary.cpp."""

    def __init__(self, target: pathlib.Path, data: bytes) -> None:
        target = target.resolve()
        names = [target.with_name(f"{target.name}.{number}.tmp") for number in range(100)]
        for name in names:
            _remove_if_stale(name)
        for self.path in names:
            try:
                self.file = open(self.path, "xb", buffering=0)
            except FileExistsError:
                continue
            if _try_lock(self.file) and _has_name(self.file, self.path):
                break
            self.file.close()
        else:
            raise Failure(OUTPUT, f"{readable(target)}: cannot be written: 100 temporary files are in the way")
        try:
            view = memoryview(data)
            while view:
                view = view[self.file.write(view):]
            os.fsync(self.file.fileno())
            if target.exists():
                self.path.chmod(target.stat().st_mode & 0o777)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        if _has_name(self.file, self.path):
            self.path.unlink(missing_ok=True)
        self.file.close()


def _try_lock(file: typing.IO[bytes]) -> bool:
    """False if another process has locked the file; true also on a file system without locks."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def _has_name(file: typing.IO[bytes], path: pathlib.Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.lstat())
    except OSError:
        return False


def _remove_if_stale(path: pathlib.Path) -> None:
    try:
        with open(os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC), "rb", buffering=0) as file:
            status = os.fstat(file.fileno())
            if stat.S_ISREG(status.st_mode) and status.st_uid == os.geteuid():
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if _has_name(file, path):
                    path.unlink()
    except OSError:
        pass
