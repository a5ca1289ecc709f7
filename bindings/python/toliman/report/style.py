"""The one style of all figures: size, colours, fonts; and their files as SVG, PNG or PDF, the same bytes each time."""
from __future__ import annotations

import functools
import io
import typing

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

WIDTH = 9.0  # inch
BLUE, ORANGE, GREEN, PURPLE, SKY, GOLD, YELLOW = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00",
                                                  "#f0e442")  # Okabe and Ito: distinct also to the colour-blind
CYCLE = (BLUE, ORANGE, GREEN, PURPLE, SKY, GOLD, "#222222", "#999999", "#8c564b", YELLOW)
DOTS, DARK, GREY = "#9db8cf", "#222222", "#999999"
INTENSITY, DIFFERENCE = "viridis", "RdBu_r"
MARKERS = "osD^vP*X<>hp"
FORMATS = ("svg", "png", "pdf")

_STYLE: dict[str, typing.Any] = {
    "figure.dpi": 100, "savefig.dpi": 200, "figure.facecolor": "white", "figure.constrained_layout.use": True,
    "font.family": "DejaVu Sans", "font.size": 10, "axes.titlesize": 10, "axes.labelsize": 10, "legend.fontsize": 9,
    "axes.prop_cycle": matplotlib.cycler(color=CYCLE),
    "axes.edgecolor": "#444444", "axes.grid": True, "grid.color": "#e8e8e8", "grid.linewidth": 0.8,
    "axes.axisbelow": True, "lines.linewidth": 1.4, "lines.markersize": 4, "legend.frameon": True,
    "legend.framealpha": 0.85, "legend.edgecolor": "none", "legend.fancybox": False, "xtick.color": "#444444",
    "ytick.color": "#444444", "xtick.labelcolor": DARK, "ytick.labelcolor": DARK, "image.origin": "lower",
    "image.interpolation": "none", "image.cmap": INTENSITY, "axes.formatter.use_mathtext": True,
    "svg.hashsalt": "toliman", "svg.fonttype": "path", "pdf.fonttype": 42,
}
_NO_DATE: dict[str, dict[str, None]] = {
    "svg": {"Date": None, "Creator": None}, "png": {"Software": None}, "pdf": {"CreationDate": None, "Creator": None,
                                                                               "Producer": None}}
_Function = typing.TypeVar("_Function", bound=typing.Callable[..., typing.Any])


def styled(function: _Function) -> _Function:
    """Decorator: the function draws in this style, whatever the settings of the caller, which stay as they are."""
    @functools.wraps(function)
    def draw(*arguments: typing.Any, **options: typing.Any) -> typing.Any:
        with matplotlib.rc_context():
            matplotlib.rcParams.update(matplotlib.rcParamsDefault)
            matplotlib.rcParams.update(_STYLE)
            return function(*arguments, **options)
    return typing.cast(_Function, draw)


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
    figure.savefig(out, format=kind, metadata=_NO_DATE[kind])
    return out.getvalue()


def plain(text: str) -> str:
    """Returns a text from outside, such as a name in a file, that matplotlib shows as it is: without mathematics and
    control characters."""
    return "".join(letter if letter.isprintable() else "\ufffd" for letter in text).replace("$", "\\$")
