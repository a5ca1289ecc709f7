"""Simulated frames of a telescope that the model does not describe, and series with wrong sigmas, times, units and samples: is
anything called a planet that is none, and do planets stay? The short form: test_doubt_campaign.py.

    doubt_campaign.py [frames] [noise] [mistakes] [missions] [--sets 200] [--seed 1] [--jobs 0]

frames    281 frames with an effect of the detector, or of optics that the model lacks: see doubt_frames.py.
noise     Series of noise that is 1, 1.1, 1.2, 1.5, 2 and 3 times its sigmas, 281 and 400 samples: false planets, at most 1 %,
          and the share whose chi-square is called poor, at least 99 % from 1.5 times on.
mistakes  A planet of 3 uas and 300 d, 400 samples of 1 uas, with one mistake in each row: no planet, or the true one. The
          separations are those of numpy, but for times that are late and exposures given by their start, whose
          separations are predicted by the library.
missions  Planets of thirteen missions, 281 samples of 2.2 uas: found, and the ratio of the errors of period and amplitude
          to those of exact sigmas.

Without a mode all run. The exit status is 1 if a figure is missed."""
# promise: wrong-models-make-no-planet
import itertools
import math
import os
import pathlib
import sys
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "build" / "python"), str(ROOT / "tests" / "support")]
import campaign  # noqa: E402
import doubt_frames  # noqa: E402
import planet_model as model  # noqa: E402
import toliman  # noqa: E402

SPAN, SIGMA, N = 1095.0, 1e-6, 400  # d, arcsec
KNOWN = {"unit": 1, "parallax_arcsec": 0.75, "star_masses": (1.08, 0.91)}
FACTORS, COUNTS = (1, 1.1, 1.2, 1.5, 2, 3), (281, 400)
PERIOD, AMPLITUDE, MASS = 300.0, 3e-6, 1.6  # of the planet with mistakes: d, arcsec, Earths on A
# Period (d), amplitude (uas), eccentricity.
MISSIONS = ((430, 2.60, 0), (300, 0.967, 0), (220, 5.00, 0), (560, 9.98, 0.023), (365, 2.576, 0), (182, 2.581, 0),
            (477, 3.18, 0), (132, 2.92, 0), (514, 4.09, 0), (165, 3.19, 0), (384, 4.35, 0), (290, 2.91, 0),
            (430, 2.60, 0.3))
MISSION_SIGMA, MISSION_N = 2.2e-6, 281


def days(random, n, span=SPAN):
    return numpy.sort(random.uniform(0, span, n))


def search(t, y, sigma, **options):
    return toliman.planets(t, y, sigma, **{**KNOWN, "threads": 1, "samples": 1000, **options})


def of_noise(task):
    """Number of planets, and the word for the fit, of a series without a planet."""
    factor, n, seed = task
    random = numpy.random.default_rng([seed, n])
    found = search(days(random, n), factor * SIGMA * random.normal(size=n), SIGMA)
    return found.info.planets, found.info.goodness


def noise(pool, sets, seed):
    wrong = []
    print("| noise over sigma | samples | series | false planets | poor | too good |\n|---|---|---|---|---|---|")
    for factor in FACTORS:
        for n in COUNTS:
            found = pool.map(of_noise, [(factor, n, seed * 10**6 + k) for k in range(sets)], chunksize=1)
            planets = sum(count > 0 for count, _ in found)
            poor, low = (sum(word == name for _, word in found) for name in ("poor", "too good"))
            print(f"| {factor} | {n} | {sets} | {planets} | {poor} | {low} |", flush=True)
            if planets > 0.01 * sets:
                wrong.append(f"noise of {factor} sigma, {n} samples: {planets} of {sets} have a planet: must be at most 1 %")
            if factor >= 1.5 and poor < 0.99 * sets:
                wrong.append(f"noise of {factor} sigma, {n} samples: {poor} of {sets} are poor: must be at least 99 %")
            if factor == 1 and poor > 0.01 * sets:
                wrong.append(f"right sigmas, {n} samples: {poor} of {sets} are poor: must be at most 1 %")
    return wrong


def on_the_sky(random):
    """Series of exposures of 60 s in a low orbit, with the planet: search(times that are given, seconds), which reduces the
    separations at these times."""
    sky, ns = toliman.Sky("alpha-cen", altitude_km=600), 10**9
    start = toliman.parse_time("2027-01-01")
    middle = start + (days(random, N) * 86400).astype(numpy.int64) * ns
    seen = sky.predict(middle)
    t = (middle - start) / 86400e9
    planet = AMPLITUDE * numpy.sin(2 * math.pi * t / PERIOD + 1)
    measured = (seen["geometric_arcsec"] + planet) * seen["factor"] + SIGMA * random.normal(size=N)
    elements, _, priors = sky.error_columns()

    def searched(late_s, **options):
        given = middle + late_s * ns
        there = sky.predict_exposures(numpy.stack([given - 30 * ns, given + 30 * ns], 1))
        reduced = measured / there["factor"] - there["geometric_arcsec"]
        return search((given - start) / 86400e9, reduced, SIGMA, rows=there["partials"][:, elements],
                      priors=[math.inf, *priors], position_angle_deg=there["geometric_angle_deg"], **options)
    return searched


