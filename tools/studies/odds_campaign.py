"""Odds and errors of planets over the range of noise, instruments and velocities that people have. The short form:
test_odds_campaign.py.

    odds_campaign.py [noise] [pulls] [star] [--sets 200] [--seed 1] [--jobs 0]

noise  Series of velocities without a planet, of one to four instruments with other zero points, with jitters of 0.1 to
       1,000 sigmas: log10 of the odds is above -1.5, and at most 1 % are planets.
pulls  Velocities with a planet: amplitude of 3 to 10,000 sigmas, jitter of 0.1 to 1,000 sigmas but at most a third of the
       amplitude, eccentricity up to 0.97. Of those that are claimed: the rms of the normal deviates of the truth's rank in
       the posterior is 0.9 to 1.1 for period, eccentricity and amplitude, and none is more than 5. Samples are weighted for
       the truths' distribution of eccentricities.
star   Separations of 0.3 uas and velocities of 1 m/s of both stars, of a planet of A or B in any direction: the share in
       which the star is named with odds of at least 19 to 1 is that of the theory within its error, and the wrong star is
       named in at most 5 %. Theory: the two amplitudes of the velocities have Gaussian errors; their scale is that of the
       separations.

Without a mode all run. The exit status is 1 if a figure is missed."""
import math
import pathlib
import sys

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "build" / "python"), str(ROOT / "tests" / "support")]
import campaign  # noqa: E402
import planet_model as model  # noqa: E402
import toliman  # noqa: E402

PARALLAX, MASSES = 0.75, (1.0788, 0.9092)
MOTION = model.AU / model.DAY / PARALLAX  # m/s of 1 arcsec times one radian per day
NAMED = math.log10(19)


def log_uniform(random, low, high):
    return math.exp(random.uniform(math.log(low), math.log(high)))


def search_velocities(t, y, names, shortest=10, **options):
    series = toliman.Measurements.of(t, y, 1.0, kind="velocity", unit=1)
    if names is not None:
        series.set_instruments(names)
    return toliman.planets(series, period_min=shortest, period_max=0.5 * float(numpy.ptp(t)), threads=1, **options)


def noise_of(task, shortest=10):
    seed, = task
    random = numpy.random.default_rng([seed, 1])
    count, instruments = int(random.integers(40, 150)), int(random.integers(1, 5))
    t, which = numpy.sort(random.uniform(0, random.uniform(300, 2000), count)), random.integers(0, instruments, count)
    jitters, offsets = 10**random.uniform(-1, 3, instruments), 1000 * random.normal(size=instruments)
    y = offsets[which] + random.normal(size=count) * numpy.hypot(1, jitters[which])
    found = search_velocities(t, y, None if instruments == 1 else [f"i{k}" for k in which], shortest, samples=200)
    return found.candidates[0].log10_bayes, len(found.planets)


def noise(pool, sets, seed):
    found = numpy.array(pool.map(noise_of, [(seed * 10**6 + k,) for k in range(sets)], chunksize=1))
    odds, planets = found[:, 0], int(found[:, 1].sum())
    print("| series | lowest log10 odds | median | highest | planets |\n|---|---|---|---|---|")
    print(f"| {sets} | {odds.min():.2f} | {numpy.median(odds):.2f} | {odds.max():.2f} | {planets} |")
    wrong = [f"log10 odds of noise {odds.min():.2f}: must be above -1.5"] * bool(odds.min() < -1.5)
    return wrong + [f"{planets} planets in {sets} series of noise: must be at most 1 %"] * (planets > max(1, 0.01 * sets))


def pull_of(task):
    """Ranks of the truth in the posterior; NaN if no planet is claimed."""
    seed, = task
    random = numpy.random.default_rng([seed, 2])
    count, span = int(random.integers(60, 150)), random.uniform(400, 2000)
    t = numpy.sort(random.uniform(0, span, count))
    size = log_uniform(random, 3, 1e4)
    jitter = min(log_uniform(random, 0.1, 1e3), size / 3)
    period, e = log_uniform(random, 20, span / 3), random.uniform(0, 0.97)
    signal = model.velocity(t, period, e, random.uniform(0, 360), random.uniform(0, period), size)
    found = search_velocities(t, 7 + signal + random.normal(size=count) * math.hypot(1, jitter), None, samples=1000)
    if not found.planets:
        return [math.nan] * 3
    samples = found.samples(0)
    weights = uniform_over_prior(samples["eccentricity"])
    return [(weights[samples[name] < truth].sum() + 0.5 * weights.mean()) / (weights.sum() + weights.mean())
            for name, truth in (("period", period), ("eccentricity", e), ("amplitude", size))]


def uniform_over_prior(e):
    """Weights of samples as if the prior of eccentricities were that of the truths, uniform up to 0.97, and not Beta(0.867, 3.03)."""
    return numpy.where(e < 0.97, e**0.133 * (1 - e)**-2.03, 0)


def deviate(share):
    """The standard normal deviate below which a share is, by bisection of erf."""
    low, high = -8.0, 8.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if math.erf(middle / math.sqrt(2)) < 2 * share - 1 else (low, middle)
    return (low + high) / 2


def pulls(pool, sets, seed):
    ranks = numpy.array(pool.map(pull_of, [(seed * 10**6 + k,) for k in range(sets)], chunksize=1))
    claimed = ranks[numpy.isfinite(ranks[:, 0])]
    if len(claimed) == 0:
        return ["no planet is claimed"]
    values = numpy.vectorize(deviate)(claimed)
    rms = numpy.sqrt((values**2).mean(0))
    print("| planets | claimed | rms deviate of period, eccentricity, amplitude | largest |\n|---|---|---|---|")
    print(f"| {sets} | {len(claimed)} | {rms[0]:.3f}, {rms[1]:.3f}, {rms[2]:.3f} | {abs(values).max():.2f} |")
    error = 1 / math.sqrt(2 * len(claimed))
    wrong = [f"largest deviate {abs(values).max():.2f}: must be at most 5"] * bool(abs(values).max() > 5)
    return wrong + [f"rms deviate of the {name}: {value:.3f}: must be 0.9 to 1.1" for name, value in
                    zip(("period", "eccentricity", "amplitude"), rms) if abs(value - 1) > 0.1 + 2 * error]


