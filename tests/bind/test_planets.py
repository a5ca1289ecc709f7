"""Tests planets() of Python: orbits, masses and odds of synthetic series against numpy."""
import math
import unittest

import numpy

from package import LONG, toliman
from refusal import refused
import planet_model as model

N, SIGMA, STARS, PARALLAX = 150, 0.3e-6, (1.0788, 0.9092), 0.750
KNOWN = {"unit": 1, "parallax_arcsec": PARALLAX, "star_masses": STARS}
PARAMETERS = "period", "eccentricity", "periastron_deg", "epoch", "amplitude"


def days(seed, n=N, span=1095):
    return numpy.sort(numpy.random.default_rng(seed).uniform(0, span, n))


def noise(seed, n=N):
    return numpy.random.default_rng([seed, 1]).normal(size=n)


def within(planet, truth, factor=3):
    """Whether every parameter is within `factor` half widths of the central 68 %; angles and epochs are compared modulo
    a revolution."""
    for name, true in truth.items():
        low, middle, high = getattr(planet, name)
        turn = {"periastron_deg": 360, "epoch": truth["period"]}.get(name)
        error = middle - true if turn is None else (middle - true + turn / 2) % turn - turn / 2
        if abs(error) > factor * (high - low) / 2:
            return f"{name}: {low:g}, {middle:g}, {high:g}: is {true:g}"
    return ""


