"""Forty missions that nobody has seen, from the downlink to the planet by the three commands with their defaults: are the planets
found that are there, to the stated errors, and none that is not? The short form: test_sky_campaign.py.

    sky_campaign.py [sky] [remedies] [--sets 40] [--seed 1] [--jobs 0]

A mission is that of examples/sky/mission.py: unknown optics, an orbit of the stars that differs from the published one by its errors,
a spacecraft in a low orbit, arcs, losses, repeated frames out of order. Of ten missions, three have no planet, four have one of A
(0.5 to 10 uas, 60 to 900 d), one has two; the last two have the same complication without and with a planet: optics that drift, errors
of the surface at mid frequencies, a pupil of 1024 cells, a detector that is not ideal. sky: all with defaults. remedies: those with a
complication, whose model is incomplete, with the remedy that calibrate names, --improve or for a detector --detector.

Wrong: a planet that is not there; one that is there, whose amplitude is 6 standard deviations of that of a sinusoid, and that is not
found; a period that is wrong by more than 4 stated errors; a limit that excludes a planet that was injected into the series of a mission
without one, in more than 5 % (at 3 standard errors); a planet that is named where the frames do not fit."""
# promise: missions-are-found-by-defaults
import argparse
import json
import math
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "build" / "python"), str(ROOT / "examples" / "sky")]
import campaign  # noqa: E402
import compare  # noqa: E402
import mission  # noqa: E402
import toliman  # noqa: E402

KINDS = "none", "none", "none", "one", "one", "one", "one", "two", "complicated", "complicated with one"
COMPLICATIONS = {"drift": {"drift": 1.0}, "mid": {"mid": 0.5}, "cells": {"cells": 1024}, "detector": {"detector": True}}
REMEDY = {"drift": "--improve", "mid": "--improve", "cells": "--improve", "detector": "--detector"}
INJECTED, SMALLEST_UAS, LARGEST_UAS, MOST_PULL = 20, 0.2, 2.0, 4
SIZES = {"frames": 365, "photons": 1e12, "side": 0, "scene": mission.SCENE}
HEADER = ("| seed | mission | truth: d, uas | calibration, chi-square | said: d, uas | log10 odds | verdict | errors: mean, scatter | "
          "calibrate, track, planet, processor s |\n|---|---|---|---|---|---|---|---|---|")


