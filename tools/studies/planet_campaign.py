"""Simulated series of alpha Centauri with known planets: are the posteriors of planet.h calibrated, and its limits right?
The short form: test_planet_campaign.py.

    planet_campaign.py [sbc] [null] [short] [pair] [limits] [--sets 500] [--seed 1] [--jobs 0]

The series are reduced separations of three years, 600 km above the Earth: 836 days on which the Sun is 50 degrees away,
or their means of five days. They contain the errors of the reference orbit, drawn from their priors, white noise of 1e-6
px per day, and an offset. The search fits the derivatives by the elements with their priors, and has the position angles.

sbc     Series whose planet is drawn from the priors of the header. If posteriors are right, the rank of the truth among
        the samples is uniform (Talts et al. 2018, arXiv:1804.06788). Compared with the Kolmogorov-Smirnov test; and the
        share of truths within the 16 and 84 % points.
null    Series without a planet: the share with a Bayes factor above 10.
short   Planets in series of 120, 200 and 365 d, also shorter than the period, with the default priors: the share of periods and
        amplitudes within 4 half widths of their central 68 %, where the odds are decisive.
pair    A giant of 340 uas with an eccentricity of 0.4 and 750 d, and an Earth of 1.2 uas and 226 d: both periods within
        1.5 % in all of 20 series, and the Earth's mass within two half widths of its central 68 % in 17 at least.
limits  At seven periods, also beyond half the span: the share of planets that are there and are excluded, 5 %; and of
        those of the detectable amplitude that a search and injections call planets, 95 %.

Without a mode all five run. The exit status is 1 if a figure is missed."""
# promises: detectable-planets-are-found, false-planets-are-rare, upper-limits-hold
import functools
import math
import pathlib
import sys

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "build" / "python"), str(ROOT / "tests" / "support")]
import mission_campaign as mission  # noqa: E402
import campaign  # noqa: E402
import planet_model as model  # noqa: E402
import toliman  # noqa: E402

SCALE, SIGMA = mission.SCALE, 1e-6  # arcsec per px; px per day
MASSES, PARALLAX = (1.0788, 0.9092), 0.750
PERIODS, AMPLITUDES = (60, 1000), (0.05e-6 / SCALE, 5e-6 / SCALE)  # d; px
NAMES = "period", "eccentricity", "amplitude", "mass_a"
GIANT = {"period": 750, "e": 0.4, "amplitude": 340e-6 / SCALE}
EARTH = {"period": 226, "e": 0.0, "amplitude": 1.2e-6 / SCALE}
DRAWS, LEAST_P, INJECTIONS = 1000, 0.01, 4000
LIMIT_PERIODS = 120, 250, 364, 500, 600, 800, 900
SHORT = tuple((span, period, uas) for span in (120, 200, 365) for period in (100, 200, 400) for uas in (5, 20))  # d, d, uas
LEAST_WITHIN = 0.98
LONGITUDES = 40, 130  # degrees from the node to periastron, of the pair


