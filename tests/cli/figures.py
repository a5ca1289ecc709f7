"""Reads what `toliman report` writes: the page, its PNG pictures, and the figures' values from their SVG paths."""
import html.parser
import re
import struct
import xml.etree.ElementTree
import zlib

import numpy

VOID = {"meta", "img", "br"}
# matplotlib's viridis at sixteenths, and ColorBrewer's RdBu from blue to red.
VIRIDIS = ("440154 481a6c 472f7d 414487 39568c 31688e 2a788e 23888e "
           "1f988b 22a884 35b779 54c568 7ad151 a5db36 d2e21b fde725").split()
BLUE_RED = "053061 2166ac 4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d b2182b 67001f".split()


class Reader(html.parser.HTMLParser):
    """Text, tags and pictures of a page; fails where a tag is not closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.words, self.images, self.cells = [], [], [], {}, []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag not in VOID:
            self.open.append(tag)
        if tag == "img":
            self.images[dict(attributes)["alt"]] = dict(attributes)["src"]
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        data = data.replace("\xa0", " ")
        if "style" not in self.open:
            self.words.append(data)
        if "td" in self.open or "th" in self.open:
            self.cells[-1] += data

    @property
    def text(self):
        return " ".join("".join(self.words).replace("\u2212", "-").split())

    def row(self, name):
        """Cells behind the one of this name."""
        at = self.cells.index(name)
        return [cell.replace("\u2212", "-") for cell in self.cells[at + 1 : at + 6]]


def png_pixels(data):
    """[row][column][rgb] of an 8-bit PNG without interlace, by the format's own words."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + size]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0]
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
            assert (depth, interlace) == (8, 0)
            channels = {2: 3, 6: 4}[colour]
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    step, above, rows = channels, bytearray(width * channels), []
    packed = zlib.decompress(packed)
    for row in range(height):
        start = row * (1 + width * channels)
        line = bytearray(packed[start + 1 : start + 1 + width * channels])
        undo(packed[start], line, above, step)
        rows.append(line)
        above = line
    return numpy.array(rows, int).reshape(height, width, channels)[:, :, :3]


def undo(kind, line, above, step):
    """Takes a PNG filter back, in place."""
    for i in range(len(line) if kind else 0):
        a, b, c = (line[i - step], above[i], above[i - step]) if i >= step else (0, above[i], 0)
        if kind == 4:
            to_a, to_b, to_c = abs(b - c), abs(a - c), abs(a + b - 2 * c)
            guess = a if to_a <= to_b and to_a <= to_c else b if to_b <= to_c else c
        else:
            guess = (0, a, b, (a + b) // 2)[kind]
        line[i] = (line[i] + guess) & 255


def coloured(parts, colours):
    """Colours of parts 0 ... 1 of a palette."""
    table = numpy.array([[int(colour[i : i + 2], 16) for i in (0, 2, 4)] for colour in colours])
    places = numpy.linspace(0, 1, len(colours))
    return numpy.stack([numpy.interp(parts, places, table[:, channel]) for channel in range(3)], axis=-1)


SVG = "{http://www.w3.org/2000/svg}"
AXIS = "rgb( 68,  68,  68)"


def places_in(text):
    """[[x, y], ...] of "M1,2 L3,4" or "translate(1,2)"."""
    return numpy.array(re.findall(r"(-?[\d.]+),(-?[\d.]+)", text), float)


def number_on_axis(node):
    """0.5, or 10 with a raised exponent."""
    spans = [(span.get("dy", "0"), "".join(span.itertext()).strip()) for span in node.iter(SVG + "tspan")]
    numbers = [float(text.replace("\u2212", "-")) for _, text in spans if text]
    return numbers[0] ** numbers[1] if len(numbers) == 2 else numbers[0]


class Plot:
    """One plot of a figure, in the units of its axes, as their ticks tell them; `log` names the logarithmic ones."""

    def __init__(self):
        self.ticks = {"x": [], "y": [], "right": []}  # (px, value)
        self.drawn = {}  # title: {kind: px of each}; what labels and arrows draw has the title None
        self.labels = {}  # text: px

    def add(self, title, kind, places):
        self.drawn.setdefault(title, {}).setdefault(kind, []).append(places)

    def in_units(self, places, log):
        units = numpy.empty(places.shape)
        for column, axis in enumerate("xy"):
            px, values = numpy.array(self.ticks[axis]).T
            to_unit = numpy.polyfit(px, numpy.log10(values) if axis in log else values, 1)
            units[..., column] = numpy.polyval(to_unit, places[..., column])
            if axis in log:
                units[..., column] = 10 ** units[..., column]
        return units

    def line(self, title, log=""):
        """Points of a line; of several parts if there are gaps."""
        return self.in_units(numpy.concatenate(self.drawn[title]["path"]), log)

    def marks(self, title, log=""):
        return self.in_units(numpy.concatenate(self.drawn[title]["use"]), log)

    def bars(self, title, log=""):
        """(x, y) of the middle of each bar's top."""
        tops = [[corners[:, 0].mean(), corners[:, 1].min()] for corners in self.drawn[title]["polygon"]]
        return self.in_units(numpy.array(tops), log)

    def label(self, text, log=""):
        return self.in_units(self.labels[text], log)


def plots_of(path):
    """Plots of an SVG file, from the top."""
    plots = [Plot()]

    def read(node, title):
        before = None
        for child in node if node.tag != SVG + "defs" else ():
            if child.get("id", "").startswith("gnuplot_plot_"):
                name = child.find(SVG + "title").text
                read(child, child.get("id") if name in plots[-1].drawn else name)
                without_sample(plots[-1], name)
            elif child.get("text-anchor"):
                read_text(child, before)
            else:
                read_shape(child, title)
                read(child, title)
            before = child

    def read_text(node, before):
        text = "".join(node.itertext()).strip()
        ends = places_in(before.get("d")) if before is not None and before.get("stroke") == AXIS else []
        if len(ends) != 2:
            plots[-1].labels.setdefault(text, places_in(node.get("transform"))[0])
        elif text:
            (x, y), (_, end) = ends
            if y == end and node.get("text-anchor") != "start" and set(plots[-1].drawn) - {None}:
                plots.append(Plot())
            axis = "x" if y != end else "right" if node.get("text-anchor") == "start" else "y"
            plots[-1].ticks[axis].append((x if axis == "x" else y, number_on_axis(node)))

    def read_shape(node, title):
        kind, plot = node.tag[len(SVG):], plots[-1]
        is_axis = node.get("stroke") == AXIS and not node.get("stroke-dasharray") or node.get("class") == "gridline"
        if kind == "path" and not is_axis:
            for part in node.get("d").split("M")[1:]:
                plot.add(title, kind, places_in(part))
        elif kind == "use" and node.get("color"):
            plot.add(title, kind, places_in(node.get("transform"))[:1])
        elif kind == "polygon":
            plot.add(title, kind, places_in(node.get("points")))

    read(xml.etree.ElementTree.parse(path).getroot(), None)
    for plot in plots:  # one below the other: the lowest has the numbers
        plot.ticks["x"] = plot.ticks["x"] or plots[-1].ticks["x"]
    return plots


def without_sample(plot, title):
    """Takes out what the legend shows, in the middle of the title's line."""
    middle = plot.labels[title][1] - 3.9 if title in plot.labels else numpy.nan
    for kind, all_places in plot.drawn.get(title, {}).items():
        ends = [(places[:, 1].min() + places[:, 1].max()) / 2 for places in all_places]
        plot.drawn[title][kind] = [places for places, end in zip(all_places, ends) if not abs(end - middle) < 0.5]
