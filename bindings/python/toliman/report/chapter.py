"""Figures after those of the book chapter: functions of arrays that return a matplotlib Figure."""
from __future__ import annotations

import math
import typing

import numpy
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Rectangle

from . import style
from ._network import CHANNELS, MAX_POOL, SIDE, tensors
from .figures import envelope, thinned
from .images import DEPTH
from .results import Array
from .style import BLUE, DARK, DOTS, GREEN, GREY, ORANGE, new_figure, styled

MOST_SIGMAS = 4  # of a residual's scale
SHOWN_SIDE = 128  # rows and columns of the frames that are drawn
DISPLACEMENTS = ("linear", "cubic", "linear_change", "cubic_change", "taylor")  # columns of displacement.csv


def half_maximum(frequency: Array, power: Array) -> tuple[float, float, float]:
    """Returns half of the highest power and the two frequencies next to the peak where the power is that; NaN for a
    side that stays above."""
    top = int(power.argmax())
    half = float(power[top]) / 2
    ends = []
    for step, end in ((-1, -1), (1, len(power))):
        below = next((k for k in range(top, end, step) if power[k] < half), None)
        if below is None:
            ends.append(math.nan)
            continue
        inner = below - step
        share = (power[inner] - half) / (power[inner] - power[below])
        ends.append(float(frequency[inner] + share * (frequency[below] - frequency[inner])))
    return half, ends[0], ends[1]


def _standardised(values: Array, by: Array) -> Array:
    return (values - values.mean()) / (float(by.std()) or 1.0)


def _periodogram(axis: Axes, frequency: Array, power: Array, fwhm_days: float) -> None:
    half, low, high = half_maximum(frequency, power)
    axis.plot(*envelope(frequency, power), color=BLUE, linewidth=1.1)
    if math.isfinite(low + high):
        axis.plot([low, high], [half, half], "|-", color=ORANGE, markersize=9,
                  label=f"FWHM {fwhm_days:.3g} days, half of it {fwhm_days / 2:.3g}")
        axis.legend(loc="upper right")
    axis.set_xscale("log")
    axis.set_xlim(frequency[0], frequency[-1])
    axis.set_ylim(0, 1.05 * max(float(power.max()), 1e-9))
    axis.set_xlabel("frequency, 1/day")
    axis.set_ylabel("power (no unit)")


@styled
def signal_and_atom(t: Array, truth: Array, latent: Array, frequency: Array, true_power: Array, power: Array,
                    fwhm_days: tuple[float, float]) -> Figure:
    """True displacements and latents, each standardised (mean 0, standard deviation 1), above their periodograms with
    the full width at half maximum of the highest peak. t: days; truth, latent: px; frequency: above 0, in 1/day;
    fwhm_days: the two widths in period."""
    figure, (left, right, below_left, below_right) = new_figure(5.2, 2, 2)
    step = thinned(len(t))
    left.plot(t[::step], _standardised(truth, truth)[::step], color=BLUE)
    left.set_title("true displacements")
    right.plot(t[::step], _standardised(latent, latent)[::step], ".", color=DOTS, markersize=3, label="each frame")
    right.plot(t[::step], _standardised(truth, latent)[::step], color=ORANGE, label="truth")
    right.set_title("latents (the chapter's atom)")
    right.legend(loc="upper right", ncol=2)
    extremes = (abs(float(y)) for line in right.lines for y in (line.get_ydata().min(), line.get_ydata().max()))
    highest = max(extremes) or 1.0
    right.set_ylim(-1.1 * highest, 1.5 * highest)
    for axis in (left, right):
        axis.set_xlabel("time, days")
        axis.set_ylabel("standard deviations")
        axis.set_xlim(t[0], t[-1])
    _periodogram(below_left, frequency, true_power, fwhm_days[0])
    _periodogram(below_right, frequency, power, fwhm_days[1])
    return figure


