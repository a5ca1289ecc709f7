"""The one style of all figures: size, colours, fonts; and their files as SVG, PNG or PDF, the same bytes each time."""
from __future__ import annotations

import base64
import contextlib
import functools
import io
import re
import typing

import matplotlib
import numpy
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterSciNotation, NullLocator
from PIL import Image

from .text import raised

WIDTH = 9.0  # inch
BLUE, ORANGE, GREEN, PURPLE, SKY, GOLD, YELLOW = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00",
                                                  "#f0e442")  # Okabe and Ito: distinct also to the colour-blind
CYCLE = (BLUE, ORANGE, GREEN, PURPLE, SKY, GOLD, "#222222", "#999999", "#8c564b", YELLOW)
DOTS, DARK, LIGHT, GREY = "#9db8cf", "#222222", "#e4e4e4", "#999999"
INTENSITY, DIFFERENCE = "viridis", "RdBu_r"
MARKERS = "osD^vP*X<>hp"
FORMATS = ("svg", "png", "pdf")
OUTSIDE: dict[str, typing.Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1), "borderaxespad": 0}  # of a legend

_STYLE: dict[str, typing.Any] = {
    "figure.dpi": 100, "savefig.dpi": 200, "figure.facecolor": "white", "figure.constrained_layout.use": True,
    "font.family": "DejaVu Sans", "font.size": 10, "axes.titlesize": 10, "axes.labelsize": 10, "legend.fontsize": 9,
    "axes.titley": 1.0,
    "axes.prop_cycle": matplotlib.cycler(color=CYCLE),
    "axes.edgecolor": "#444444", "axes.grid": True, "grid.color": "#e8e8e8", "grid.linewidth": 0.8,
    "axes.axisbelow": True, "lines.linewidth": 1.4, "lines.markersize": 4, "legend.frameon": True,
    "legend.framealpha": 0.85, "legend.edgecolor": "none", "legend.fancybox": False, "xtick.color": "#444444",
    "ytick.color": "#444444", "xtick.labelcolor": DARK, "ytick.labelcolor": DARK, "image.origin": "lower",
    "image.interpolation": "none", "image.cmap": INTENSITY, "axes.formatter.use_mathtext": False,
    "svg.hashsalt": "toliman", "svg.fonttype": "path", "pdf.fonttype": 42,
}
_NO_DATE: dict[str, dict[str, None]] = {
    "svg": {"Date": None, "Creator": None}, "png": {"Software": None}, "pdf": {"CreationDate": None, "Creator": None,
                                                                               "Producer": None}}
_IMAGE = re.compile(rb'"data:image/png;base64,([^"]*)"')
_WINDOWS = ("interactive", "toolbar", "figure.max_open_warning", "figure.raise_window")  # settings that are no style
_Function = typing.TypeVar("_Function", bound=typing.Callable[..., typing.Any])


@contextlib.contextmanager
def in_use() -> typing.Iterator[None]:
    """What the block draws has this style, whatever the settings of the caller, which are restored."""
    with matplotlib.rc_context():
        matplotlib.rcParams.update({name: value for name, value in matplotlib.rcParamsDefault.items()
                                    if name not in _WINDOWS})
        matplotlib.rcParams.update(_STYLE)
        yield


def styled(function: _Function) -> _Function:
    """Decorator: the function draws in this style, whatever the settings of the caller, which stay as they are. A
    figure that it returns gets the tick labels of this style."""
    @functools.wraps(function)
    def draw(*arguments: typing.Any, **options: typing.Any) -> typing.Any:
        with in_use():
            result = function(*arguments, **options)
            for axes in result.axes if isinstance(result, Figure) else ():
                set_log_ticks(axes)
            return result
    return typing.cast(_Function, draw)


class _Powers(LogFormatterSciNotation):
    """Labels such as 10⁻⁶ and 2 × 10⁻⁶, in plain text: mathematics takes as long as the rest of a figure."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        label = super().__call__(x, pos).removeprefix(r"$\mathdefault{").removesuffix("}$").replace(r"\times", " × ")
        return re.sub(r"10\^\{(-?\d+)\}", lambda power: raised(int(power[1])), label)


def set_log_ticks(axes: Axes) -> None:
    """Gives logarithmic axes labels in plain text, and minor ticks only below three decades."""
    for axis in (axes.xaxis, axes.yaxis):
        if not isinstance(axis.get_major_formatter(), LogFormatterSciNotation):
            continue
        low, high = sorted(axis.get_view_interval())
        axis.set_major_formatter(_Powers())
        if high > 1000 * low:
            axis.set_minor_locator(NullLocator())
        else:
            axis.set_minor_formatter(_Powers(labelOnlyBase=False))


@styled
def new_figure(height: float, rows: int = 1, columns: int = 1, **options: typing.Any) -> tuple[Figure, list[Axes]]:
    """Returns a figure of WIDTH x height inch and its axes row by row; options are those of Figure.subplots. Call it in
    a function that is `styled`."""
    figure = Figure(figsize=(WIDTH, height))
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    return figure, list(axes.flat)


@styled
def drawn(figure: Figure, kind: str) -> bytes:
    """Returns the file of a figure; kind: one of FORMATS."""
    out = io.BytesIO()
    if kind == "svg":  # savefig would draw twice
        FigureCanvasSVG(figure).print_svg(out, metadata=_NO_DATE[kind])
        return _IMAGE.sub(_with_palette, out.getvalue())
    figure.savefig(out, format=kind, metadata=_NO_DATE[kind])
    return out.getvalue()


def _with_palette(match: re.Match[bytes]) -> bytes:
    """Replaces an image of an SVG file by the same pixels with 8 bits each, if they have at most 256 colours."""
    pixels = numpy.asarray(Image.open(io.BytesIO(base64.b64decode(match[1]))).convert("RGBA"))
    colours, places = numpy.unique(pixels.reshape(-1, 4).view(numpy.uint32), return_inverse=True)
    if len(colours) > 256:
        return match[0]
    red_green_blue_alpha = colours.view(numpy.uint8).reshape(-1, 4)
    image = Image.fromarray(places.reshape(pixels.shape[:2]).astype(numpy.uint8), "P")
    image.putpalette(red_green_blue_alpha[:, :3].tobytes())
    out = io.BytesIO()
    image.save(out, format="png", transparency=red_green_blue_alpha[:, 3].tobytes())
    return b'"data:image/png;base64,' + base64.b64encode(out.getvalue()) + b'"'


def background(axes: Axes) -> typing.Any:
    """Returns the colour behind the axes: they may be transparent in the style of a user."""
    colours = (axes.get_facecolor(), axes.figure.get_facecolor())
    return next((colour for colour in colours if colour[3] > 0), "white")


def dark(axes: Axes) -> str:
    """Returns DARK, or LIGHT on a dark background."""
    return DARK if sum(to_rgb(background(axes))) > 1.5 else LIGHT


def plain(text: str) -> str:
    """Returns a text from outside, such as a name in a file, that matplotlib shows as it is: without mathematics and
    control characters."""
    return "".join(letter if letter.isprintable() else "\ufffd" for letter in text).replace("$", "\\$")
