"""The experiment: every method on every combination of table (scene), amplitude and seed, each with fresh noise.

A series of frames is simulated once and pushed to all methods that lack a result for it. The values of a series with signal
are regressed on the true displacement: slope, and scatter about the line. Without signal the scatter is the standard
deviation, and the slope is measured on two noise-free expected images at +-1e-5 px. Series are ordered by the scene and the
seed of their methods, so that each network is trained once and freed after its last series. The periodogram uses the grid
of `toliman run`; block means have fewer samples and a grid of their own.

Noise: every series has frames 0 ... N - 1 of the cadence with a noise seed of its own, seed + 2^32 j, where j counts the
amplitudes and then the series without signal. `toliman run --seed` therefore has the noise of j = 0. All tables use the
same seeds and differ in their scenes only. Networks are trained without frames.
"""
from __future__ import annotations

import dataclasses
import math
import typing
from concurrent.futures import ThreadPoolExecutor

import numpy

from .._arguments import Doubles
from .._failure import USAGE, Failure
from .._library import version
from ..periodogram import period, suited_grid
from ..sim import Simulator
from .journal import Journal, Row
from .methods import METHODS, SLOW_LEAST_PX, SLOW_SEEDS, Kind, Method, Shared
from .theory import Theory
from .variants import JITTER, PROJECTED, Variants

Show = typing.Callable[[str, float], typing.Any]

_CONTROL_FRAMES = 2000  # per seed of table robust: efficiency to 1/sqrt(2 * 2000) = 1.6 %
_FEW_SEEDS = 10  # of tables with a single amplitude
_STEP_PX = 1e-5  # for the slope of a method on expected images
_FEWEST_VALUES = 5  # of a series that is evaluated
_FRAMES_AT_ONCE = 48
_CADENCE = 5, 400000  # fewest and most frames of the default grid


class Options(typing.NamedTuple):
    """What the experiment computes."""

    amplitudes: list[float]
    methods: list[str]
    tables: list[str]
    seeds: int
    blind: int  # series without signal that `controls` leaves
    controls: str


@dataclasses.dataclass
class Table:
    """Frames of one scene, given to methods that were made for the same or for another scene."""

    name: str
    what: str
    frames: Simulator
    methods: Simulator
    amplitudes: list[float]
    blind: list[int]  # series without signal of each seed
    reference: Doubles | None = None  # added to every frame

    @property
    def compares_amplitudes(self) -> bool:
        """Has all amplitudes and seeds; otherwise the scene's own amplitude and a few seeds."""
        return self.name in ("real", "equal")

    @property
    def bound_px(self) -> float:
        """Cramer-Rao bound of a frame."""
        return self.frames.bounds.crb_projected_px

    def seen(self, images: Doubles) -> Doubles:
        """Returns the images as the methods get them."""
        return images if self.reference is None else images + self.reference


@dataclasses.dataclass
class _Work:
    """One series of frames and the rows that are still to be computed."""

    table: Table
    amplitude_px: float
    noise_seed: int
    rows: list[Row]


Methods = typing.Dict[str, Method]  # of one scene and seed


def _methods_of(group: list[_Work]) -> Methods:
    """Makes all methods of works with one scene and seed of the methods."""
    methods: Methods = {}
    shared: Shared = {}
    for work in group:
        for row in work.rows:
            if row.method not in methods:
                methods[row.method] = METHODS[row.method].make(work.table.methods, row.seed, shared)
    return methods


