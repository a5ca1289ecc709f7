"""Planets of a series: orbit, mass, odds and limits. Reference: include/toliman/planet.h."""
from __future__ import annotations

import ctypes
import math
import os
import types
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import Doubles, array_of, listed, of_kind, options_of, plain, pointer, real, shaped, whole
from ._handle import Handle
from ._library import check, library
from ._plots import Axes, Figure, plots
from ._predictions import structured
from ._progress import Progress, Watch
from . import _results
from ._result_base import result
from ._results import Instrument, PlanetInfo
from .measure import Measurements, with_functions
from .periodogram import _series
from ._series_table import factor_of, number_of_unit
from ._shown import brief
from ._table import Column, Records, Rows, Tabular, Units, records_of
from .times import times_of_series, unit_of
from .tracker import Tracker

_SAMPLE = numpy.dtype([(name, numpy.float64) for name in (
    "period", "eccentricity", "periastron_deg", "epoch", "amplitude", "mass_a", "mass_b", "jitter", "inclination_deg",
    "node_deg")])
_PERIODS_PER_CALL = 16  # of limits; progress and Ctrl-C are checked after each call
_STARS = {"a": 0, "b": 1, "": -1}
_Pair = typing.Tuple[float, float]


def _handle_of(name: str, series: Measurements | None) -> typing.Any:
    return None if series is None else of_kind(name, series, Measurements)._c


def _pair(name: str, values: ArrayLike, unit: str = "") -> Doubles:
    return shaped(name, values, (2,), unit)


@result
class Planet(_results.Planet):
    __doc__ = (_results.Planet.__doc__ or "").split("\n\n")[0]

    @property
    def verdict(self) -> str:
        """"planet", or "candidate" if there are reasons against one."""
        return "candidate" if self.reasons else "planet"

    def __repr__(self) -> str:
        medians = (f"{name}={brief(getattr(self, name)[1])}" for name in
                   ("period", "amplitude", "eccentricity", "mass_a", "mass_b"))
        return f"Planet({self.verdict}, {', '.join(medians)}, log10_bayes={brief(self.log10_bayes)})"

    @classmethod
    def _of(cls, struct: typing.Any, units: Units = {}) -> Planet:
        members = {name: getattr(struct, name) for name, *_ in struct._fields_}
        members["reasons"] = [library.toliman_constant_name(1 << bit).decode() for bit in range(32)
                              if struct.reasons >> bit & 1]
        return super()._of(types.SimpleNamespace(**members), units)


class Given(typing.NamedTuple):
    """The series of a search: times, position angles or None, arcsec per unit of the values (0: not known), their unit
    as text, whether they are velocities, and days per unit of the times."""

    t: Doubles
    position_angle_deg: Doubles | None
    unit_arcsec: float
    unit: str
    is_velocity: bool
    time_unit_days: float