def kind_of(seed):
    """One of KINDS, or the complication."""
    kind = KINDS[seed % 10]
    return list(COMPLICATIONS)[seed // 10 % 4] if kind.startswith("complicated") else kind


def options_of(seed, folder, sizes):
    """The mission of a seed, and its kind."""
    kind = KINDS[seed % 10]
    random = numpy.random.default_rng([seed, 7])
    periods = [math.exp(random.uniform(math.log(60), math.log(900)))]
    if kind == "two":
        periods.append(periods[0] * (0.45 if periods[0] > 200 else 2.3))
    planets = [f"{period}:{math.exp(random.uniform(math.log(0.5), math.log(10)))}" for period in periods]
    given = {"folder": folder, "seed": seed, "cells": 0, "mid": 0, "drift": 0, "detector": False, **sizes,
             "planet": planets if kind in ("one", "two", "complicated with one") else None,
             "none": kind in ("none", "complicated"), **COMPLICATIONS.get(kind_of(seed), {})}
    return argparse.Namespace(**given), kind_of(seed)


def command(folder, *words):
    """Processor seconds that a command took. planet exits with 3 if no frame is accepted."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([compare.program(), *words], cwd=folder, capture_output=True, text=True)
    if done.returncode not in (0, 4) + (3,) * (words[0] == "planet"):
        raise RuntimeError(f"{words[0]} exits with {done.returncode}: {done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def chain(folder, *remedy):
    """Processor seconds of the three commands."""
    for name in ("mission", "fitted.json"):
        subprocess.run(["rm", "-rf", folder / name], check=True)
    return [command(folder, "calibrate", "scene.json", "downlink/", "--force", *remedy),
            command(folder, "track", "--fit", "fitted.json", "--state", "mission", "--every", "1000", "downlink/"),
            command(folder, "planet", "mission", "--max", "2")]


def is_detectable(folder, true):
    """Whether its amplitude is 6 standard deviations of that of a sinusoid in white noise of the sigmas, with a period that the
    search covers and that is not above half of the mission."""
    series = toliman.Measurements(folder / "mission")
    sigma_uas = numpy.median(series.sigma) * series.info.unit * 1e6
    days = numpy.ptp(series.t)
    return true["amplitude_uas"] > 6 * sigma_uas * math.sqrt(2 / len(series)) and 60 < true["period_days"] < min(1000, days / 2)


def pulls(true, found):
    """Errors of period, amplitude and mass in the stated ones."""
    pairs = (("period", "period_days"), ("amplitude_uas", "amplitude_uas"), ("mass_a_earth", "mass_earth"))
    return [(found[key][1] - true[name]) / ((found[key][2] - found[key][0]) / 2) for key, name in pairs]


def text_of(interval, decimals):
    """The median, and half the width of the central 68 %."""
    low, median, high = interval
    return f"{median:.{decimals}f} +- {(high - low) / 2:.{decimals}f}"


def excluded(folder, seed):
    """How many of the planets that are injected into the series the limits exclude."""
    series, random = toliman.Measurements(folder / "mission"), numpy.random.default_rng([seed, 8])
    info, functions, wrong = series.info, series.functions, 0
    for _ in range(INJECTED):
        period = math.exp(random.uniform(math.log(80), math.log(500)))
        uas = math.exp(random.uniform(math.log(SMALLEST_UAS), math.log(LARGEST_UAS)))
        wave = uas * 1e-6 / info.unit * numpy.cos(2 * numpy.pi * series.t / period + random.uniform(0, 2 * numpy.pi))
        changed = toliman.Measurements.of(series.t, series.y + wave, series.sigma, kind="reduced", unit=info.unit)
        for function in functions:
            changed.add_column(function.name, series.values(function.name), function.sigma)
        found = toliman.planets(changed, star_masses=(1.0788, 0.9092), parallax_arcsec=0.75081)
        # a planet that is found is part of the joint fit, not of what the limits exclude
        wrong += len(found.planets) == 0 and found.limits([period])["upper"][0] < uas * 1e-6 / info.unit
    return wrong


def judge(name, folder, seconds, wrong):
    """The row of a mission, and its pulls."""
    result = compare.compare(folder)
    all_pulls = []
    for true, found in compare.pairs(result["planets"], result["found"]):
        if true and found:
            all_pulls.append(pulls(true, found))
            if abs(all_pulls[-1][0]) > MOST_PULL:
                wrong.append(f"{name}: a period of {found['period'][1]:.0f} d instead of {true['period_days']:.0f} d")
        elif found:
            wrong.append(f"{name}: a planet of {found['period'][1]:.0f} d that is not there")
        elif result["complete"] and is_detectable(folder, true):
            wrong.append(f"{name}: the planet of {true['period_days']:.0f} d is not found")
    if result["goodness"] == "poor" and result["found"]:
        wrong.append(f"{name}: a planet, though the frames do not fit")
    truth = ", ".join(f"{one['period_days']:.0f} {one['amplitude_uas']:.2f}" for one in result["planets"]) or "none"
    best = result["candidates"][:2]
    said = ", ".join(f"{text_of(one['period'], 0)} {text_of(one['amplitude_uas'], 2)}" for one in best[:max(1, len(result["found"]))])
    verdicts = "; ".join(one["verdict"] if not one["reasons"] else one["reasons"][0] for one in best[:max(1, len(result["found"]))])
    errors = f"{result['errors'].mean():+.2f}, {result['errors'].std():.2f}" if len(result["errors"]) else ""
    row = (f"| {name} | {truth} | {'complete' if result['complete'] else 'incomplete'}, {result['chi_square']:.4f}; frames {result['goodness']} | {said} | "
           f"{', '.join(format(one['log10_bayes'], '.1f') for one in best)} | {verdicts} | {errors} | "
           f"{', '.join(format(one, '.0f') for one in seconds)} |")
    return row, all_pulls, result


def of_seed(task):
    """Row, pulls, (excluded, injected) and what is wrong of a mission, with the options of a remedy or none."""
    seed, sizes, *remedy = task
    wrong, limits = [], (0, 0)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name) / "run"
        options, kind = options_of(seed, folder, sizes)
        mission.draw(options)
        row, all_pulls, result = judge(" ".join([f"{seed} | {kind}", *remedy]), folder, chain(folder, *remedy), wrong)
        if kind == "none" and result["complete"]:
            limits = (excluded(folder, seed), INJECTED)
    return row, all_pulls, limits, wrong


def sky(pool, tasks):
    """Prints the table and the sums. Returns what is wrong."""
    print(HEADER, flush=True)
    all_wrong, all_pulls, all_limits = [], [], []
    for row, found_pulls, limits, wrong in pool.imap(of_seed, tasks):
        print(row, flush=True)
        all_wrong += wrong
        all_pulls += found_pulls
        all_limits.append(limits)
    if all_pulls:
        rms = numpy.sqrt(numpy.mean(numpy.square(all_pulls), axis=0))
        print(f"\n{len(all_pulls)} planets found; rms of the errors of period, amplitude and mass over the stated ones: "
              + ", ".join(f"{one:.2f}" for one in rms))
    count, total = (sum(numbers) for numbers in zip((0, 0), *all_limits))
    if total:
        print(f"limits exclude {count} of {total} injected planets")
        if count > 0.05 * total + 3 * math.sqrt(0.05 * 0.95 * total):
            all_wrong.append(f"limits exclude {count} of {total} injected planets: must be 5 %")
    return all_wrong


def main():
    def seeds(given):
        return range(given.seed, given.seed + given.sets)

    modes = {"sky": lambda pool, given: sky(pool, [(seed, SIZES) for seed in seeds(given)]),
             "remedies": lambda pool, given: sky(pool, [(seed, SIZES, REMEDY[kind]) for seed in seeds(given)
                                                        if (kind := kind_of(seed)) in REMEDY])}
    return campaign.run(__doc__, modes, sets=40, sets_help="missions")


if __name__ == "__main__":
    sys.exit(main())