def _block_means(values: Doubles, block: int) -> Doubles:
    return values[:len(values) // block * block].reshape(-1, block).mean(axis=1)


def _regression(truth: Doubles, values: Doubles) -> tuple[float, float]:
    """Returns slope and scatter of the linear regression of the values on the true displacements."""
    x, y = truth - truth.mean(), values - values.mean()
    slope = (x * y).sum() / (x * x).sum()
    return slope, math.sqrt(((y - slope * x) ** 2).sum() / (len(x) - 2))


def _slope_on_images(table: Table, method: Method) -> float:
    """Returns values per px of a method on expected images, without noise; 0 if these give no value."""
    method.frames.begin()
    images = numpy.stack([table.frames.expect(-_STEP_PX), table.frames.expect(_STEP_PX)])
    method.frames.push(table.seen(images), numpy.zeros(2))  # expected images are those of time 0
    low, high = method.series()
    slope = (high - low) / (2 * _STEP_PX)
    return 0.0 if math.isnan(slope) else float(slope)


def _takes_part(kind: Kind, table: Table, row: Row) -> bool:
    if row.amplitude_px == 0 and kind.learns:
        return False
    if kind.slow and (row.seed > SLOW_SEEDS or row.amplitude_px < SLOW_LEAST_PX):
        return False
    return table.compares_amplitudes or kind.knows_scene


class Campaign:
    """Raises Failure for a scene without signal or photon noise, or with a number of frames outside the grid's limits."""

    def __init__(self, scene: str, simulator: Simulator, options: Options):
        info, self.options, self.simulator = simulator.info, options, simulator
        if not _CADENCE[0] <= info.frames <= _CADENCE[1]:
            raise Failure(USAGE, f"{scene}: cadence.frames = {info.frames}: must be in {list(_CADENCE)} for an experiment")
        if not info.amplitude_px > 0:
            raise Failure(USAGE, f"{scene}: signal: must have an amplitude above 0 px, which the experiment varies")
        if "photon noise" not in simulator.stages:
            raise Failure(USAGE, f"{scene}: noise.photon = false: must be true: the Cramer-Rao bound assumes photon noise")
        self._times, displacements = simulator.series()
        self._shape = displacements / info.amplitude_px
        self.grid = suited_grid(self._times)
        self.theory = Theory(self._times, self._shape, self.grid)
        self._amplitudes = list(options.amplitudes)  # of all tables
        if info.amplitude_px not in self._amplitudes:
            self._amplitudes.append(info.amplitude_px)
        self.tables: list[Table] = []
        self._make_tables(scene)

    def _make_tables(self, scene: str) -> None:
        given, asked = self.simulator, self.options.tables
        if "real" in asked:
            self._add("real", "the scene as it is", given, given)
        if asked == ["real"]:
            return
        if "robust" in asked and "moving stars" in given.stages:
            raise Failure(USAGE, f"{scene}: the stars move: the table robust needs stars at rest, for its methods are made "
                                 "for time 0; give --tables real,equal")
        variants = Variants(scene, given)
        if "equal" in asked:
            equal = variants.equal_stars()
            self._add("equal", "both stars equally bright", equal, equal)
        if "robust" not in asked:
            return
        self._add("matched", "the scene as it is", given, given)
        self._add("jitter", "pointing 1e-3 px rms, fluxes 1e-4 rms", variants.changed(JITTER), given)
        self._add("projected", "the same, fluxes and shift projected out", variants.changed(JITTER, PROJECTED),
                  variants.changed(PROJECTED))
        self._add_mismatch("defocus", "defocus error of 0.03 wave rms", variants.defocused(0.03))
        self._add_mismatch("separation", "separation error of 1 px", variants.moved(separation_px=1))
        self._add_mismatch("scale", "plate scale error of 1e-3", variants.moved(scale=1.001))
        self._add_mismatch("pointing-0.1", "pointing error of 0.1 px", variants.moved(shift_px=0.1))
        self._add_mismatch("pointing-0.5", "pointing error of 0.5 px", variants.moved(shift_px=0.5))

    def _add_mismatch(self, name: str, what: str, frames: Simulator) -> None:
        """Frames of another scene, in two tables: as they are, and with their own expected image replaced by the reference
        image of the methods' scene, as after calibration with the mean frame."""
        self._add(name, what, frames, self.simulator)
        self._add(name + "-mean", what + ", relative to their own mean", frames, self.simulator)
        self.tables[-1].reference = self.simulator.image() - frames.image()

    def _add(self, name: str, what: str, frames: Simulator, methods: Simulator) -> None:
        table, options = Table(name, what, frames, methods, [self.simulator.info.amplitude_px], []), self.options
        few, seeds = -(-_CONTROL_FRAMES // self.simulator.info.frames), min(options.seeds, _FEW_SEEDS)
        if table.compares_amplitudes:
            table.amplitudes, few, seeds = options.amplitudes, options.blind, options.seeds
        share, rest = divmod(options.blind, options.seeds)
        table.blind = [min(share + (seed < rest), few) for seed in range(seeds)]
        self.tables.append(table)

    def arguments(self) -> dict[str, typing.Any]:
        """Returns all that the results depend on; the bound changes also with the files that the scene names."""
        info, options = self.simulator.info, self.options
        return {"schema": "toliman-experiment-journal/1", "version": version(), "scene": info.name,
                "scene_digest": f"{info.scene_digest:016x}", "crb_px": self.simulator.bounds.crb_projected_px,
                "amplitudes_px": options.amplitudes, "methods": options.methods, "tables": options.tables,
                "seeds": options.seeds, "blind": options.blind}

    def _left(self, journal: Journal) -> list[list[_Work]]:
        """Returns the work still to be done, in groups with one scene and seed of the methods."""
        groups: dict[tuple[int, int], list[_Work]] = {}
        scenes: list[Simulator] = []  # of the methods
        for table in self.tables:
            if table.methods not in scenes:
                scenes.append(table.methods)
            for seed, blind in enumerate(table.blind, 1):
                series = [(amplitude, 0, self._amplitudes.index(amplitude)) for amplitude in table.amplitudes]
                series += [(0.0, number, len(self._amplitudes) + number) for number in range(blind)]
                for amplitude, number, use in series:
                    rows = [Row(table.name, method, amplitude, seed, number) for method in self.options.methods]
                    rows = [row for row in rows if _takes_part(METHODS[row.method], table, row) and row not in journal]
                    if rows:
                        work = _Work(table, amplitude, seed + (use << 32), rows)
                        groups.setdefault((scenes.index(table.methods), seed), []).append(work)
        return [groups[key] for key in sorted(groups)]

    def run(self, add: typing.Callable[[Row], None], journal: Journal, show: Show) -> None:
        """Computes every result that the journal does not contain, and adds it. The methods of the next group are made,
        and trained on one thread, while the series of this one are computed."""
        groups = self._left(journal)
        total, done = sum(len(work.rows) for group in groups for work in group), 0
        with ThreadPoolExecutor(1) as maker, ThreadPoolExecutor() as pool:
            following = [maker.submit(_methods_of, group) for group in groups[:1]]
            for number, group in enumerate(groups, 1):
                methods = following.pop().result()
                following += [maker.submit(_methods_of, another) for another in groups[number:number + 1]]
                for work in group:
                    for row in self._rows_of(work, methods, pool):
                        add(row)
                    done += len(work.rows)
                    show(f"experiment: {work.table.name}, {work.amplitude_px:g} px, seed {work.rows[0].seed}", done / total)

    def _rows_of(self, work: _Work, methods: Methods, pool: ThreadPoolExecutor) -> list[Row]:
        """Simulates one series of frames, pushes it to all methods at once, and returns the rows with their results."""
        rows, table = work.rows, work.table
        if work.amplitude_px == 0:
            rows = [row._replace(slope=_slope_on_images(table, methods[row.method])) for row in rows]
        frames = list({id(methods[row.method].frames): methods[row.method].frames for row in rows}.values())
        truth = work.amplitude_px * self._shape
        for one in frames:
            one.begin()
        for first in range(0, len(truth), _FRAMES_AT_ONCE):
            part = slice(first, first + _FRAMES_AT_ONCE)
            images = table.seen(table.frames.frames(first, displacements=truth[part], seed=work.noise_seed))
            list(pool.map(lambda one: one.push(images, self._times[part]), frames))
        return list(pool.map(lambda row: self._evaluated(row, truth, methods[row.method]), rows))

    def _evaluated(self, row: Row, truth: Doubles, method: Method) -> Row:
        """Returns the row of a method that has the frames of a series. Of too few values no period is found: log10 FAP and
        all other numbers remain 0."""
        values, block = method.series(), method.frames.block
        known = ~numpy.isnan(values)
        times, truth, values = (of[known] for of in (_block_means(self._times, block), _block_means(truth, block), values))
        if len(values) < _FEWEST_VALUES:
            return row
        peak = period(times, values, grid=self.grid if block == 1 else None)
        slope, sigma = (row.slope, values.std(ddof=1)) if row.amplitude_px == 0 else _regression(truth, values)
        return row._replace(period_days=peak.period, log10_fap=peak.log10_fap, mean=float(values.mean()), slope=float(slope),
                            sigma=float(sigma * math.sqrt(block)))  # of one frame