class Planets(Handle, Tabular):
    """Result of planets(). Several threads may use it at the same time."""

    _kind, _destroy = _raw.toliman_planet, "toliman_planet_destroy"
    _n: int
    _samples: int
    _given: Given
    _units: Units  # of the series
    _time_unit_days: float

    @property
    def info(self) -> PlanetInfo:
        """Number of planets, residuals, axis, jitter and priors."""
        return self._read(library.toliman_planet_get_info, _raw.toliman_planet_info, PlanetInfo)

    @property
    def candidates(self) -> Rows[Planet]:
        """All candidates in the order in which they were found: those whose Bayes factor reaches the threshold and, at
        most, one more. `verdict` and `reasons` tell which of them are planets."""
        return Rows(map(self._candidate, range(self.info.candidates)))

    @property
    def planets(self) -> Rows[Planet]:
        """The candidates without a reason against a planet."""
        return Rows(candidate for candidate in self.candidates if not candidate.reasons)

    @property
    def instruments(self) -> Rows[Instrument]:
        """The instruments of the series, then those of the velocities: offset, jitter and chi_square of each."""
        return Rows(Instrument._of(one, self._units) for one in listed(
            _raw.toliman_measure_instrument, library.toliman_planet_get_instruments, self._c))

    @property
    def outliers(self) -> NDArray:
        """Indices of the samples that do not belong to the series, in its order."""
        indices = numpy.empty(self.info.outliers, numpy.int64)
        check(library.toliman_planet_get_outliers(self._c, len(indices),
                                                  indices.ctypes.data_as(ctypes.POINTER(ctypes.c_int64))))
        return indices

    def _candidate(self, index: int) -> Planet:
        found = _raw.toliman_planet_candidate()
        check(library.toliman_planet_get_candidate(self._c, index, ctypes.byref(found)))
        return Planet._of(found, self._units)

    def samples(self, index: int = 0, count: int | None = None) -> Records:
        """Returns samples of the posterior of a candidate, of equal weight and in random order: a structured array with
        the fields period, eccentricity, periastron_deg, epoch, amplitude, mass_a, mass_b, jitter, inclination_deg and
        node_deg.

        count: number of samples; None: all, the `samples` of planets()."""
        made = numpy.empty(self._samples if count is None else whole("count", count), _SAMPLE)
        check(library.toliman_planet_get_samples(self._c, whole("index", index), len(made), pointer(made)))
        return records_of(made, Planet, self._units)

    def signal(self, index: int, t: ArrayLike, position_angle_deg: ArrayLike | None = None) -> Doubles:
        """Returns the signal of a candidate at times t, as the header defines it.

        position_angle_deg: position angles of B from A at these times; None: the mean axis."""
        times = plain("t", times_of_series("t", t, self._time_unit_days))
        angles = None if position_angle_deg is None else shaped("position_angle_deg", position_angle_deg, times.shape)
        signal = numpy.empty(times.shape)
        check(library.toliman_planet_get_signal(self._c, whole("index", index), pointer(times), pointer(angles),
                                                times.size, pointer(signal)))
        return signal

    def residuals(self) -> Doubles:
        """Returns y minus the joint fit of nuisance functions and all candidates whose Bayes factor reaches the
        threshold, in the order of the series."""
        residuals = numpy.empty(self._n)
        check(library.toliman_planet_get_residuals(self._c, len(residuals), pointer(residuals)))
        return residuals

    def limits(self, periods: ArrayLike, probability: float = 0.95, *,
               progress: Progress | bool | None = None) -> Records:
        """Returns limits of one planet more, on circular orbits: a structured array of the shape of `periods` with the
        members of PlanetLimit.

        probability: that a planet of the amplitude `upper` is not excluded, and that a search calls one of the amplitude
            `detectable` a planet. progress: as for Simulator; Ctrl-C cancels, too."""
        given, level = plain("periods", periods, self._units["t"]), real("probability", probability)
        made = array_of(_raw.toliman_planet_limit, given.size)
        with Watch(progress) as watch:
            for first in range(0, given.size, _PERIODS_PER_CALL):
                count = min(_PERIODS_PER_CALL, given.size - first)
                made[first].struct_size = ctypes.sizeof(_raw.toliman_planet_limit)
                watch.check(library.toliman_planet_get_limits(self._c, pointer(given.ravel()[first:]), count, level,
                                                              ctypes.byref(made[first])))
                watch.step("limits", (first + count) / given.size)
        return structured(made, self._units)[:given.size].reshape(given.shape)

    def inject(self, periods: _Pair, sizes: _Pair, count: int = 1000, *, star: str = "", circular: bool = False,
               seed: int = 0) -> int:
        """Returns how many of `count` planets, injected into white noise of the sigmas of the series, are detected.

        periods, sizes: the smallest and the largest; their logarithms are uniform between them.
        star: "a" or "b": sizes are masses of planets of this star, in Earth masses times g or sin i; "": amplitudes.
        circular: eccentricity 0; else it is drawn from its prior."""
        if star not in _STARS:
            raise ValueError(f"star = {star!r}: must be one of 'a', 'b', ''")
        (shortest, longest), (smallest, largest) = _pair("periods", periods, self._units["t"]), _pair("sizes", sizes)
        cell = _raw.toliman_planet_cell(
            star=_STARS[star], period_min=shortest, period_max=longest, size_min=smallest, size_max=largest,
            is_circular=int(circular), count=whole("count", count, 2**32), seed=whole("seed", seed, 2**64))
        detected = ctypes.c_uint32()
        check(library.toliman_planet_inject(self._c, ctypes.byref(cell), ctypes.byref(detected)))
        return detected.value

    def plot_corner(self, index: int = 0) -> Figure:
        """Draws the posterior of a candidate: histograms of its samples and of all pairs of them. Periods are in days,
        amplitudes in microarcsec if the unit of the values is known. Returns the figure."""
        return plots().corner(self, index)

    def plot_folded(self, index: int = 0, ax: Axes | None = None) -> typing.Union[Axes, Figure]:
        """Draws the series less the other planets and the nuisance functions over the phase of a candidate, with its
        orbit on the mean axis and the means of 24 intervals.

        ax: Axes to draw into, in their style, and to return. None: a new figure of pyplot, with the residuals below,
        is returned."""
        return plots().folded(self, index, ax)

    def plot_limits(self, periods: ArrayLike | None = None, ax: Axes | None = None) -> Axes:
        """Draws limits() with the planets found; if masses are known, in masses on A, with the planets of the solar
        system.

        periods: at least two, in the unit of the times; None: 50 from period_min to period_max. ax: Axes to draw into,
        in their style; None: a new figure of pyplot."""
        return plots().limits(self, periods, ax)

    def __len__(self) -> int:
        return self.info.planets

    def _columns(self) -> dict[str, Column]:
        """Returns all candidates, one per row."""
        verdicts = numpy.array([candidate.verdict for candidate in self.candidates], str)
        return {"verdict": Column(verdicts, "", '"planet" or "candidate"'), **self.candidates._columns()}

    def _facts(self) -> dict[str, typing.Any]:
        info = self.info
        return {"planets": info.planets, "unit": self._units["y"], "rms": info.rms, "chi2": info.chi_square,
                "goodness": info.goodness, "outliers": info.outliers, "per_min": info.period_min,
                "per_max": info.period_max}

    def _summary(self) -> str:
        periods = [f"{planet.period[1]:.6g}" for planet in self.planets]
        return f"Planets: {len(periods)} found" + (f", periods {', '.join(periods)}" if periods else "")

    def _repr_html_(self) -> str:
        candidates = list(self.candidates) if self._is_open else []
        return super()._repr_html_() + "".join(candidate._repr_html_() for candidate in candidates)


