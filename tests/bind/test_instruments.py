"""Tests searches for planets with several instruments: offsets and jitters; and with separations and velocities together:
the star, the direction and the true mass of the planet. Odds are compared with a midpoint rule of all parameters."""
import math
import unittest

import numpy

from package import toliman
from refusal import refused
import planet_model as model
from toliman import _raw

PARALLAX, MASSES = 0.75, (1.08, 0.91)
MOTION = model.AU / model.DAY / PARALLAX  # m/s of 1 arcsec times one radian per day
ARCSEC = {"parallax_arcsec": PARALLAX, "star_masses": MASSES}


def days(random, count, span):
    return numpy.sort(random.uniform(0, span, count))


class Instruments(unittest.TestCase):
    """Three instruments with other zero points, two of which have far more noise than their sigmas."""

    names, offsets, jitters = ("HARPS", "UVES", "CES"), numpy.array([0, 40, -25.0]), numpy.array([0.3, 5, 2])

    @classmethod
    def setUpClass(cls):
        random = numpy.random.default_rng(11)
        cls.t, cls.which = days(random, 100, 1000), random.integers(0, 3, 100)
        cls.which[:3] = 0, 1, 2
        cls.noise = random.normal(size=100) * numpy.hypot(1, cls.jitters[cls.which])

    def series(self, amplitude, names=True, **given):
        y = self.offsets[self.which] + self.noise + amplitude * numpy.cos(2 * math.pi * self.t / 97.3)
        series = toliman.Measurements.of(self.t, y, 1.0, kind="velocity", unit=1, **given)
        return series.set_instruments([self.names[k] for k in self.which]) if names else series

    def test_offsets_and_jitters_of_each(self):
        found = toliman.planets(self.series(3), period_min=80, period_max=150, samples=500, star_masses=(1, 0))
        planet, = found.planets
        self.assertAlmostEqual(planet.period[1], 97.3, delta=2 * (planet.period[2] - planet.period[0]))
        self.assertAlmostEqual(planet.amplitude[1], 3, delta=2 * (planet.amplitude[2] - planet.amplitude[0]))
        self.assertEqual([one.name for one in found.instruments], list(self.names))
        self.assertEqual([one.samples for one in found.instruments], numpy.bincount(self.which).tolist())
        for one, offset, jitter in zip(found.instruments, self.offsets, self.jitters):
            self.assertAlmostEqual(one.offset, offset, delta=4 * one.offset_error + 1e-9)
            self.assertTrue(one.jitter[1] / (one.jitter[2] / one.jitter[1])**3 < jitter <
                            one.jitter[1] * (one.jitter[2] / one.jitter[1])**3, one)
        self.assertAlmostEqual(found.info.jitter[1], max(one.jitter[1] for one in found.instruments), delta=1e-9)

    def test_offsets_hide_a_planet_from_those_who_do_not_name_them(self):
        self.assertEqual(toliman.planets(self.series(3, names=False), period_min=90, samples=100).planets, [])

    def test_noise_is_no_planet(self):
        candidate, = toliman.planets(self.series(0), period_min=150, samples=100).candidates
        self.assertTrue(-1.5 < candidate.log10_bayes < 1, candidate.log10_bayes)

    def test_one_instrument_changes_no_bit(self):
        y = self.noise[self.which == 1]
        one, two = (toliman.Measurements.of(self.t[self.which == 1], y, 1.0) for _ in range(2))
        two.set_instruments(["UVES"] * len(y))
        self.assertEqual(*(toliman.planets(one_of, samples=100, period_min=100).candidates[0].best for one_of in (one, two)))

    def test_odds_of_two_instruments_with_known_noise(self):
        random = numpy.random.default_rng(5)
        t, which = days(random, 28, 300), numpy.arange(28) % 2
        y = model.separation(t, 83, 0.4, 70, 20, 1.5) + 30 * which + random.normal(size=28)
        series = toliman.Measurements.of(t, y, 1.0).set_instruments([f"i{k}" for k in which])
        found = toliman.planets(series, period_min=40, period_max=200, amplitude_min=0.1, amplitude_max=3, jitter=False)
        expected = model.log10_bayes(t, y, [(numpy.ones(28), 1)], (0.1, 3), (40, 200), largest=0.99, functions=[which])
        self.assertAlmostEqual(found.candidates[0].log10_bayes, expected, delta=0.05)

    def test_many(self):
        which = numpy.arange(100) % 25
        y = 10 * which + numpy.random.default_rng(2).normal(size=100) + 4 * numpy.cos(2 * math.pi * self.t / 97.3)
        series = toliman.Measurements.of(self.t, y, 1.0, kind="velocity").set_instruments([f"i{k}" for k in which])
        found = toliman.planets(series, period_min=80, period_max=150, samples=100)
        self.assertEqual((len(found.planets), len(found.instruments)), (1, 25))

    def test_they_stay_through_the_series(self):
        series = self.series(0)
        numpy.testing.assert_array_equal(series.values("instrument"), [self.order(k) for k in self.which])
        self.assertEqual([one.name for one in series.functions], ["offset UVES", "offset CES"])
        self.assertEqual([one.name for one in self.series(0).set_instruments(["a"] * 50 + ["b"] * 50).functions], ["offset b"])

    def order(self, which):
        return list(dict.fromkeys(self.which.tolist())).index(which)

    def test_refusals(self):
        series = toliman.Measurements.of(numpy.arange(40.0), numpy.ones(40), 1.0)
        for names, message in ((["a"] * 39, "instrument"), (["x" * 57] * 40, "names"),
                               ([f"i{k}" for k in range(40)], "functions")):
            with self.subTest(message), refused(toliman.InputError, message):
                series.set_instruments(names)
        self.assertEqual(series.info.instruments, 0)
        with refused(ValueError, "names"):
            series.set_instruments(["a,b"] * 40)


