"""The section of a folder of `toliman planet --out`: planets, posteriors, limits and detection map."""
from __future__ import annotations

import math
import pathlib

import numpy

from . import glossary, planet_figures, results
from .page import Page, add_provenance
from .planet_figures import Orbit
from .results import Array, Result, Table, goodness_of, malformed
from .text import LOG_FAP, UNKNOWN, decimals_of, fixed

SCHEMA = "toliman-planet/1"
_LOG_BAYES = "log₁₀ Bayes factor"
_WORDS = {
    "Bayes factor": "how much more probable the series is with this planet than without, with the priors of the search; it does "
                    "not contain the odds before the series was known",
    "g": "sine of the angle between the axis from star A to star B and the pole of the planet's orbit: a separation shows the "
         "mass times g",
    "epoch": "time of a passage through the periastron",
    **glossary.FAP,
}


class Unit:
    """Factor from the values of the files to those of the page, and the name of their unit."""

    def __init__(self, result: Result):
        arcsec = result.number("unit_arcsec")
        known = not math.isnan(arcsec)
        self.factor = arcsec * 1e6 if known else 1.0
        self.name = "µas" if known else result.text("unit") if result.has("unit") else ""

    def label(self, what: str) -> str:
        """Returns a label of an axis."""
        return f"{what}, {self.name}" if self.name else what


def add(folder: pathlib.Path, page: Page) -> None:
    """Adds the planets of a series to the page."""
    result = results.load(folder / "result.json", SCHEMA)
    unit, candidates = Unit(result), result.items("candidates")
    fitted = [one for one in candidates if _is_fitted(one)]
    page.add("title", f"toliman planet: {folder.resolve().name}")
    page.add("found", _found(result, fitted, candidates[len(fitted):]))
    _add_fit(result, page)
    add_provenance(page, result)
    if candidates:
        _add_table(result, candidates, unit, page)
    table = Table(folder / "series.csv")
    for number, planet in enumerate(fitted, 1):
        _add_folded(table, planet, number, result.text("kind") == "velocity", unit, page)
        _add_corner(folder / f"samples_{number}.npy", planet, number, result, unit, page)
    if result.has("limits"):
        _add_limits(Table(folder / "limits.csv"), result, [one for one in fitted if _is_planet(one)], unit, page)
    if result.has("map"):
        _add_map(folder, result, unit, page)
    page.explain(_WORDS)


def _is_planet(candidate: Result) -> bool:
    return candidate.text("verdict") == "planet"


def _reasons(candidate: Result) -> list[str]:
    values = candidate.find("reasons")
    if not isinstance(values, list) or not all(isinstance(value, str) for value in values):
        raise candidate.fail("reasons", "a list of texts")
    return values


def _is_fitted(candidate: Result) -> bool:
    """Whether its odds reach the threshold, so that its signal is in the joint fit."""
    return _is_planet(candidate) or planet_figures.BELOW not in _reasons(candidate)


def _name(candidate: Result, number: int) -> str:
    return f"{candidate.text('verdict')} {number}"


def _add_fit(result: Result, page: Page) -> None:
    """Adds the goodness of the joint fit, and the samples that do not belong."""
    text = ""
    if result.has("chi_square"):
        text = goodness_of(result)
    outliers = result.items("outliers")
    if outliers:
        left_out = "" if result.find("clip") else ", which is why no candidate is a planet"
        text += f" Samples that do not belong to the series: {len(outliers)}{left_out}."
    page.add("text", text.strip())
    if result.has("instruments"):
        page.add_table("Offset from the first instrument, and jitter, in the unit of the values.",
                       ["instrument", "samples", "offset", "jitter", "chi-square"],
                       [[one.text("name"), str(one.whole("samples")), f"{one.number('offset'):.6g}",
                         _interval(one, "jitter"), f"{one.number('chi_square'):.4g}" if one.has("chi_square") else ""]
                        for one in result.items("instruments")])


def _points(planet: Result, key: str) -> list[float]:
    """The 16, 50 and 84 % points."""
    values = planet.find(key)
    if not isinstance(values, list) or len(values) != 3:
        raise planet.fail(key, "three numbers")
    return [math.nan if value is None else float(value) for value in values]