def planets(t: Measurements | Tracker | str | os.PathLike[str] | ArrayLike, y: ArrayLike | None = None, sigma: ArrayLike | None = None, *,
            rows: ArrayLike | None = None, priors: ArrayLike | None = None, position_angle_deg: ArrayLike | None = None,
            trend: int = 0, span: tuple[typing.Any, typing.Any] | None = None, velocity: bool = False, jitter: bool = True,
            clip: bool = False, frame_chi_square: float = 0, max_planets: int = 1, time_unit_days: float = 1,
            unit: float | None = None, parallax_arcsec: float | None = None,
            star_masses: tuple[float, float] | None = None, velocities: Measurements | None = None,
            velocities_b: Measurements | None = None, period_min: float = 0, period_max: float = 0,
            eccentricity_max: float = 0, amplitude_min: float = 0, amplitude_max: float = 0, jitter_max: float = 0,
            threshold: float = 0, detection_fap: float = 0, samples: int = 0, threads: int = 0, seed: int = 0,
            progress: Progress | bool | None = None) -> Planets:
    """Searches a series for planets: their orbits, masses and odds, and what the series excludes.

        found = toliman.planets("mission")                                 # a state folder of `toliman track`, or a file
        found = toliman.planets(sky.reduce(measured, scale_sigma=1e-3))    # measured separations of a file
        for planet in found.planets:           # found.candidates have the reasons against others
            print(planet)                      # period, eccentricity, mass_a ...: 16, 50 and 84 % of the posterior
        limits = found.limits([100, 300, 500]) # structured array: limits["upper"], limits["detectable_mass_a"]

    t: a series, with its functions, unit, parallax and masses, a Tracker, or the path of a state folder or file; or times, with y and sigma: reduced separations or radial
        velocities, and absolute standard deviations. None: sigmas are unknown. Dates and quantities of time are in days.
    Of arrays only:
        rows: values of known functions, [samples][columns], fitted with the mean. trend, span: Chebyshev polynomials
            T_1 ... T_trend, and the times between which they are defined; None: first and last time.
        priors: standard deviations of the coefficients of mean, T_1 ... T_trend and the columns; infinity: free, as the
            mean must be. None: all free.
        position_angle_deg: position angles of B from A. None: the axis A -> B is fixed.
        velocity: y are radial velocities. frame_chi_square: median chi_square of the frames of the series; above 2, no
            candidate is a planet.
        time_unit_days: days per unit of t. unit: arcsec (velocities: m/s) per unit of y.
    jitter: white noise of unknown size is added to the sigmas; False: the sigmas are exact. clip: leave out samples that
        do not belong (found.outliers); with any of them, no candidate is a planet otherwise.
    max_planets: 1 to 4. threshold: log10 of the Bayes factor that a planet needs; 0 means 2.
    parallax_arcsec: of the binary. star_masses: of A and B, solar masses. None, 0: those of the series. Masses of planets
        are NaN while what they need is unknown.
    velocities, velocities_b: radial velocities of A and of B (kind "velocity", with sigmas and unit), fitted together with
        the separations: star, inclination and true mass of the planet follow.
    period_min, period_max (units of t; 0 means 60 d and 1000 d), eccentricity_max (0 means 0.99), amplitude_min,
        amplitude_max, jitter_max (units of y; 0: see the header): limits of the priors.
    detection_fap: largest false alarm probability of a planet, and that of a detection in limits, efficiency and
        injections; 0 means 0.001.
    samples: of each posterior, at least 100; 0 means 4096. seed: of the samples.

    Results have the same bits for any number of threads. Raises InputError for numbers that are not finite or out of
    range, StateError for fewer samples than functions and 6; Cancelled.
    """
    if isinstance(t, (str, os.PathLike)):
        t = Measurements(t)
    elif isinstance(t, Tracker):
        t = t.measurements()
    if isinstance(t, Measurements):
        given = [name for name, is_given in (
            ("y", y is not None), ("sigma", sigma is not None), ("rows", rows is not None), ("priors", priors is not None),
            ("trend", trend != 0), ("position_angle_deg", position_angle_deg is not None), ("span", span is not None),
            ("velocity", velocity), ("frame_chi_square", frame_chi_square != 0), ("time_unit_days", time_unit_days != 1),
            ("unit", unit is not None)) if is_given]
        if given:
            raise TypeError(f"{given[0]}: must not be given with a series")
        series = t
    else:
        kind = "velocity" if velocity else "value"
        plain_t = times_of_series("t", t, time_unit_days)
        times, values, sigmas = _series(plain_t, y, sigma, unit_of(y))  # type: ignore[arg-type]
        series = with_functions(Measurements.of(
            times, values, sigmas, kind=kind, position_angle_deg=position_angle_deg,
            unit=factor_of("y", unit_of(y), 0 if unit is None else number_of_unit(unit, kind), kind),
            time_unit_days=time_unit_days, frame_chi_square=frame_chi_square)._knows(
                plain_t is not t and unit_of(t) is None, unit_of(y)), trend, span, rows, priors)
    units = series._units
    with Watch(progress) as watch:
        options = options_of(
            _raw.toliman_planet_options,
            flags=(0 if jitter else _raw.TOLIMAN_PLANET_NO_JITTER) | (_raw.TOLIMAN_PLANET_CLIP if clip else 0),
            max_planets=whole("max_planets", max_planets, 2**32), threads=whole("threads", threads, 2**32),
            parallax_arcsec=real("parallax_arcsec", 0 if parallax_arcsec is None else parallax_arcsec),
            star_mass=tuple(_pair("star_masses", (0, 0) if star_masses is None else star_masses)),
            samples=whole("samples", samples, 2**32), seed=whole("seed", seed, 2**64), progress=watch.callback,
            prior={name: real(name, value, unit) for name, value, unit in (
                ("period_min", period_min, units["t"]), ("period_max", period_max, units["t"]),
                ("eccentricity_max", eccentricity_max, ""), ("amplitude_min", amplitude_min, units["y"]),
                ("amplitude_max", amplitude_max, units["y"]), ("jitter_max", jitter_max, units["y"]))},
            velocity_a=_handle_of("velocities", velocities), velocity_b=_handle_of("velocities_b", velocities_b),
            threshold=real("threshold", threshold), detection_fap=real("detection_fap", detection_fap))
        made = Planets._adopt(Planets._create(library.toliman_planet_create, series._c, ctypes.byref(options),
                                              check=watch.check))
    made._units, made._time_unit_days = units, series.info.time_unit_days
    made._n = sum(len(one) for one in (series, velocities, velocities_b) if one is not None)
    made._samples = whole("samples", samples, 2**32) or 4096
    made._given = _given_of(series, has_angles=not math.isnan(made.info.axis_deg))
    return made


def _given_of(series: Measurements, has_angles: bool) -> Given:
    info, is_velocity = series.info, series.kind == "velocity"
    angles = series.values("position_angle_deg") if has_angles else None
    return Given(series.t, angles, 0 if is_velocity else info.unit, series._value_label(), is_velocity,
                 info.time_unit_days)
