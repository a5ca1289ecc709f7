"""The page: texts, tables and figures in their order, written as one HTML file and the figures' own files."""
from __future__ import annotations

import base64
import dataclasses
import pathlib
import re
import typing

import jinja2
from matplotlib.figure import Figure

from .._failure import readable
from .._output import check_free, replace_files, signals_deferred
from . import style
from .results import Result

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
                check_free(target)
        with signals_deferred() as received:
            if replace_files({**files, path: self.html().encode()}, received):
                for old in owned - set(files):
                    old.unlink(missing_ok=True)
        return path


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