def mistakes(seed):
    """Yields (name, result, whether the planet must be found)."""
    random = numpy.random.default_rng([seed, 4])
    t, errors = days(random, N), SIGMA * random.normal(size=N)
    planet = AMPLITUDE * numpy.sin(2 * math.pi * t / PERIOD + 1)
    y = planet + errors

    def outlier(size):
        changed = y.copy()
        changed[7] += size
        return changed
    sky = on_the_sky(random)
    yield "right", search(t, y, SIGMA), True
    yield "right, in a low orbit", sky(0), True
    yield "times 37 s late", sky(37), False
    yield "start for middle of 60 s", sky(-30), False
    yield "sigma 1000 times too small", search(t, y, SIGMA / 1000), False
    for factor in 1.5, 2, 4:
        yield f"noise alone, sigma {factor} times too small", search(t, errors, SIGMA / factor), False
    for size in 1e-4, 1e-3, 1.0:
        name = f"one sample {size / SIGMA:g} sigma off"
        yield name, search(t, outlier(size), SIGMA), False
        yield f"{name}, left out", search(t, outlier(size), SIGMA, clip=True), True
    yield "period outside 400 to 1000 d", search(t, y, SIGMA, period_min=400), False
    yield "times in years", search(t / 365.25, y, SIGMA), False
    yield "separations not reduced", search(t, y + 9.7 + 1e-3 * t + 1e-4 * numpy.sin(2 * math.pi * t / 365.25), SIGMA), False
    yield "px taken for arcsec, frames of chi-square 60", search(t, y / 0.375, SIGMA / 0.375, frame_chi_square=60), False
    yield "every sample five times", search(*(numpy.repeat(x, 5) for x in (t, y)), SIGMA), None


def is_true(found):
    """Whether the only planet is the one that was drawn."""
    return [abs(one.period[1] - PERIOD) < 15 and abs(one.mass_a[1] - MASS) < 0.2 for one in found.planets] == [True]


def all_mistakes(seed, most=None):
    wrong, longest = [], 100 if os.environ.get("TOLIMAN_SANITIZE") else 10  # s
    print("| mistake | verdict | period, d | mass, Earths | log10 Bayes | chi-square | outliers | s |\n|---|---|---|---|---|---|---|---|")
    began = time.process_time()
    for name, found, must in itertools.islice(mistakes(seed), most):
        info, one, seconds = found.info, found.candidates[0], time.process_time() - began
        print(f"| {name} | {one.verdict}{': ' if one.reasons else ''}{'; '.join(one.reasons)} | {one.period[1]:.0f} | "
              f"{one.mass_a[1]:.3g} | {one.log10_bayes:.3g} | {info.chi_square:.3g} {info.goodness} | {info.outliers} | "
              f"{seconds:.1f} |", flush=True)
        if found.planets and not is_true(found) or must and not found.planets:
            wrong.append(f"{name}: {len(found.planets)} planets")
        if must is False and found.planets:
            wrong.append(f"{name}: has a planet")
        if seconds > longest:
            wrong.append(f"{name}: {seconds:.1f} s: must be at most {longest}")
        began = time.process_time()
    return wrong


def of_mission(task):
    """Whether the planet is found, its error in standard errors, and the errors over those of exact sigmas."""
    (period, amplitude, e), seed = task
    random = numpy.random.default_rng([seed, int(period)])
    t = days(random, MISSION_N)
    y = model.separation(t, period, e, random.uniform(0, 360), random.uniform(0, period), amplitude * 1e-6)
    y += MISSION_SIGMA * random.normal(size=MISSION_N)
    found, exact = (search(t, y, MISSION_SIGMA, jitter=jitter) for jitter in (True, False))
    one, same = found.candidates[0], exact.candidates[0]
    ratios = [numpy.ptp(getattr(one, name)) / numpy.ptp(getattr(same, name)) for name in ("period", "amplitude")]
    error = abs(one.period[1] - period) / numpy.ptp(one.period) * 2
    return len(found.planets) == 1, error, one.log10_bayes, one.reasons, ratios


def missions(pool, seed):
    wrong = []
    print("| period, d | amplitude, uas | eccentricity | found | error, sigmas | log10 Bayes | errors over exact |\n|---|---|---|---|---|---|---|")
    for planet, (found, error, odds, reasons, ratios) in zip(MISSIONS, pool.map(of_mission, [(p, seed) for p in MISSIONS], chunksize=1)):
        print(f"| {planet[0]} | {planet[1]} | {planet[2]} | {'yes' if found else '; '.join(reasons)} | {error:.1f} | {odds:.1f} | "
              f"{ratios[0]:.3f}, {ratios[1]:.3f} |")
        if not found and planet[1] > 1:
            wrong.append(f"{planet}: is not found: {reasons}")
        if not 0.95 <= min(ratios) <= max(ratios) <= 1.05:
            wrong.append(f"{planet}: errors over those of exact sigmas are {ratios}: must be within 5 %")
    return wrong


MODES = {"frames": lambda pool, given: doubt_frames.effects(pool, given.seed),
         "noise": lambda pool, given: noise(pool, given.sets, given.seed),
         "mistakes": lambda pool, given: all_mistakes(given.seed),
         "missions": lambda pool, given: missions(pool, given.seed)}


if __name__ == "__main__":
    sys.exit(campaign.run(__doc__, MODES, 200, "number of series of noise"))
