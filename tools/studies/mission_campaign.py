"""Simulated missions of three years: is the period of a planet found in the separations of alpha Centauri, and how often is
one found that is not there? The short form: test_missions.py.

    mission_campaign.py [--missions 200] [--seed 1]

A mission has 836 daily exposures of two intervals of half an hour, 600 km above the Earth, with gaps when the Sun is near.
The true orbit is drawn from the published standard deviations of its elements. The measured separations have white noise
of 3e-6 px. A third of the missions has a planet on a circular orbit, a third one with an eccentricity below 0.3, a third
none. A seed draws kind and parameters of a mission. The search receives dates and separations alone. All searches end
before the first result is compared with the truth.

The separations are reduced to the published orbit.

A planet is found if the highest peak has a false alarm probability (FAP) below 1e-3 and its period is within 10 % of the
true one. Any peak with this FAP is an alarm if there is no planet.

The functions of the search, in addition to the mean: the derivatives of the separation by the elements with the published
standard deviations as priors, none, or a polynomial in time. The exit status is 1 if the search with the derivatives misses
a figure, which is printed."""
import argparse
import collections
import functools
import json
import logging
import math
import pathlib
import sys
import tempfile
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402

SECOND, DAY, DAYS, SAMPLES = 10**9, 86400 * 10**9, 1095, 836
SCALE, SIGMA, AMPLITUDE, FREQUENCY = 0.375, 3e-6, 1.2e-6, 0.05  # arcsec per px, px, arcsec, cycles per day
PERIODS, MOST_ECCENTRIC, LOG10_FAP, ALTITUDE = (300, 500), 0.3, -3, 600
KINDS = "circular", "eccentric", "none"
ORBIT = "mean and orbit, with priors"
TRENDS = {"mean": 0, "polynomial of order 4": 4, "polynomial of order 5": 5}
SEARCHES = ORBIT, *TRENDS
Truth = collections.namedtuple("Truth", "elements amplitude period eccentricity periastron anomaly")
Found = collections.namedtuple("Found", "period log10_fap")


@functools.cache
def published():
    """Returns the predictor of the published orbit."""
    return toliman.Sky(altitude_km=ALTITUDE)