class Velocities(unittest.TestCase):
    """Separations and velocities of both stars, with an offset and a drift each."""

    period, e, w, inclination, node, axis = 300.0, 0.3, 1.0, math.radians(70), math.radians(200), 1e-4

    @classmethod
    def mission(cls, star, seed, sigma=0.3e-6, speed=1.0, axis=None, count=(100, 60)):
        random = numpy.random.default_rng(seed)
        axis = cls.axis if axis is None else axis
        p = numpy.array([math.cos(cls.node) * math.cos(cls.w) - math.sin(cls.node) * math.sin(cls.w) * math.cos(cls.inclination),
                         math.sin(cls.w) * math.sin(cls.inclination)])
        q = numpy.array([-math.cos(cls.node) * math.sin(cls.w) - math.sin(cls.node) * math.cos(cls.w) * math.cos(cls.inclination),
                         math.cos(cls.w) * math.sin(cls.inclination)])

        def planet(t):
            x, y = model.places(2 * math.pi * (t - 40) / cls.period, cls.e)
            return x * p[0] + y * q[0], x * p[1] + y * q[1]  # towards the axis at 0 deg, and away
        t = days(random, count[0], 1000)
        side = 1 if star == 0 else -1  # the separation follows the planet of A, and star B
        y = side * axis * planet(t)[0] + sigma * random.normal(size=len(t))
        series = [toliman.Measurements.of(t, y, sigma, kind="reduced", unit=1)]
        for own in range(2):
            t = days(random, count[1], 1000)
            v = 5 * random.normal() + t / 500 + speed * random.normal(size=len(t))
            if own == star:
                v = v - axis * MOTION * (planet(t + 0.5)[1] - planet(t - 0.5)[1])
            series.append(toliman.Measurements.of(t, v, speed, kind="velocity", unit=1).set_trend(1))
        return series

    def test_star_direction_and_true_mass(self):
        for star in range(2):
            separations, a, b = self.mission(star, 1 + star)
            planet, = toliman.planets(separations, velocities=a, velocities_b=b, samples=500, period_min=250, period_max=400, **ARCSEC).planets
            true = model.mass_of_separation(self.axis, self.period, MASSES[star], PARALLAX)
            mass = (planet.mass_a, planet.mass_b)[star]
            self.assertEqual(planet.star, star)
            self.assertGreater(planet.log10_star * (1 - 2 * star), 100)
            for name, found, truth in (("mass", mass, true), ("i", planet.inclination_deg, 70), ("node", planet.node_deg, 160)):
                with self.subTest(name=name, star=star):
                    self.assertAlmostEqual(found[1], truth if name != "node" else 160, delta=2 * (found[2] - found[0]))
            self.assertTrue(math.isnan((planet.mass_b, planet.mass_a)[star][1]))

    def test_chi_square_is_that_of_the_separations(self):
        separations, a, b = self.mission(0, 5)
        found = toliman.planets(separations, velocities=a, velocities_b=b, samples=200, jitter=False, period_min=250, period_max=400, **ARCSEC)
        freedom = numpy.sum((found.residuals()[:100] / 0.3e-6)**2) / found.info.chi_square
        self.assertTrue(100 - 8 < freedom < 100 - 5)  # mean, 4 amplitudes, 3 of the orbit, shared with the velocities
        self.assertAlmostEqual(found.instruments[0].chi_square, found.info.chi_square, places=9)

    def test_no_velocity_tells_no_star(self):
        separations, a, b = self.mission(0, 3, speed=1000)
        planet, = toliman.planets(separations, velocities=a, velocities_b=b, samples=200, period_min=250, period_max=400, **ARCSEC).planets
        self.assertLess(abs(planet.log10_star), 0.3)
        alone, = toliman.planets(separations, samples=200, period_min=250, period_max=400, **ARCSEC).planets
        self.assertAlmostEqual(alone.log10_bayes, planet.log10_bayes, delta=0.3)
        self.assertTrue(alone.star == -1 and math.isnan(alone.log10_star) and math.isnan(alone.inclination_deg[1]))

    def test_odds_against_a_midpoint_rule(self):
        random = numpy.random.default_rng(8)
        t = [days(random, 24, 300), days(random, 16, 300)]
        y = model.separation(t[0], 83, 0.4, 70, 20, 1.5) + random.normal(size=24)
        v = 20 + random.normal(size=16) + 0.6 * numpy.cos(2 * math.pi * t[1] / 83)
        unit = 7.0 / MOTION  # arcsec of y: 7 m/s of one unit times one radian per day
        separations = toliman.Measurements.of(t[0], y, 1.0, kind="reduced", unit=unit)
        velocities = toliman.Measurements.of(t[1], v, 1.0, kind="velocity", unit=1)
        planet, = toliman.planets(separations, velocities=velocities, jitter=False, period_min=40, period_max=200,
                                  amplitude_min=0.1, amplitude_max=3, **ARCSEC).candidates
        is_velocity = numpy.repeat([False, True], [24, 16])
        of_star = [model.log10_bayes(numpy.concatenate(t), numpy.concatenate([y, v]), [(numpy.ones(40), 1)], (0.1, 3),
                                     (40, 200), largest=0.99, functions=[is_velocity],
                                     motion=numpy.where(is_velocity, size, math.nan)) for size in (7.0, 0.0)]
        self.assertAlmostEqual(planet.log10_star, of_star[0] - of_star[1], delta=0.05)
        self.assertAlmostEqual(planet.log10_bayes, math.log10((10**of_star[0] + 10**of_star[1]) / 2), delta=0.05)

    def test_mirrored_and_edge_on_orbits(self):
        for inclination, node in ((110, 200), (90, 90)):
            with self.subTest(inclination=inclination, node=node):
                class Turned(Velocities):
                    pass
                Turned.inclination, Turned.node = math.radians(inclination), math.radians(node)
                separations, a, b = Turned.mission(0, 9, speed=0.1)
                planet = toliman.planets(separations, velocities=a, velocities_b=b, samples=200, jitter=False,
                                         period_min=250, period_max=400, **ARCSEC).candidates[0]
                self.assertAlmostEqual(planet.inclination_deg[1], 90 - abs(90 - inclination), delta=4)
                mass = model.mass_of_separation(self.axis, self.period, MASSES[0], PARALLAX)
                self.assertAlmostEqual(planet.mass_a[1] / mass, 1, delta=0.02)

    def test_refusals(self):
        t, y = numpy.arange(40.0), numpy.sin(numpy.arange(40.0))
        series = toliman.Measurements.of(t, y, 1.0, kind="reduced", unit=1e-6)
        good = {"kind": "velocity", "unit": 1}
        for velocities, given in (
                (toliman.Measurements.of(t, y, 1.0), ARCSEC),
                (toliman.Measurements.of(t, y, **good), ARCSEC),
                (toliman.Measurements.of(t, y, 1.0, kind="velocity"), ARCSEC),
                (toliman.Measurements.of(t, y, 1.0, **good), {}),
                (toliman.Measurements.of(None, y, 1.0, exposures=[(int(k + 60000) * 10**14, int(k + 60000) * 10**14 + 10**9)
                                                                  for k in t], **good), ARCSEC),
                (toliman.Measurements.of(t[:6], y[:6], 1.0, **good), ARCSEC)):
            with refused(toliman.Error, "options->velocity_b"):
                toliman.planets(series, velocities_b=velocities, **given)
        with refused(toliman.InputError, "options->velocity_a"):
            toliman.planets(toliman.Measurements.of(t, y, 1.0, **good), velocities=toliman.Measurements.of(t, y, 1.0, **good))
        with refused(TypeError, "velocities"):
            toliman.planets(series, velocities=y)
        self.assertEqual(_raw.TOLIMAN_PLANET_COLUMNS, 10)


if __name__ == "__main__":
    unittest.main()
