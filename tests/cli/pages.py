"""Reads what `toliman report` writes, and catches the figures that it draws as matplotlib objects."""
import base64
import html.parser
import json
import os
import re
import sys
import xml.etree.ElementTree

from program import ROOT, ProgramTest

sys.path.append(str(ROOT / "build" / "python"))
from toliman.report import __main__, page, results, sections  # noqa: E402


class Reader(html.parser.HTMLParser):
    """Text, tags, cells and pictures of a page; fails if a tag is not closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.words, self.images, self.cells = [], [], [], {}, []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag not in {"meta", "img"}:
            self.open.append(tag)
        if tag == "img":
            self.images[dict(attributes)["alt"]] = dict(attributes)["src"]
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        if "style" not in self.open:
            self.words.append(data)
        if "td" in self.open or "th" in self.open:
            self.cells[-1] += data

    @property
    def text(self):
        return " ".join("".join(self.words).split())

    def row(self, name, count=6):
        """Cells after the one of this name."""
        at = self.cells.index(name)
        return self.cells[at + 1 : at + 1 + count]


class Recorder(page.Page):
    """The page of a folder, which keeps its figures {name: matplotlib Figure} and captions {name: text} instead of drawing them;
    or draws them, too, for a page in the folder `out`."""

    def __init__(self, folder, out=None):
        super().__init__(out or folder)
        self.figures, self.captions, self.draws = {}, {}, out is not None
        sections.section_of(folder)(folder, self)

    def add_figure(self, name, figure, caption):
        self.figures[name], self.captions[name] = figure, caption
        if self.draws:
            super().add_figure(name, figure, caption)


def lines(axes):
    """{label: (x, y)} of the lines, error bars and steps of axes."""
    found = {line.get_label(): line.get_data() for line in axes.get_lines()}
    found.update((bars.get_label(), bars[0].get_data()) for bars in axes.containers if hasattr(bars, "has_xerr"))
    return found


def write_bench(folder):
    """A folder that gives a page with one figure, bench-b."""
    rows = [{"bench": "b", "what": "w", "series": "s", "seconds": k, "error": k} for k in range(1, 9)]
    folder.mkdir()
    (folder / "b.json").write_text(json.dumps(
        {"schema": "toliman-bench/1", "machine": {"cpu": "c", "isa": "avx2", "cores": 2}, "rows": rows}))


class ReportTest(ProgramTest):
    def check_page(self, folder, figures, kinds=("svg",)):
        """A page that is HTML, fetches nothing, has these figures in this order, and their files; its Reader."""
        text = (folder / "report.html").read_text()
        reader = Reader(text)
        self.assertNotRegex(text, "https?:|<script|<link|url\\(")
        self.assertEqual(list(reader.images), list(figures))
        self.assertEqual(sorted(os.listdir(folder / "figures")), sorted(f"{n}.{kind}" for n in figures for kind in kinds))
        for name in figures:
            svg = (folder / "figures" / f"{name}.svg").read_bytes()
            self.assertEqual(base64.b64decode(reader.images[name].partition("base64,")[2]), svg)
            self.assertIsNotNone(re.match(r"\d+(\.\d+)?pt$", xml.etree.ElementTree.fromstring(svg).get("width")))
            self.assertNotIn(b"dc:date", svg)
        return reader

    def fail_with(self, words, folder="."):
        """A page of the folder here fails because of its files, with this message."""
        with self.assertRaises(results.Failure) as caught:
            Recorder(self.folder / folder)
        self.assertEqual(caught.exception.code, 3)
        self.assertIn(words, str(caught.exception))

    def report(self, folder="copy", *options):
        """Makes a page of a folder here, as the program does; its Reader."""
        words = [str(self.folder / word) if word[0] != "-" else word for word in (folder, *options)]
        return Reader(__main__.report(__main__.parse(words)).read_text())