def _interval(planet: Result, key: str, factor: float = 1.0) -> str:
    if not planet.has(key):
        return UNKNOWN
    low, middle, high = (value * factor for value in _points(planet, key))
    decimals = decimals_of(min(middle - low, high - middle))
    return f"{fixed(middle, decimals)} (−{fixed(middle - low, decimals)} +{fixed(high - middle, decimals)})"


def _found(result: Result, fitted: list[Result], others: list[Result]) -> str:
    planets = [one for one in fitted if _is_planet(one)]
    text = f"{result.whole('n')} samples: " + ("no planet." if not planets else "")
    text += "; ".join(f"period {_interval(planet, 'period')} days, {_LOG_BAYES} {fixed(planet.number('log10_bayes'), 1)}, "
                      f"{LOG_FAP} {fixed(planet.number('log10_fap'), 1)}" for planet in planets) + ("." if planets else "")
    for number, one in enumerate(fitted, 1):
        if not _is_planet(one):
            text += (f" Candidate {number}, of {fixed(_points(one, 'period')[1], 1)} days, does not count as a planet: "
                     f"{'; '.join(_reasons(one))}.")
    for other in others:
        text += (f" The next candidate, of {fixed(_points(other, 'period')[1], 1)} days, has a {_LOG_BAYES} of "
                 f"{fixed(other.number('log10_bayes'), 1)} and does not count as a planet.")
    return text


def _add_table(result: Result, candidates: list[Result], unit: Unit, page: Page) -> None:
    velocity = result.text("kind") == "velocity"
    geometry = "times sin i" if velocity else "times g"
    rows = [[_LOG_BAYES, *(fixed(one.number("log10_bayes"), 2) for one in candidates)],
            [LOG_FAP, *(fixed(one.number("log10_fap"), 2) for one in candidates)]]
    lines = [("period, days", "period", 1.0), ("eccentricity", "eccentricity", 1.0),
             ("periastron, degrees", "periastron_deg", 1.0), ("epoch, days", "epoch", 1.0),
             (unit.label("amplitude"), "amplitude", unit.factor),
             (f"mass in Earths, {geometry}" + ("" if velocity else ", on A"), "mass_a_earth", 1.0)]
    if not velocity:
        lines.append((f"mass in Earths, {geometry}, on B", "mass_b_earth", 1.0))
    if any(one.has("star") for one in candidates):
        rows.append(["star", *(one.text("star") if one.has("star") else "" for one in candidates)])
        lines = [(name.replace(", times g", ""), key, factor) for name, key, factor in lines]
        lines += [("inclination or 180 minus it, degrees", "inclination_deg", 1.0),
                  ("node from the axis, degrees, to either side", "node_deg", 1.0)]
    rows += [[name, *(_interval(one, key, factor) for one in candidates)] for name, key, factor in lines]
    page.add_table("Median, and distances to the 16 and 84 % points of the posterior.",
                   ["", *(_name(one, number) for number, one in enumerate(candidates, 1))], rows)
    if not velocity:
        page.add("text", "The axis from A to B is that of the date." if result.has("axis") else
                 "The axis from A to B is taken as fixed: the period of a face-on orbit is wrong by the angle through which the "
                 "axis turns in one period, divided by 360 degrees.")


def _add_folded(table: Table, planet: Result, number: int, velocity: bool, unit: Unit, page: Page) -> None:
    best = [planet.number("best." + key) for key in ("period", "eccentricity", "periastron_deg", "epoch", "amplitude")]
    orbit = Orbit(best[0], best[1], math.radians(best[2]), best[3], best[4] * unit.factor, velocity)
    if not (orbit.period > 0 and 0 <= orbit.eccentricity < 1):
        raise planet.fail("best", "an orbit with a period above 0 and an eccentricity in [0, 1)")
    signal, residual = (unit.factor * table.numbers(name) for name in (f"signal_{number}", "residual"))
    page.add_figure(f"planet-{number}", planet_figures.folded(table.numbers("t"), signal, residual, orbit, unit.name),
                    f"{_name(planet, number).capitalize()}: the series less the other planets and the nuisance functions, folded over the period of "
                    "the joint fit, and the residuals of all.")