class Circular(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.t = days(1)
        cls.rows = numpy.stack([numpy.cos(cls.t / 500), (cls.t / 1000)**2], 1)
        signal = model.separation(cls.t, 310, 0, 0, 77, 1.1e-6)
        cls.y = signal + SIGMA * noise(1) + cls.rows @ [2e-6, -1e-6] + 3e-6
        cls.given = {"rows": cls.rows, "priors": [math.inf, math.inf, 4e-6, math.inf], "trend": 1, **KNOWN}
        cls.found = toliman.planets(cls.t, cls.y, SIGMA, threads=1, **cls.given)

    def test_orbit(self):
        info, (planet,) = self.found.info, self.found.planets
        self.assertEqual((info.planets, info.candidates, info.functions, len(self.found)), (1, 1, 4, 1))
        self.assertEqual(within(planet, {"period": 310, "amplitude": 1.1e-6}), "")
        self.assertLess(planet.eccentricity[0], 0.2)
        self.assertGreater(planet.log10_bayes, 10)
        self.assertLess(planet.log10_fap, -10)
        self.assertFalse(planet.at_edge)
        self.assertTrue(0.5 < planet.power_left <= 1)
        self.assertEqual((info.period_min, info.period_max), (60, 1000))
        self.assertAlmostEqual(info.amplitude_min, 0.05e-6, delta=1e-12)
        self.assertAlmostEqual(info.time_reference, self.t.mean(), delta=1e-9)
        self.assertTrue(math.isnan(info.axis_deg))
        self.assertEqual((info.axis_turn_deg, info.jitter), (0, (0, 0, 0)))
        self.assertLess(abs(planet.epoch[1] - info.time_reference), planet.period[1])

    def test_signal_is_that_of_the_best_orbit(self):
        best = self.found.planets[0].best
        t = numpy.linspace(-100, 1500, 300)
        numpy.testing.assert_allclose(self.found.signal(0, t), model.separation(t, *best), atol=1e-9 * best[4])

    def test_residuals_are_what_the_fit_leaves(self):
        residuals = self.found.residuals()
        x = 2 * (self.t - self.t[0]) / (self.t[-1] - self.t[0]) - 1
        functions = numpy.column_stack([numpy.ones(N), x, self.rows])
        rest = self.y - self.found.signal(0, self.t) - residuals
        left = rest - functions @ numpy.linalg.lstsq(functions, rest, rcond=None)[0]
        self.assertLess(abs(left).max(), 1e-4 * SIGMA)  # of the last step of the fit
        for free in (0, 1, 3):  # residuals are orthogonal to the functions without prior
            column = functions[:, free]
            self.assertLess(abs(residuals @ column), 1e-6 * numpy.linalg.norm(residuals) * numpy.linalg.norm(column))
        self.assertAlmostEqual(self.found.info.rms / math.sqrt((residuals**2).mean()), 1, delta=1e-9)
        self.assertAlmostEqual(residuals.std() / SIGMA, 1, delta=0.2)
        self.assertAlmostEqual(self.found.info.chi_square, 1, delta=0.4)

    def test_samples_are_of_the_posterior(self):
        planet, samples = self.found.planets[0], self.found.samples(0)
        self.assertEqual((samples.shape, samples.dtype.names[:5]), ((4096,), PARAMETERS))
        for name in ("period", "eccentricity", "amplitude", "mass_a", "mass_b"):
            low, middle, high = getattr(planet, name)
            for share, point in ((0.16, low), (0.5, middle), (0.84, high)):
                self.assertAlmostEqual((samples[name] < point).mean(), share, delta=0.035, msg=name)
        self.assertTrue((samples["jitter"] == 0).all())
        self.assertEqual(self.found.samples(0, 10).tobytes(), samples[:10].tobytes())
        correlation = numpy.corrcoef(samples["period"], samples["amplitude"])[0, 1]
        self.assertAlmostEqual(planet.correlation[4], correlation, delta=0.08)
        self.assertEqual(planet.correlation[::6], (1,) * 5)

    def test_masses_are_those_of_two_bodies(self):
        for sample in self.found.samples(0, 20):
            for name, star in zip(("mass_a", "mass_b"), STARS):
                mass = model.mass_of_separation(sample["amplitude"], sample["period"], star, PARALLAX)
                self.assertAlmostEqual(sample[name] / mass, 1, delta=2e-5)

    def test_units_change_nothing_but_themselves(self):
        given = {**self.given, "unit": 1e-6, "priors": [math.inf, math.inf, 4, math.inf], "time_unit_days": 365.25}
        planet = toliman.planets(self.t / 365.25, self.y * 1e6, SIGMA * 1e6, period_min=60 / 365.25,
                                 period_max=1000 / 365.25, **given).planets[0]
        same = self.found.planets[0]
        numpy.testing.assert_allclose(planet.mass_a, same.mass_a, rtol=1e-6)
        numpy.testing.assert_allclose(numpy.multiply(planet.period, 365.25), same.period, rtol=1e-6)
        numpy.testing.assert_allclose(planet.log10_bayes, same.log10_bayes, rtol=1e-6)

    def test_masses_without_what_they_need(self):
        planet = toliman.planets(self.t, self.y, SIGMA, samples=100, unit=1, parallax_arcsec=PARALLAX, star_masses=(1, 0),
                                 period_min=250).candidates[0]
        self.assertTrue(planet.mass_a[1] > 0 and math.isnan(planet.mass_b[1]))

    # promise: threads-change-no-bit
    def test_threads_give_the_same_bits(self):
        other = toliman.planets(self.t, self.y, SIGMA, threads=3, **self.given)
        self.assertEqual(repr(other.candidates), repr(self.found.candidates))
        self.assertEqual(repr(other.info), repr(self.found.info))
        for one, two in ((other.samples(0), self.found.samples(0)), (other.residuals(), self.found.residuals()),
                         (other.limits([100, 500]), self.found.limits([100, 500]))):
            self.assertEqual(one.tobytes(), two.tobytes())

    def test_seed_changes_the_samples_alone(self):
        other = toliman.planets(self.t, self.y, SIGMA, seed=5, **self.given)
        self.assertFalse((other.samples(0) == self.found.samples(0)).any())
        one, two = other.planets[0], self.found.planets[0]
        self.assertEqual((one.log10_bayes, one.best, one.best_error), (two.log10_bayes, two.best, two.best_error))
        for name in ("period", "amplitude", "mass_a"):
            low, _, high = getattr(two, name)
            numpy.testing.assert_allclose(getattr(one, name), getattr(two, name), atol=0.05 * (high - low))

    def test_limits(self):
        periods = numpy.array([[80, 150, 250], [400, 600, 900]])
        limits = self.found.limits(periods)
        numpy.testing.assert_array_equal(limits["period"], periods)
        for i in numpy.ndindex(periods.shape):
            for kind in ("upper", "detectable"):
                for star, name in enumerate("ab"):
                    mass = model.mass_of_separation(limits[kind][i], periods[i], STARS[star], PARALLAX)
                    self.assertAlmostEqual(limits[f"{kind}_mass_{name}"][i] / mass, 1, delta=2e-5)
        lower = self.found.limits(periods, 0.85)
        self.assertTrue((lower["upper"] < limits["upper"]).all())
        self.assertTrue((lower["detectable"] < limits["detectable"]).all())
        self.assertEqual(self.found.limits([]).shape, (0,))

    # promise: detectable-planets-are-found
    def test_injections(self):
        amplitude = float(self.found.limits([80], 0.6)["detectable"][0])
        detected = self.found.inject((80, 80), (amplitude, amplitude), 600, circular=True, seed=3)
        self.assertAlmostEqual(detected / 600, 0.6, delta=0.08)
        self.assertEqual(self.found.inject((100, 200), (5e-6, 6e-6), 50, circular=True), 50)
        self.assertLess(self.found.inject((100, 200), (1e-9, 1e-8), 50), 3)
        mass = model.mass_of_separation(amplitude, 80, STARS[1], PARALLAX)
        by_mass = self.found.inject((80, 80), (mass, mass), 600, star="b", circular=True, seed=3)
        self.assertAlmostEqual(by_mass, detected, delta=1)
        with refused(ValueError, "star"):
            self.found.inject((100, 200), (1, 2), star="c")

    def test_refusals_of_a_result(self):
        for call in (lambda: self.found.signal(1, [0.0]), lambda: self.found.samples(1), lambda: self.found.samples(0, 4097),
                     lambda: self.found.signal(0, [math.nan]), lambda: self.found.limits([10]),
                     lambda: self.found.limits([100], 1),
                     lambda: self.found.inject((200, 100), (1, 2)), lambda: self.found.inject((100, 200), (0, 2))):
            self.assertRaises(toliman.InputError, call)
        with refused(ValueError, "position_angle_deg"):
            self.found.signal(0, [0.0], [1, 2])

    # promise: upper-limits-hold
    def test_upper_limit(self):
        """Without a planet: of planets of the limit with random phases, noise gives a smaller gain to 10 %; if the noise has
        hardly any power of this period, that of its 16 % point counts."""
        wave = numpy.exp(2j * math.pi * self.t / 170)
        shapes = numpy.linalg.qr(numpy.column_stack([numpy.ones(N), wave.real, wave.imag]))[0][:, 1:]
        left = shapes.T @ (numpy.stack([wave.real, wave.imag]) / SIGMA).T
        random, draws = numpy.random.default_rng(3), 400000
        phases = random.uniform(0, 2 * math.pi, draws)
        signals, errors = left @ [numpy.cos(phases), numpy.sin(phases)], random.normal(size=(2, draws))
        for part in (1, 0.01):
            y = SIGMA * noise(9)
            y -= (1 - part) * shapes @ (shapes.T @ y)
            found = toliman.planets(self.t, y, SIGMA, samples=100, **KNOWN)
            self.assertEqual((found.planets, len(found.candidates)), ([], 1))
            gain = max(((shapes.T @ y / SIGMA)**2).sum(), -2 * math.log(0.84))
            upper = found.limits([170], 0.9)["upper"][0]
            share = (((upper * signals + errors)**2).sum(0) < gain).mean()
            self.assertAlmostEqual(share, 0.1, delta=0.002)


class Eccentric(unittest.TestCase):
    truth = {"period": 420, "eccentricity": 0.6, "periastron_deg": 130, "epoch": 300, "amplitude": 2e-6}

    def test_separation(self):
        t = days(2)
        y = model.separation(t, *self.truth.values()) + SIGMA * noise(2)
        found = toliman.planets(t, y, SIGMA, **KNOWN)
        self.assertEqual(within(found.planets[0], self.truth), "")
        best, error = found.planets[0].best, found.planets[0].best_error
        for name, value, deviation in zip(PARAMETERS, best, error):
            if name != "epoch":
                self.assertLess(abs(value - self.truth[name]), 4 * deviation, name)
        numpy.testing.assert_allclose(found.signal(0, t), model.separation(t, *best), atol=1e-9 * best[4])
        steps, columns = 1e-5 * numpy.array([best[0], 1, 57, best[0], best[4]]), [numpy.ones(N)]
        for step in numpy.diag(steps):  # the errors are those of a fit that is linear about the best orbit
            columns.append((model.separation(t, *(best + step)) - model.separation(t, *(best - step))) / (2 * step.max()))
        design = numpy.stack(columns, 1) / SIGMA * numpy.r_[1, steps]
        expected = numpy.sqrt(numpy.diag(numpy.linalg.inv(design.T @ design)))[1:] * steps
        numpy.testing.assert_allclose(error, expected, rtol=0.02)  # 1 % by the prior of the amplitudes

    def test_velocity(self):
        truth, t = {**self.truth, "amplitude": 25}, days(3)
        y = model.velocity(t, *truth.values()) + 2 * noise(3) + 400
        found = toliman.planets(t, y, 2, velocity=True, unit=1, star_masses=(STARS[0], 0))
        planet = found.planets[0]
        self.assertEqual(within(planet, truth), "")
        numpy.testing.assert_allclose(found.signal(0, t), model.velocity(t, *planet.best), atol=1e-9 * planet.best[4])
        for sample in found.samples(0, 20):
            mass = model.mass_of_velocity(sample["amplitude"], sample["period"], sample["eccentricity"], STARS[0])
            self.assertAlmostEqual(sample["mass_a"] / mass, 1, delta=2e-5)

    def test_noise_of_unknown_size(self):
        """The posterior of a strong signal is as wide as the linearised fit, and the noise is found."""
        t = days(3, 60)
        y = model.separation(t, *self.truth.values()) + SIGMA * noise(3, 60)
        found = toliman.planets(t, y, jitter=True, period_min=300, period_max=600, **KNOWN)
        planet, jitter = found.planets[0], found.samples(0)["jitter"]
        self.assertEqual(within(planet, self.truth), "")
        self.assertAlmostEqual((planet.period[2] - planet.period[0]) / 2 / planet.best_error[0], 1, delta=0.3)
        self.assertAlmostEqual(jitter.mean() / SIGMA, 1, delta=0.3)
        self.assertAlmostEqual(jitter.std() / SIGMA, 1 / math.sqrt(2 * 55), delta=0.03)
        numpy.testing.assert_allclose(found.info.jitter, numpy.percentile(jitter, [16, 50, 84]), rtol=1e-3)


class Evidence(unittest.TestCase):
    """The noise is 80; the sigmas are 0.01 to 1 times 20, so that the jitter is free."""

    def search(self, seed, sigma, amplitude=0.0):
        random = numpy.random.default_rng(seed)
        t = numpy.sort(random.uniform(0, 3000, 80))
        y = 80 * random.normal(size=80) + amplitude * numpy.sin(2 * math.pi * t / 400)
        return toliman.planets(t, y, sigma, velocity=True, samples=500, period_min=300, period_max=1000)

    def test_odds_do_not_depend_on_the_scale_of_the_sigmas(self):
        for seed, amplitude in ((4, 80), (102, 0))[:1 + LONG]:
            found = [self.search(seed, sigma, amplitude) for sigma in (0.2, 20)]
            first = [one.candidates[0] for one in found]
            for other in first[1:]:
                self.assertLess(abs(other.log10_bayes - first[0].log10_bayes), 0.2)
                if amplitude > 0:
                    width = (first[0].period[2] - first[0].period[0]) / 2
                    self.assertLess(abs(other.period[1] - first[0].period[1]), 0.1 * width)
            self.assertEqual([one.info.planets for one in found], [int(amplitude > 0)] * 2)
            for one in found:
                self.assertAlmostEqual(one.info.jitter[1] / 80, 1, delta=0.25)

    def test_odds_of_noise_are_above_a_floor(self):
        for seed, sigma in ((100, 80), (102, 2)):
            found = self.search(seed, sigma)
            self.assertEqual(found.info.planets, 0)
            self.assertGreater(found.candidates[0].log10_bayes, -1.5)
            self.assertLess(0, found.candidates[0].log10_bayes_error)
            self.assertLess(found.candidates[0].log10_bayes_error, 0.1)

    def test_short_passages_through_periastron(self):
        """An orbit of e = 0.97 fits a few of its passages at a fifth of its period."""
        random = numpy.random.default_rng(13)
        t = numpy.sort(random.uniform(0, 3000, 120))
        truth = {"period": 591.9, "eccentricity": 0.97, "periastron_deg": 40, "epoch": 200, "amplitude": 180}
        y = model.velocity(t, *truth.values()) + 1.5 * random.normal(size=120)
        found = toliman.planets(t, y, 1.5, velocity=True)
        one = found.candidates[0]
        self.assertEqual((found.info.planets, found.info.goodness), (1, "good"))
        for index, name in enumerate(("period", "eccentricity")):
            low, middle, high = getattr(one, name)
            self.assertLess(abs(middle - truth[name]), 4 * (high - low) / 2, name)

    def test_passages_that_the_orbit_misses_are_no_jitter(self):
        """The same with other times: an orbit of 551 d misses passages, which a jitter of 18 would excuse. The eccentricity is
        uncertain up to the edge of the prior."""
        random = numpy.random.default_rng(12)
        t = numpy.sort(random.uniform(0, 3000, 120))
        y = model.velocity(t, 591.9, 0.97, 40, 200, 180) + 1.5 * random.normal(size=120)
        found = toliman.planets(t, y, 1.5, velocity=True, period_min=400, period_max=800, samples=500)
        low, middle, high = found.candidates[0].period
        self.assertLess(abs(middle - 591.9), 4 * (high - low) / 2)
        self.assertEqual(found.info.jitter[2], 0)
        self.assertEqual(found.candidates[0].reasons, ("period or eccentricity is at the edge of the prior",))


class TwoPlanets(unittest.TestCase):
    def test_both(self):
        t = days(4, 100)
        large = {"period": 600, "eccentricity": 0.3, "periastron_deg": 20, "epoch": 100, "amplitude": 40e-6}
        small = {"period": 150, "eccentricity": 0, "periastron_deg": 0, "epoch": 10, "amplitude": 1.5e-6}
        y = model.separation(t, *large.values()) + model.separation(t, *small.values()) + SIGMA * noise(4, 100)
        found = toliman.planets(t, y, SIGMA, max_planets=3, period_min=100, **KNOWN)
        self.assertEqual((found.info.planets, found.info.candidates), (2, 3))
        first, second, third = found.candidates
        self.assertEqual(within(first, large), "")
        self.assertEqual(within(second, {"period": 150, "amplitude": 1.5e-6}), "")
        self.assertLess(third.log10_bayes, 2)
        rest = y - found.residuals() - found.signal(0, t) - found.signal(1, t)
        self.assertLess(numpy.ptp(rest), 1e-4 * SIGMA)


class Removal(unittest.TestCase):
    def test_planet_that_falls_below_the_threshold(self):
        """Of two waves that are above the threshold one after the other, one falls below it in the joint fit: it is the
        last candidate, and the other one has the posterior of a search for one planet."""
        t = numpy.sort(numpy.random.default_rng(0).choice(1000, 80, replace=False)).astype(float)
        random, stages = numpy.random.default_rng(44), set()
        y = random.normal(size=80) + numpy.sin(t / 19 + random.uniform(0, 6)) + 0.9 * numpy.sin(t / 20.5 + random.uniform(0, 6))
        given = {"threshold": 1, "samples": 100, "detection_fap": 0.5, "jitter": False}
        found = toliman.planets(t, y, 1.0, max_planets=2, progress=lambda stage, _: stages.add(stage), **given)
        self.assertIn("planet 2, with the others", stages)
        self.assertEqual((found.info.planets, found.info.candidates), (1, 2))
        self.assertLess(found.candidates[1].log10_bayes, 1)
        alone = toliman.planets(t, y, 1.0, **given)
        self.assertEqual(found.candidates[0].log10_bayes, alone.candidates[0].log10_bayes)
        for name in "period", "eccentricity", "amplitude":
            self.assertEqual(found.samples(0)[name].tobytes(), alone.samples(0)[name].tobytes())


class Axis(unittest.TestCase):
    """A face-on orbit of 479 d, and an axis that turns 6 degrees in three years."""

    @classmethod
    def setUpClass(cls):
        cls.t = days(6)
        cls.angles = 20 + 6 * cls.t / 1095
        cls.y = cls.signal(cls.angles) + SIGMA * noise(6)

    @classmethod
    def signal(cls, angles):
        return 10e-6 * numpy.cos(2 * math.pi * cls.t / 479 + 1 - numpy.radians(angles))

    def test_axis_of_date(self):
        found = toliman.planets(self.t, self.y, SIGMA, position_angle_deg=self.angles, **KNOWN)
        planet = found.planets[0]
        self.assertEqual(within(planet, {"period": 479, "amplitude": 10e-6}), "")
        self.assertAlmostEqual(found.info.axis_deg, self.angles.mean(), delta=0.05)
        self.assertAlmostEqual(found.info.axis_turn_deg, numpy.ptp(self.angles), delta=1e-9)
        numpy.testing.assert_allclose(found.signal(0, self.t), model.separation(self.t, *planet.best), atol=1e-14)
        rest = self.y - found.signal(0, self.t, self.angles) - found.residuals()
        self.assertLess(numpy.ptp(rest), 1e-4 * SIGMA)

    def test_axis_that_turns_far(self):
        """The amplitudes across the mean axis, and with them the period, are then known."""
        angles = 170 + 200 * (self.t / 1095)**2
        found = toliman.planets(self.t, self.signal(angles) + SIGMA * noise(6), SIGMA, position_angle_deg=angles, **KNOWN)
        self.assertEqual(within(found.planets[0], {"period": 479, "amplitude": 10e-6}), "")
        self.assertLess(found.planets[0].best_error[0], 1)
        self.assertLess(abs(found.signal(0, self.t, angles) - self.signal(angles)).max(), 4 * SIGMA * math.sqrt(7 / N))

    def test_whole_turns_change_nothing(self):
        one = toliman.planets(self.t, self.y, SIGMA, position_angle_deg=self.angles, samples=100, period_min=300)
        turns = 360 * (numpy.arange(len(self.t)) % 2)
        two = toliman.planets(self.t, self.y, SIGMA, position_angle_deg=self.angles + turns, samples=100, period_min=300)
        numpy.testing.assert_allclose(one.planets[0].period, two.planets[0].period, rtol=1e-9)

    def test_fixed_axis_has_another_period(self):
        planet = toliman.planets(self.t, self.y, SIGMA, **KNOWN).planets[0]
        turn = 6 * 479 / 1095
        self.assertAlmostEqual(planet.best[0], 479 / (1 - turn / 360), delta=4 * planet.best_error[0])
        self.assertGreater(abs(planet.best[0] - 479), 5 * planet.best_error[0])


class Odds(unittest.TestCase):
    """Bayes factors against a midpoint rule of all parameters."""

    t, given = days(7, 28, 300), {"period_min": 40, "period_max": 200, "amplitude_min": 0.1, "amplitude_max": 3, "samples": 100}

    def assert_agrees(self, y, sigma, expected, **given):
        found = toliman.planets(self.t, y, sigma, **{**self.given, **given}).candidates[0]
        self.assertAlmostEqual(found.log10_bayes, expected, delta=0.05)

    def series(self, amplitude, seed):
        return model.separation(self.t, 83, 0.4, 70, 20, amplitude) + noise(seed, 28) + 7

    def test_separations(self):
        sigma = 0.8 + 0.4 * (numpy.arange(28) % 2)
        for seed, amplitude in enumerate((0, 1.5)):
            y = self.series(amplitude, 20 + seed)
            self.assert_agrees(y, sigma, model.log10_bayes(self.t, y, [(sigma, 1)], (0.1, 3), (40, 200)))

    def test_largest_eccentricity_and_a_column(self):
        y, row, sigma = self.series(1.5, 30), numpy.sin(self.t / 40), numpy.ones(28)
        expected = model.log10_bayes(self.t, y, [(sigma, 1)], (0.1, 3), (40, 200), largest=0.3, functions=[row])
        self.assert_agrees(y, 1, expected, eccentricity_max=0.3, rows=row[:, None])

    def test_axis_of_date(self):
        y, angles, sigma = self.series(1.5, 31), 6 * self.t / 300, numpy.ones(28)
        expected = model.log10_bayes(self.t, y, [(sigma, 1)], (0.1, 3), (40, 200), angles=angles)
        self.assert_agrees(y, 1, expected, position_angle_deg=angles)

    def test_velocities(self):
        y, sigma = self.series(1.5, 32), numpy.ones(28)
        expected = model.log10_bayes(self.t, y, [(sigma, 1)], (0.1, 3), (40, 200), is_velocity=True)
        self.assert_agrees(y, 1, expected, velocity=True)

    def test_jitter(self):
        y, s0 = self.series(1.5, 33), 0.05
        nodes = s0 * (numpy.exp(model.midpoints(0, math.log1p(2 / s0), 12)) - 1)  # of equal weight under 1/(s + s0)
        sigmas = [(numpy.full(28, math.hypot(0.5, s)), 1 / 12) for s in nodes]
        expected = model.log10_bayes(self.t, y, sigmas, (0.1, 3), (40, 200), counts=(60, 8, 12, 8))
        self.assert_agrees(y, 0.5, expected, jitter=True, jitter_max=2)


class Refusals(unittest.TestCase):
    t = days(8, 40)

    def refused(self, name, *, y=None, sigma=1.0, kind=toliman.InputError, **given):
        with refused(kind, name):
            toliman.planets(self.t, self.t % 7 if y is None else y, sigma, **given)

    def test_series(self):
        wrong = self.t % 7
        wrong[5] = math.nan
        self.refused("y[5]", y=wrong)
        self.refused("sigma[5]", sigma=wrong + 1)
        self.refused("series", sigma=None, jitter=False)
        self.refused("data->frame_chi_square", frame_chi_square=-1)
        self.refused("sigma[0]", sigma=-1)
        self.refused("values[5]", rows=wrong[:, None])
        self.refused("position_angle_deg[5]", position_angle_deg=wrong)
        self.refused("t,", y=self.t[1:], kind=ValueError)
        self.refused("rows", rows=self.t, kind=ValueError)
        self.refused("position_angle_deg", position_angle_deg=[1, 2, 3], kind=ValueError)
        self.refused("priors", priors=[1], trend=1, kind=ValueError)
        self.refused("priors[0]", priors=[1, 1], trend=1, kind=ValueError)
        self.refused("order", trend=9)
        self.refused("series", rows=numpy.ones((40, 1)))
        with self.assertRaises(toliman.StateError):
            toliman.planets(self.t[:6], self.t[:6], 1.0)
        with refused(TypeError, "planets()"):
            toliman.planets(self.t, self.t, 1.0, planet_count=2)

    def test_options(self):
        for name, field, values in (
                ("max_planets", "options->max_planets", [5]), ("unit", "unit", [-1, math.inf]),
                ("parallax_arcsec", "options->parallax_arcsec", [-0.1]), ("time_unit_days", "data->time_unit_days", [-1]),
                ("period_min", "options->prior.period_min", [-1, 2000]), ("period_max", "options->prior.period_min", [30]),
                ("period_max", "options->prior.period_max", [math.nan]), ("amplitude_min", "options->prior.amplitude_min", [-1]),
                ("eccentricity_max", "options->prior.eccentricity_max", [0.995, -0.1]),
                ("jitter_max", "options->prior.jitter_max", [-1]), ("threshold", "options->threshold", [math.nan]),
                ("samples", "options->samples", [1000001]), ("detection_fap", "options->detection_fap", [1.5, -0.1])):
            for value in values:
                self.refused(field, **{name: value})
        self.refused("options->star_mass[0]", star_masses=(-1, 1))
        self.refused("options->star_mass[1]", star_masses=(1, math.nan))
        self.refused("star_masses", star_masses=[1], kind=ValueError)
        self.refused("options->prior.amplitude_min", amplitude_min=2, amplitude_max=1)
        with self.assertRaises(toliman.Error) as raised:
            toliman.planets(self.t, self.t % 7, 1.0, period_min=1e-9)
        self.assertEqual(raised.exception.status, toliman._raw.TOLIMAN_E_RANGE)

    def test_progress(self):
        seen = []
        toliman.planets(self.t, self.t % 7, 1.0, samples=100, period_min=200, progress=lambda stage, fraction: seen.append((stage, fraction)))
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction in seen))
        self.assertEqual(seen[-1][1], 1)
        with self.assertRaises(toliman.Cancelled):
            toliman.planets(self.t, self.t % 7, 1.0, progress=lambda stage, fraction: True)

    def test_closed(self):
        found = toliman.planets(self.t, self.t % 7, 1.0, samples=100, period_min=200)
        found.close()
        with refused(ValueError, "this"):
            found.residuals()


if __name__ == "__main__":
    unittest.main()