@functools.cache
def observations(five_days):
    """Returns days, position angles, partial derivatives, sigmas (px) and the standard deviations of their coefficients."""
    elements, _, priors = mission.published().error_columns(SCALE)
    seen = mission.published().predict_exposures(mission.exposures())
    days, rows, sigma = mission.middles(), seen["partials"][:, elements], numpy.full(mission.SAMPLES, SIGMA)
    angles = seen["geometric_angle_deg"]
    if five_days:
        group = (days // 5).astype(int)
        counts = numpy.bincount(group)
        kept = counts > 0
        days, angles, *columns = (numpy.bincount(group, values)[kept] / counts[kept] for values in (days, angles, *rows.T))
        rows, sigma = numpy.stack(columns, 1), SIGMA / numpy.sqrt(counts[kept])
    return days, angles, rows, sigma, priors


def search(five_days, y, **options):
    days, angles, rows, sigma, priors = observations(five_days)
    return toliman.planets(days, y, sigma, rows=rows, priors=[math.inf, *priors], position_angle_deg=angles, unit=SCALE,
                           parallax_arcsec=PARALLAX, star_masses=MASSES, period_min=PERIODS[0], period_max=PERIODS[1],
                           threads=1, **options)


def without_planet(five_days, random):
    """Draws noise, offset and errors of the orbit."""
    days, _, rows, sigma, priors = observations(five_days)
    return sigma * random.normal(size=len(days)) + rows @ (priors * random.normal(size=len(priors))) + 1e-3 * random.normal()


def signal(five_days, period, e, anomaly, amplitudes):
    """Signal with the amplitudes cos and sin of periastron along the mean axis, and across."""
    days, angles, *_ = observations(five_days)
    return numpy.asarray(amplitudes) @ model.bases(days, angles, period, e, anomaly)


def coplanar(five_days, amplitude, longitude_deg):
    """Amplitudes of an orbit in the plane of the binary, with `amplitude` along the mean axis, from the angle between node
    and periastron: Thiele-Innes constants."""
    elements = {name: math.radians(value) for name, (value, _) in mission.published().elements.items() if name.endswith("deg")}
    node, tilt, w = elements["node_deg"], elements["inclination_deg"], math.radians(longitude_deg)
    axis = math.radians(observations(five_days)[1].mean()) - node
    towards, ahead = numpy.array([math.cos(w), math.sin(w)]), numpy.array([-math.sin(w), math.cos(w)])
    foreshortened = numpy.array([1, math.cos(tilt)])
    along, across = numpy.array([math.cos(axis), math.sin(axis)]), numpy.array([-math.sin(axis), math.cos(axis)])
    constants = numpy.array([towards @ (foreshortened * along), -(ahead @ (foreshortened * along)),
                             towards @ (foreshortened * across), -(ahead @ (foreshortened * across))])
    return amplitude * constants / math.hypot(*constants[:2])


def rank(value, samples):
    """Share of the samples below the value; equal ones count half."""
    return ((samples < value).sum() + (samples == value).sum() / 2) / len(samples)


def calibrate(task):
    """Ranks of the true period, eccentricity, amplitude and mass, and whether each is within the central 68 %."""
    five_days, seed = task
    random = numpy.random.default_rng([seed, five_days])
    period = math.exp(random.uniform(*numpy.log(PERIODS)))
    e, scale = model.draw_eccentricity(random), math.exp(random.uniform(*numpy.log(AMPLITUDES)))
    amplitudes, anomaly = scale * random.normal(size=4), random.uniform(0, 2 * math.pi)
    y = without_planet(five_days, random) + signal(five_days, period, e, anomaly, amplitudes)
    found = search(five_days, y, seed=seed, samples=DRAWS, amplitude_min=AMPLITUDES[0], amplitude_max=AMPLITUDES[1])
    amplitude, samples, planet = math.hypot(*amplitudes[:2]), found.samples(0, DRAWS), found.candidates[0]
    truth = [period, e, amplitude, model.mass_of_separation(amplitude * SCALE, period, MASSES[0], PARALLAX)]
    inside = [getattr(planet, name)[0] <= value <= getattr(planet, name)[2] for name, value in zip(NAMES, truth)]
    return [rank(value, samples[name]) for name, value in zip(NAMES, truth)], inside


def uniform_p(ranks):
    """p-value of the Kolmogorov-Smirnov test of a uniform distribution: Stephens' approximation."""
    ranks, n = numpy.sort(ranks), len(ranks)
    steps = numpy.arange(n)
    distance = max((ranks - steps / n).max(), ((steps + 1) / n - ranks).max())
    x = distance * (math.sqrt(n) + 0.12 + 0.11 / math.sqrt(n))
    k = numpy.arange(1, 101)
    return 1.0 if x < 0.3 else float(min(1, 2 * ((-1.0)**(k - 1) * numpy.exp(-2 * (k * x)**2)).sum()))


def sbc(pool, sets, seed):
    wrong = []
    print("| series | number | parameter | p | within 68 % |\n|---|---|---|---|---|")
    for five_days, kind in ((1, "means of five days"), (0, "days")):
        ranks, inside = (numpy.array(values) for values in zip(*pool.map(
            calibrate, [(five_days, seed * 10**6 + k) for k in range(sets)], chunksize=1)))
        for i, name in enumerate(NAMES):
            p, share = uniform_p(ranks[:, i]), inside[:, i].mean()
            print(f"| {kind} | {sets} | {name} | {p:.2g} | {100 * share:.1f} % |")
            if p < LEAST_P:
                wrong.append(f"{kind}: ranks of {name}: p = {p:.2g}: must be at least {LEAST_P:g}")
            if abs(share - 0.68) > 3.3 * math.sqrt(0.68 * 0.32 / sets):
                wrong.append(f"{kind}: {100 * share:.1f} % of {name} are within 68 %")
    return wrong


def odds(seed):
    """log10 of the Bayes factor of a series without a planet."""
    return search(1, without_planet(1, numpy.random.default_rng([seed, 2])), samples=100).candidates[0].log10_bayes


def null(pool, sets, seed):
    found = numpy.array(pool.map(odds, [seed * 10**6 + k for k in range(sets)], chunksize=1))
    print(f"| without planet | Bayes factor above 10 | median | largest |\n|---|---|---|---|\n| {sets} | {(found > 1).sum()} | "
          f"{10**numpy.median(found):.2g} | {10**found.max():.2g} |")
    return [f"{(found > 1).sum()} of {sets} Bayes factors above 10: must be at most 1 %"] if (found > 1).mean() > 0.01 else []


def short_errors(task):
    """log10 of the Bayes factor of a planet in the first days of a series, and the errors of period and amplitude in half widths."""
    span, period, uas, seed = task
    days, angles, rows, sigma, priors = observations(0)
    random = numpy.random.default_rng([seed, span, 5])
    kept = numpy.sort(random.choice(numpy.flatnonzero(days < days[0] + span), span // 3, replace=False))
    phase, amplitude = random.uniform(0, 2 * math.pi), uas * 1e-6 / SCALE
    y = without_planet(0, random) + amplitude * numpy.cos(2 * math.pi * days / period + phase)
    best = toliman.planets(days[kept], y[kept], sigma[kept], rows=rows[kept], priors=[math.inf, *priors], unit=SCALE,
                           position_angle_deg=angles[kept], threads=1).candidates[0]
    return [best.log10_bayes] + [abs(middle - truth) / (high - low) * 2
                                 for (low, middle, high), truth in ((best.period, period), (best.amplitude, amplitude))]


def short(pool, sets, seed, cases=SHORT):
    wrong = []
    print("| series, period | amplitude | log10 odds, median | period within 1, within 4 half widths | amplitude |\n|---|---|---|---|---|")
    for span, period, uas in cases:
        odds, *errors = numpy.transpose(pool.map(short_errors, [(span, period, uas, seed * 10**6 + k) for k in range(sets)], chunksize=1))
        decisive = odds > 2
        shares = [[numpy.mean(error[decisive] < most) if decisive.any() else 1 for most in (1, 4)] for error in errors]
        print(f"| {span} d, {period} d | {uas} uas | {numpy.median(odds):.1f} | "
              + " | ".join(f"{100 * inner:.0f} %, {100 * outer:.0f} %" for inner, outer in shares) + " |", flush=True)
        wrong += [f"{span} d, {period} d, {uas} uas: {100 * outer:.0f} % of {name}s are within 4 half widths"
                  for name, (_, outer) in zip(("period", "amplitude"), shares) if outer < LEAST_WITHIN]
    return wrong


def pair_series(seed):
    """Values of a series with the giant and the Earth, and their signals alone."""
    random = numpy.random.default_rng([seed, 3])
    y = without_planet(0, random)
    signals = sum(signal(0, planet["period"], planet["e"], random.uniform(0, 2 * math.pi),
                         coplanar(0, planet["amplitude"], longitude)) for planet, longitude in zip((GIANT, EARTH), LONGITUDES))
    return y + signals, signals


def pair_errors(found):
    """Errors of the periods, relative, and of the Earth's mass in half widths; and the number of planets found."""
    mass = model.mass_of_separation(EARTH["amplitude"] * SCALE, EARTH["period"], MASSES[0], PARALLAX)
    errors = [math.inf, math.inf, math.inf]
    for i, (planet, truth) in enumerate(zip(found.planets, (GIANT, EARTH))):
        errors[i] = abs(planet.period[1] / truth["period"] - 1)
        if truth is EARTH:
            low, middle, high = planet.mass_a
            errors[2] = abs(middle - mass) / (high - low) * 2
    return errors + [len(found.planets)]


def find_pair(task):
    seed, most = task
    return pair_errors(search(0, pair_series(seed)[0], max_planets=most, samples=DRAWS))


def pair(pool, sets, seed):
    wrong = []
    print("| largest number of planets | series | both periods within 1.5 % | mass within two half widths | more planets |\n"
          "|---|---|---|---|---|")
    for most in (2, 3):
        found = numpy.array(pool.map(find_pair, [(seed * 10**6 + k, most) for k in range(sets)], chunksize=1))
        periods, masses = (found[:, :2].max(1) < 0.015).sum(), (found[:, 2] <= 2).sum()
        print(f"| {most} | {sets} | {periods} | {masses} | {(found[:, 3] > 2).sum()} |")
        if periods < sets:
            wrong.append(f"up to {most} planets: both periods in {periods} of {sets}: must be all")
        if masses < 0.85 * sets:
            wrong.append(f"up to {most} planets: mass in {masses} of {sets}: must be at least 85 %")
    return wrong


@functools.cache
def limits_of(period):
    """Limits at a period, px, of a series without a planet, and the result with it."""
    found = search(1, without_planet(1, numpy.random.default_rng(1)), samples=100)
    return found.limits([period])[0], found


def with_planet(period, amplitude, seed, samples=0):
    """The search of a series with a circular orbit in the plane of the binary, of random phase."""
    random = numpy.random.default_rng([seed, 4])
    anomaly = random.uniform(0, 2 * math.pi)
    return search(1, without_planet(1, random) + signal(1, period, 0, anomaly, coplanar(1, amplitude, 0)), samples=samples)


def exclude(task):
    """Whether the upper limit excludes a planet that is there."""
    period, factor, seed = task
    amplitude = factor * limits_of(period)[0]["upper"]
    return with_planet(period, amplitude, seed, samples=100).limits([period])["upper"][0] < amplitude


def detect(task):
    """Whether a search calls a planet of the detectable amplitude a planet."""
    period, seed = task
    return len(with_planet(period, limits_of(period)[0]["detectable"], seed).planets) > 0


def limits(pool, count, seed, periods=LIMIT_PERIODS):
    """Shares of planets that are excluded although they are there (5 %), and that are found at the detectable amplitude
    (95 %), by searches and by injection."""
    wrong = []
    print("| period | upper | excluded 1.01 times that | 1.5 times | detectable | planets by search | by injection |\n"
          "|---|---|---|---|---|---|---|")
    for period in periods:
        limit, empty = limits_of(period)
        seeds = range(seed * 10**6, seed * 10**6 + count)
        small, large = (sum(pool.map(exclude, [(period, factor, k) for k in seeds], chunksize=1)) / count for factor in (1.01, 1.5))
        by_search = sum(pool.map(detect, [(period, k) for k in seeds], chunksize=1)) / count
        size = limit["detectable"]
        by_injection = empty.inject((period, period), (size, size), INJECTIONS, circular=True, seed=int(period)) / INJECTIONS
        print(f"| {period} d | {limit['upper'] * SCALE * 1e6:.3f} uas | {100 * small:.1f} % | {100 * large:.1f} % | "
              f"{size * SCALE * 1e6:.3f} uas | {100 * by_search:.1f} % | {100 * by_injection:.1f} % |", flush=True)
        error = math.sqrt(0.05 * 0.95 / count)
        # A planet that is found is not excluded, and counts among the 5 %.
        wrong += [f"{period} d: {100 * share:.1f} % of planets are excluded" for share in (small, large) if share > 0.05 + 3.3 * error]
        wrong += [f"{period} d: {100 * small:.1f} % of planets are excluded: must be 5 %"] * bool(small < 0.05 - 3.3 * error)
        for share, name, most in ((by_search, "by search", 0.03 + 2.5 * error), (by_injection, "by injection", 0.03)):
            if abs(share - 0.95) > most:
                wrong.append(f"{period} d: {100 * share:.1f} % of planets are found {name}: must be 95 %")
    return wrong


MODES = {"sbc": lambda pool, given: sbc(pool, given.sets, given.seed),
         "null": lambda pool, given: null(pool, given.sets, given.seed),
         "short": lambda pool, given: short(pool, max(given.sets // 5, 1), given.seed),
         "pair": lambda pool, given: pair(pool, max(given.sets // 25, 1), given.seed),
         "limits": lambda pool, given: limits(pool, given.sets, given.seed)}


if __name__ == "__main__":
    sys.exit(campaign.run(__doc__, MODES, 500, "number of series of sbc, null and limits; one in 5 for short, one in 25 for pair"))