def _add_corner(path: pathlib.Path, planet: Result, number: int, result: Result, unit: Unit, page: Page) -> None:
    samples = results.array(path, 2)
    if samples.shape[1] != 10:
        raise malformed(path, f"has {samples.shape[1]} columns: must be 10")
    columns = [("period, days", samples[:, 0]), ("eccentricity", samples[:, 1]),
               (unit.label("amplitude"), unit.factor * samples[:, 4])]
    star = "" if result.text("kind") == "velocity" else " on A"
    columns += [(name, samples[:, column]) for name, column in (
        (f"mass{star}, Earths", 5), ("inclination, degrees", 8)) if numpy.isfinite(samples[:, column]).all()]
    page.add_figure(f"posterior-{number}", planet_figures.corner(columns),
                    f"{_name(planet, number).capitalize()}: {len(samples)} samples of the posterior. Dashed: the 16, 50 and 84 % points.")


def _sizes(table: Table, masses: bool, unit: Unit) -> tuple[Array, Array, Array]:
    """Period, upper limit and detectable size; NaN where there is none."""
    factor, end = (1.0, "_mass_a") if masses else (unit.factor, "")
    upper, detectable = (factor * table.numbers(name + end, finite=False) for name in ("upper", "detectable"))
    return table.numbers("period"), upper, numpy.where(numpy.isfinite(detectable), detectable, numpy.nan)


def _label(masses: bool, unit: Unit, result: Result) -> str:
    star = "" if result.text("kind") == "velocity" else " on A"
    return f"mass{star}, Earths" if masses else unit.label("amplitude")


def _add_limits(table: Table, result: Result, planets: list[Result], unit: Unit, page: Page) -> None:
    masses = bool(numpy.isfinite(table.numbers("upper_mass_a", finite=False)).any())
    key, factor = ("mass_a_earth", 1.0) if masses else ("amplitude", unit.factor)
    found = [(_points(one, "period")[1], factor * _points(one, key)[1]) for one in planets]
    period, upper, detectable = _sizes(table, masses, unit)
    if not numpy.isfinite(upper).any():
        raise malformed(table.path, "has no upper limit")
    page.add_figure("limits", planet_figures.limits(period, upper, detectable, _label(masses, unit, result), found, masses),
                    "Circular orbits of one planet more. Upper limit: a smaller one has a posterior probability of "
                    f"{100 * result.number('limits.probability'):.0f} %. Detectable: a search detects it with this probability, "
                    f"at a FAP of {result.number('detection_fap'):g}.")


def _edges(result: Result, key: str) -> Array:
    values = numpy.array(result.find(key), dtype=float)
    if values.ndim != 1 or len(values) < 2 or not (numpy.diff(values) > 0).all() or values[0] <= 0:
        raise result.fail(key, "increasing numbers above 0")
    return values


def _add_map(folder: pathlib.Path, result: Result, unit: Unit, page: Page) -> None:
    masses = result.text("map.size") == "mass"
    periods, sizes = _edges(result, "map.period_edges"), _edges(result, "map.size_edges")
    table = Table(folder / "map.csv")
    fraction = table.numbers("detected") / table.numbers("injections")
    shape = len(sizes) - 1, len(periods) - 1
    if len(fraction) != shape[0] * shape[1]:
        raise malformed(folder / "map.csv", f"has {len(fraction)} cells: must be {shape[0] * shape[1]}, as in result.json")
    lines = None
    if result.has("limits"):
        period, _, detectable = _sizes(Table(folder / "limits.csv"), masses, unit)
        lines = period, detectable
    figure = planet_figures.detection_map(periods, sizes * (1.0 if masses else unit.factor), fraction.reshape(shape),
                                          _label(masses, unit, result), masses, lines)
    page.add_figure("map", figure, f"Fraction of {result.whole('map.injections')} injected planets per cell that a search detects "
                    f"at a FAP of {result.number('detection_fap'):g}, with eccentricities from their prior.")