class Mission:
    """Separations and velocities of a planet in any direction."""

    def __init__(self, seed, count=(300, 300), sigma=0.3e-6):
        random = numpy.random.default_rng([seed, 3])
        self.star, self.sigma = int(random.integers(0, 2)), sigma
        self.period, self.e = log_uniform(random, 100, 400), model.draw_eccentricity(random, 0.8)
        axis = log_uniform(random, 2e-6, 20e-6)
        first = random.normal(size=3)
        self.p = first / numpy.linalg.norm(first)
        self.q = numpy.cross(self.p, random.normal(size=3))
        self.q /= numpy.linalg.norm(self.q)
        self.along, self.away = (axis * numpy.array([self.p[k], self.q[k]]) for k in (0, 2))
        self.epoch = random.uniform(0, self.period)
        self.t = numpy.sort(random.uniform(0, 1000, count[0]))
        self.velocity_t = [numpy.sort(random.uniform(0, 1000, count[1])) for _ in range(2)]
        side = 1 if self.star == 0 else -1  # the separation follows the planet of A, and star B
        x, y = model.places(self.mean(self.t), self.e)
        self.y = side * (self.along[0] * x + self.along[1] * y) + sigma * random.normal(size=count[0])
        self.v = []
        for star, t in enumerate(self.velocity_t):
            signal = -self.away @ self.motion(t) if star == self.star else 0
            self.v.append(signal + 5 * random.normal() + 1e-3 * t + random.normal(size=count[1]))

    def mean(self, t):
        return 2 * math.pi * (t - self.epoch) / self.period

    def motion(self, t):
        """Velocities, m/s, of the two coordinates of an orbit of one arcsec."""
        nu, _ = model.true_anomaly(self.mean(t), self.e)
        size = 2 * math.pi / self.period / math.sqrt(1 - self.e**2) * MOTION
        return numpy.stack([-size * numpy.sin(nu), size * (numpy.cos(nu) + self.e)])

    def search(self):
        given = [toliman.Measurements.of(t, v, 1.0, kind="velocity", unit=1).set_trend(3)
                 for t, v in zip(self.velocity_t, self.v)]
        series = toliman.Measurements.of(self.t, self.y, self.sigma, kind="reduced", unit=1)
        return toliman.planets(series, velocities=given[0], velocities_b=given[1], parallax_arcsec=PARALLAX, threads=1,
                               star_masses=MASSES, samples=200, jitter=False)

    def theory(self, random, draws=400):
        """Share of noises in which the star is named with odds of at least 19 to 1."""
        scale = numpy.linalg.norm(self.along) / math.sqrt(2)
        odds = numpy.zeros(draws)
        for star, t in enumerate(self.velocity_t):
            basis = numpy.linalg.qr(numpy.stack([((t - 500) / 500)**k for k in range(4)], 1))[0]
            shapes = self.motion(t)
            shapes = shapes - (shapes @ basis) @ basis.T
            fisher = shapes @ shapes.T
            right = random.multivariate_normal(fisher @ self.away * (star == self.star), fisher, draws)
            inner = numpy.linalg.inv(fisher + numpy.eye(2) / scale**2)
            log = numpy.einsum("ni,ij,nj->n", right, inner, right) / 2 - math.log(
                numpy.linalg.det(numpy.eye(2) + scale**2 * fisher)) / 2
            odds += log if star == self.star else -log
        return (odds / math.log(10) > NAMED).mean()


def star_of(task):
    """Whether the right star and the wrong star is named, and the share of the theory; none without a planet."""
    seed, = task
    mission = Mission(seed)
    candidate = mission.search().candidates[0]
    if "the odds are below the threshold" in candidate.reasons:
        return [math.nan] * 3
    odds = candidate.log10_star * (1 if mission.star == 0 else -1)
    return [odds > NAMED, odds < -NAMED, mission.theory(numpy.random.default_rng([seed, 4]))]


def star(pool, sets, seed):
    found = numpy.array(pool.map(star_of, [(seed * 10**6 + k,) for k in range(sets)], chunksize=1), float)
    found = found[numpy.isfinite(found[:, 0])]
    right, wrong_star, theory = found.mean(0)
    print("| missions | found | star named | theory | wrong star |\n|---|---|---|---|---|")
    print(f"| {sets} | {len(found)} | {100 * right:.1f} % | {100 * theory:.1f} % | {100 * wrong_star:.1f} % |")
    error = math.sqrt(max(theory * (1 - theory), 0.01) / len(found))
    wrong = [f"the star is named in {100 * right:.1f} %: must be {100 * theory:.1f} %"] * bool(abs(right - theory) > 0.03 + 2 * error)
    return wrong + [f"the wrong star is named in {100 * wrong_star:.1f} %"] * bool(wrong_star > 0.05 + 2 * error)


MODES = {"noise": lambda pool, given: noise(pool, given.sets, given.seed),
         "pulls": lambda pool, given: pulls(pool, given.sets, given.seed),
         "star": lambda pool, given: star(pool, max(given.sets // 2, 1), given.seed)}


if __name__ == "__main__":
    sys.exit(campaign.run(__doc__, MODES, 200, "number of series of noise and pulls; half of them for star"))