def _margin(count: int) -> int:
    """Rows or columns on either side that are not drawn."""
    return max(0, (count - SHOWN_SIDE) // 2)


def _middle(images: Array) -> Array:
    rows, columns = (slice(_margin(n), n - _margin(n)) for n in images.shape[-2:])
    return images[..., rows, columns]


@styled
def reconstructions(numbers: typing.Sequence[int], frames: Array, again: Array, residuals: Array,
                    place: tuple[float, float, float], unit: str) -> Figure:
    """Frames above their reconstructions and residuals, the middle 128x128 px of each. numbers: of the frames; frames,
    again: counts [frames][rows][columns] in `unit`; residuals: frame less reconstruction over the sigma of the pixel.
    place: x and y of the first pixel and size of a pixel, in arcsec."""
    x, y, step = place
    left = x + (_margin(frames.shape[2]) - 0.5) * step
    bottom = y + (_margin(frames.shape[1]) - 0.5) * step
    frames, again, residuals = _middle(frames), _middle(again), _middle(residuals)
    count, rows, columns = frames.shape
    height = 0.6 + 3 * (style.WIDTH - 1.6) / count * rows / columns
    figure, axes = new_figure(height, 3, count, sharex=True, sharey=True)
    highest = float(numpy.nanmax(frames, initial=0)) or 1.0
    extent = (left, left + columns * step, bottom, bottom + rows * step)
    light = {"norm": LogNorm(DEPTH * highest, highest, clip=True), "cmap": style.INTENSITY}
    noise = {"vmin": -MOST_SIGMAS, "vmax": MOST_SIGMAS, "cmap": style.DIFFERENCE}
    for row, (images, how, name) in enumerate(((frames, light, "frame"), (again, light, "reconstruction"),
                                               (residuals, noise, "residual"))):
        line = axes[row * count:(row + 1) * count]
        for axis, image in zip(line, images):
            shown = axis.imshow(image, extent=extent, origin="lower", **how)
            axis.grid(False)
        line[0].set_ylabel(f"{name}\ny, arcsec")
        label = f"{unit} per pixel" if row == 0 else "sigma"
        if row != 1:
            figure.colorbar(shown, ax=axes[:2 * count] if row == 0 else line, label=label, pad=0.01,
                            aspect=30 if row == 0 else 15, extend="min" if row == 0 else "both")
    for axis, number in zip(axes, numbers):
        axis.set_title(f"frame {number}")
    for axis in axes[2 * count:]:
        axis.set_xlabel("x, arcsec")
    return figure


class Layer(typing.NamedTuple):
    """An image of the network, and the operation that makes it from the one before ("" for the input)."""

    operation: str
    rows: int
    columns: int
    channels: int
    parameters: int


def layers(layout: str = "flight") -> list[Layer]:
    """Returns the layers of a layout, from the input through the latent to the output."""
    max_pool = MAX_POOL[layout]
    down = "conv 3×3\nELU\nmax 2×2" if max_pool else "conv 3×3\nmean 2×2\nELU"
    up = "un-pool\ndeconv 3×3" if max_pool else "repeat 2×2\ndeconv 3×3"
    shapes, stages, input_side = tensors(layout), len(CHANNELS) - 1, SIDE[layout]

    def layer(operation: str, side: int, channels: int, name: str) -> Layer:
        weights = sum(math.prod(shapes[f"{name}.{part}"]) for part in ("weight", "bias"))
        return Layer(operation, side, side, channels, weights)

    found = [Layer("", input_side, input_side, CHANNELS[0], 0)]
    found += [layer(down, input_side >> i, CHANNELS[i], f"conv{i}") for i in range(1, stages + 1)]
    found += [layer("dense", 1, 1, "latent"), layer("dense\nELU", input_side >> stages, CHANNELS[-1], "expand")]
    found += [layer(up + ("\nELU" if i > 1 else ""), input_side >> i - 1, CHANNELS[i - 1], f"deconv{i}")
              for i in range(stages, 0, -1)]
    return found


def layout_of(side: int) -> str:
    """Returns the layout of networks whose images have this side, which toliman run takes for its frames."""
    return next(name for name, size in SIDE.items() if size == side)


@styled
def architecture(names: typing.Sequence[str]) -> Figure:
    """The network's layers, a row for each layout: boxes are images (height: rows, width: channels, both on a
    logarithmic scale), arrows are operations."""
    figure, axes = new_figure(2.7 * len(names), len(names), 1)
    for axis, name in zip(axes, names):
        at = before = 0.0
        every = layers(name)
        for number, layer in enumerate(every):
            height, width = 0.25 + math.log2(layer.rows) / 4, 0.12 + math.log2(layer.channels) / 14
            if number > 0:
                axis.add_patch(FancyArrowPatch((before, 0), (at, 0), arrowstyle="-|>", mutation_scale=8, color=GREY,
                                               shrinkA=1, shrinkB=1))
                axis.text((before + at) / 2, 0.12, layer.operation, ha="center", va="bottom", fontsize=6.5, color=DARK,
                          linespacing=1.1)
            latent = layer.rows == 1
            axis.add_patch(Rectangle((at, -height / 2), width, height, facecolor=ORANGE if latent else "#cfe2f0",
                                     edgecolor=ORANGE if latent else BLUE))
            text = "latent" if latent else f"{layer.rows}×{layer.columns}\n×{layer.channels}"
            axis.text(at + width / 2, -height / 2 - 0.08, text, ha="center", va="top", fontsize=7)
            before, at = at + width, at + width + 1.0
        axis.set_xlim(-0.1, before + 0.1)
        axis.set_ylim(-1.6, 1.2)
        axis.axis("off")
        total = sum(layer.parameters for layer in every)
        axis.set_title(f"layout {name}: {total:,} weights", loc="left")
    return figure


def pooled(image: Array) -> tuple[Array, Array, Array]:
    """Returns the maxima of 2x2 groups of pixels, the image un-pooled from them (each at its place, 0 elsewhere), and
    the means of the groups."""
    rows, columns = (n // 2 for n in image.shape)
    groups = image.reshape(rows, 2, columns, 2).swapaxes(1, 2).reshape(rows, columns, 4)
    highest = groups.max(axis=2)
    first = numpy.arange(4) == groups.argmax(axis=2)[..., None]
    again = (first * highest[..., None]).reshape(rows, columns, 2, 2).swapaxes(1, 2).reshape(image.shape)
    return highest, again, groups.mean(axis=2)


@styled
def pooling(image: Array) -> Figure:
    """Pooling of a small image with an even number of rows and columns, first row above: the layout paper keeps maxima
    and their places, the layout flight keeps means and repeats them."""
    highest, again, mean = pooled(image)
    figure, axes = new_figure(2.05, 1, 5)
    low, high = float(min(image.min(), 0)), float(image.max())
    for axis, (title, values) in zip(axes, (("image", image), ("paper: maxima", highest), ("paper: un-pooled", again),
                                            ("flight: means", mean),
                                            ("flight: repeated", mean.repeat(2, axis=0).repeat(2, axis=1)))):
        axis.imshow(values, cmap="Blues", vmin=low, vmax=2 * high - low, origin="upper")
        for (row, column), value in numpy.ndenumerate(values):
            axis.text(column, row, f"{value:g}", ha="center", va="center")
        axis.set_title(title)
        axis.set_xticks(numpy.arange(-0.5, values.shape[1]))
        axis.set_yticks(numpy.arange(-0.5, values.shape[0]))
        axis.tick_params(length=0, labelbottom=False, labelleft=False)
    return figure


@styled
def activations() -> Figure:
    """ELU with alpha = 1, the network's, and ReLU: value and derivative."""
    x = numpy.linspace(-4, 2, 601)
    figure, (left, right) = new_figure(3.2, 1, 2)
    left.plot(x, numpy.where(x > 0, x, numpy.expm1(x)), color=BLUE, label="ELU")
    left.plot(x, numpy.maximum(x, 0), "--", color=ORANGE, label="ReLU")
    right.plot(x, numpy.where(x > 0, 1, numpy.exp(x)), color=BLUE, label="ELU")
    right.plot(x, numpy.where(x > 0, 1.0, 0.0), "--", color=ORANGE, label="ReLU")
    left.set_ylabel("value (no unit)")
    right.set_ylabel("derivative (no unit)")
    for axis in (left, right):
        axis.set_xlabel("input (no unit)")
        axis.legend(loc="upper left")
    return figure


@styled
def displacement(displacement_px: Array, errors: dict[str, Array]) -> Figure:
    """Error of a displaced image over the largest change of a pixel by the displacement. errors: by the names of
    DISPLACEMENTS."""
    figure, (axis,) = new_figure(3.8)
    looks = (("shifted and downsampled, linear", ORANGE, "-", "o"), ("shifted and downsampled, cubic", GREEN, "-", "s"),
             ("the change alone, linear", ORANGE, ":", "o"), ("the change alone, cubic", GREEN, ":", "s"),
             ("Taylor expansion, used here", BLUE, "-", "D"))
    for name, (label, colour, line, marker) in zip(DISPLACEMENTS, looks):
        axis.plot(displacement_px, errors[name], color=colour, linestyle=line, marker=marker, label=label)
    axis.axhline(1, color=DARK, linestyle="--", label="error as large as the signal")
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel("displacement, px")
    axis.set_ylabel("error / signal (no unit)")
    axis.legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0)
    return figure