@functools.cache
def exposures():
    """Returns the on-target intervals [SAMPLES][2][2] of the days when the Sun is 50 degrees away, without random losses."""
    start = toliman.parse_time("2027-01-01T00:00:00", scale="tai")
    days = start + DAY * numpy.arange(DAYS)
    days = days[published().predict(days + DAY // 2)["sun_angle_deg"] > 50]
    taken = numpy.sort(numpy.random.default_rng(1).choice(days, SAMPLES, replace=False))
    arcs = numpy.array([[0, 1800], [5800, 7600]])  # in two revolutions of 96.7 minutes
    return list(taken[:, None, None] + arcs * SECOND)


def middles():
    """Returns the days since the first exposure."""
    taken = numpy.array([one.mean() for one in exposures()])
    return (taken - taken[0]) / DAY


def draw(kind, seed):
    """Draws the truth of a mission."""
    random = numpy.random.default_rng([seed, 1])
    elements = {name: value + sigma * random.normal() for name, (value, sigma) in published().elements.items()}
    period, eccentricity = random.uniform(*PERIODS), random.uniform(0, MOST_ECCENTRIC)
    periastron, anomaly = random.uniform(0, 2 * math.pi, 2)
    return Truth(elements, 0 if kind == "none" else AMPLITUDE, period, eccentricity if kind == "eccentric" else 0, periastron,
                 anomaly)


def displacement(truth, days):
    """Returns the displacement of a star along the binary's axis by a planet, arcsec."""
    mean = 2 * math.pi * days / truth.period + truth.anomaly
    eccentric, e = mean, truth.eccentricity
    for _ in range(50):
        eccentric = mean + e * numpy.sin(eccentric)
    return truth.amplitude * (math.cos(truth.periastron) * (numpy.cos(eccentric) - e)
                              - math.sin(truth.periastron) * math.sqrt(1 - e * e) * numpy.sin(eccentric))


def measure(kind, seed):
    """Returns the measured separations of a mission, px."""
    truth = draw(kind, seed)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "system.json"
        published().save(path)
        system = json.loads(path.read_text())
    system["orbit"].update(truth.elements)
    with toliman.Sky(json.dumps(system), altitude_km=ALTITUDE) as sky:
        seen = sky.predict_exposures(exposures())
    noise = SIGMA * numpy.random.default_rng([seed, 2]).normal(size=SAMPLES)
    return (seen["separation_arcsec"] + displacement(truth, middles())) / SCALE + noise


@functools.cache
def functions(name):
    """Returns the options of a periodogram with these functions, and the values of the columns."""
    if name in TRENDS:
        return {"trend": TRENDS[name], "span": (0, DAYS) if TRENDS[name] else None}, None
    elements, bounds, priors = published().error_columns(SCALE)
    rows = published().predict_exposures(exposures())["partials"][:, elements]
    return {"columns": len(elements), "column_bounds": bounds, "priors": [math.inf, *priors]}, rows


def search(measured):
    """Returns the highest peak of the separations of a mission (px) with each set of functions."""
    reduced = published().reduce(exposures(), measured * SCALE, functions=False).y / SCALE
    days, found = middles(), {}
    f0, df, _ = toliman.suited_grid(days)
    for name in SEARCHES:
        options, rows = functions(name)
        with toliman.Periodogram(f0, df, int((FREQUENCY - f0) / df) + 1, value_bound=1, sigma_floor=SIGMA, double_limb=True,
                                 **options) as periodogram:
            periodogram.push_many(days, reduced, SIGMA, rows=rows)
            best = periodogram.fit(days, reduced, SIGMA, rows=rows).period if periodogram.peak().log10_fap < LOG10_FAP else 0
            found[name] = Found(best, periodogram.peak().log10_fap)
    return found


def bound(truth, name):
    """Returns the Cramer-Rao bound of the period, days, of a circular orbit with these functions and their priors."""
    options, rows = functions(name)
    days = middles()
    phase = 2 * math.pi * days / truth.period + truth.anomaly + truth.periastron
    amplitude = AMPLITUDE / SCALE
    columns = [amplitude * 2 * math.pi * days * numpy.sin(phase), numpy.cos(phase), numpy.sin(phase),
               *numpy.polynomial.chebyshev.chebvander(2 * days / DAYS - 1, options.get("trend", 0)).T]
    if rows is not None:
        columns += list(rows.T)
    design = numpy.transpose(columns) / SIGMA
    priors = numpy.concatenate([[math.inf] * 3, options.get("priors", [math.inf] * (len(columns) - 3))])
    design = numpy.vstack([design, numpy.diag(1 / priors)])
    scale = numpy.sqrt((design**2).sum(0))
    upper = numpy.linalg.qr(design / scale, mode="r")
    return truth.period**2 * numpy.linalg.norm(numpy.linalg.inv(upper)[0]) / scale[0]


def median_error(bounds):
    """Returns the median |error| of Gaussian errors with these standard deviations."""
    low, high = 0, max(bounds)
    for _ in range(60):
        middle = (low + high) / 2
        share = sum(math.erf(middle / one / math.sqrt(2)) for one in bounds) / len(bounds)
        low, high = (middle, high) if share < 0.5 else (low, middle)
    return low


def fly(missions, seed):
    """Searches `missions` missions of each kind. Returns the rows of the table: shares, errors and bounds by functions."""
    kinds = numpy.random.default_rng(seed).permutation(numpy.repeat(KINDS, missions)).tolist()
    seeds = [seed * 10**6 + k for k in range(len(kinds))]
    results = [search(measure(kind, one)) for kind, one in zip(kinds, seeds)]
    truths = [draw(kind, one) for kind, one in zip(kinds, seeds)]
    rows = {}
    for name in SEARCHES:
        row = rows[name] = {"errors": [], "bounds": []} | dict.fromkeys(KINDS, 0)
        for kind, truth, result in zip(kinds, truths, results):
            found, is_alarm = result[name], result[name].log10_fap < LOG10_FAP
            is_right = is_alarm and abs(found.period - truth.period) < 0.1 * truth.period
            row[kind] += is_alarm if kind == "none" else is_right
            if kind == "circular" and is_right:
                row["errors"].append(abs(found.period - truth.period))
                row["bounds"].append(bound(truth, name))
    return rows


def table(rows, missions):
    """Returns the lines of a Markdown table."""
    lines = ["| functions | planet found, e = 0 | e < 0.3 | alarms without planet | median error of the period | at the "
             "Cramer-Rao bound |", "|---|---|---|---|---|---|"]
    for name, row in rows.items():
        errors = f"{numpy.median(row['errors']):.1f} d | {median_error(row['bounds']):.1f} d" if row["errors"] else " | "
        shares = " | ".join(f"{100 * row[kind] / missions:.1f} %" for kind in KINDS)
        lines.append(f"| {name} | {shares} | {errors} |")
    return lines


def misses(rows, missions):
    """Returns the figures of the search with the orbit that are missed."""
    row = rows[ORBIT]
    wrong = [f"{kind}: {row[kind]} of {missions} found: must be at least 90 %" for kind in KINDS[:2]
             if row[kind] < 0.9 * missions]
    if row["none"] > 0.01 * missions:
        wrong.append(f"{row['none']} of {missions} alarms without planet: must be at most 1 %")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--missions", type=int, default=200, help="of each kind")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    logging.getLogger("toliman").setLevel(logging.ERROR)
    began = time.monotonic()
    rows = fly(options.missions, options.seed)
    print(f"{options.missions} missions of each kind, {SAMPLES} separations of {SIGMA:g} px, planet of {AMPLITUDE * 1e6:g} uas "
          f"and {PERIODS[0]} to {PERIODS[1]} d, {time.monotonic() - began:.0f} s\n")
    print("\n".join(table(rows, options.missions)))
    wrong = misses(rows, options.missions)
    print("\n".join(["", *wrong]) if wrong else "")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
