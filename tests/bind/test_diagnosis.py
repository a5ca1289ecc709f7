"""Tests the diagnosis of measured separations: times, axes and plate scales that are wrong by a known amount are found
and named, and nothing is claimed of data that are right, noisy, damaged or have a planet."""
import math
import os
import tempfile
import unittest

import numpy

from package import toliman
from refusal import refused

SECOND = 10**9
COUNT, SIGMA = 100, 1e-6
RADIUS_KM, GM = 6978.137, 398600.4418  # km, km^3/s^2
START = toliman.parse_time("2027-01-01")


def exposures(days, seed):
    """Exposures of 60 s at random times."""
    middle = START + numpy.round(numpy.sort(numpy.random.default_rng(seed).uniform(1, days - 1, COUNT)) * 86400).astype(
        numpy.int64) * SECOND
    return numpy.stack([middle - 30 * SECOND, middle + 30 * SECOND], 1)


def measured(sky, intervals, amplitude=0.0, period=300.0, seed=1):
    """Apparent separations with a planet and noise."""
    days = (intervals[:, 0] - START) / 86400e9
    planet = amplitude * numpy.sin(2 * math.pi * days / period + 1)
    seen = [sky.predict_mean(one) for one in intervals]
    noise = SIGMA * numpy.random.default_rng(seed).normal(size=len(intervals))
    return numpy.array([one.factor * (one.geometric_arcsec + shift) for one, shift in zip(seen, planet)]) + noise


def rotation(axis, degrees):
    """Turns vectors about an axis."""
    a, b = (axis + 1) % 3, (axis + 2) % 3
    matrix = numpy.eye(3)
    matrix[a, a] = matrix[b, b] = math.cos(math.radians(degrees))
    matrix[b, a] = math.sin(math.radians(degrees))
    matrix[a, b] = -matrix[b, a]
    return matrix


def write_orbit(path, days, matrix=None, late_s=0):
    """A circular orbit of 600 km, one state every two minutes, whose plane follows the Sun."""
    matrix = numpy.eye(3) if matrix is None else matrix
    n, turn = math.sqrt(GM / RADIUS_KM**3), math.radians(0.9856) / 86400
    t = numpy.arange(0, days * 86400, 120)
    node, tilt = math.radians(100) + turn * t, math.radians(97.8)

    def in_space(along, across):
        x, y = along, across * math.cos(tilt)
        return numpy.stack([numpy.cos(node) * x - numpy.sin(node) * y, numpy.sin(node) * x + numpy.cos(node) * y,
                            across * math.sin(tilt)], 1)

    place = in_space(RADIUS_KM * numpy.cos(n * t), RADIUS_KM * numpy.sin(n * t))
    speed = in_space(-RADIUS_KM * n * numpy.sin(n * t), RADIUS_KM * n * numpy.cos(n * t))
    speed += turn * numpy.stack([-place[:, 1], place[:, 0], numpy.zeros(len(t))], 1)
    times = START + (t + late_s) * SECOND
    with open(path, "w", encoding="utf-8") as out:
        out.write("t_tai_ns,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s\n")
        for tai_ns, numbers in zip(times.tolist(), numpy.hstack([place @ matrix.T, speed @ matrix.T]).tolist()):
            out.write("%d,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f\n" % (tai_ns, *numbers))


class Times(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sky = toliman.Sky(altitude_km=600)
        cls.exposures = exposures(1095, 5)

    def diagnosed(self, late_s, amplitude):
        found, all_of_them = self.sky.diagnose(self.exposures + round(late_s * SECOND),
                                               measured(self.sky, self.exposures, amplitude), SIGMA)
        return found, all_of_them

    # promise: causes-need-seven-sigmas
    def test_a_common_offset_is_found_and_named(self):
        for late_s, amplitude, name in ((37, 0, "TAI taken for UTC"), (-37, 3e-6, "UTC taken for TAI"),
                                        (-30, 3e-6, "starts of exposures taken for their middles"),
                                        (18, 0, "GPS time taken for UTC"), (19, 0, "TAI taken for GPS time"),
                                        (32.184, 0, "TT taken for TAI"), (-69.184, 3e-6, "UTC taken for TT"),
                                        (3600, 3e-6, "local time taken for UTC"), (86400, 0, "the day before or after"),
                                        (25, 0, "")):
            with self.subTest(late_s=late_s):
                found, all_of_them = self.diagnosed(late_s, amplitude)
                time = all_of_them["time"]
                self.assertEqual((found.goodness, found.cause), ("poor", "time"), time.text)
                self.assertLess(abs(time.value - late_s), 4 * time.sigma)
                self.assertLess(time.sigma, 2)
                self.assertLess(time.chi_square, 8 if amplitude else 1.5)
                self.assertTrue(time.text.startswith("times are late by" if late_s > 0 else "times are early by"))
                self.assertEqual(time.text.endswith("?"), bool(name), time.text)
                self.assertIn(name, time.text)

    # promise: planets-are-no-mistakes
    def test_nothing_is_claimed_of_right_times(self):
        for amplitude, period in ((0, 300), (3e-6, 300), (10e-6, 300), (10e-6, 100), (10e-6, 600)):
            with self.subTest(amplitude=amplitude, period=period):
                found, all_of_them = self.sky.diagnose(
                    self.exposures, measured(self.sky, self.exposures, amplitude, period, seed=3), SIGMA)
                self.assertEqual(found.goodness, "poor" if amplitude else "good")
                self.assertEqual(found.cause, "none", all_of_them)
                self.assertFalse(any(one.is_decisive for one in all_of_them.values()))

    # promise: planets-are-no-mistakes
    def test_nothing_is_claimed_of_damaged_samples(self):
        right = measured(self.sky, self.exposures, 3e-6)
        damaged = right.copy()
        damaged[[7, 50, 90]] += [1, -1e-4, 1e-3]
        extreme = numpy.full(COUNT, SIGMA)
        extreme[[3, 40, 80, 99]] = 1e-10
        for separations, sigmas in ((damaged, SIGMA), (right, extreme), (right, SIGMA / 1000)):
            found, _ = self.sky.diagnose(self.exposures, separations, sigmas)
            self.assertEqual((found.goodness, found.cause), ("poor", "none"))

    # promise: causes-need-seven-sigmas
    def test_the_plate_scale_is_found(self):
        for error in (-0.02, 0.01, 0.05):
            found, all_of_them = self.sky.diagnose(self.exposures, measured(self.sky, self.exposures) * (1 + error), SIGMA)
            self.assertEqual(found.cause, "scale")
            scale = all_of_them["scale"]
            self.assertLess(abs(scale.value - error), 4 * scale.sigma)
            self.assertIn("too large" if error > 0 else "too small", scale.text)

    def test_separations_at_the_centre_of_the_earth_are_found(self):
        with self.assertLogs("toliman", "WARNING"):
            earth = toliman.Sky()
        found, all_of_them = self.sky.diagnose(self.exposures, measured(earth, self.exposures), SIGMA)
        self.assertEqual(found.cause, "centre")
        self.assertLess(all_of_them["centre"].chi_square, 1.5)
        found, all_of_them = earth.diagnose(self.exposures, measured(self.sky, self.exposures), SIGMA)
        self.assertEqual((found.goodness, found.cause), ("poor", "none"))  # there is no orbit to be tried
        self.assertEqual(all_of_them["time"].text, "")

    def test_few_measurements_are_not_diagnosed(self):
        found, all_of_them = self.sky.diagnose(self.exposures[:19], measured(self.sky, self.exposures)[:19] + 1e-3, SIGMA)
        self.assertEqual((found.used, found.cause), (19, "none"))
        self.assertTrue(math.isnan(all_of_them["scale"].value))
        with refused(toliman.InputError, "measured"):
            self.sky.diagnose(self.exposures[:0], [], [])

    def test_refused_measurements(self):
        right = measured(self.sky, self.exposures)
        for intervals, separations, text in ((self.exposures, -right, "y[0]"),
                                             (self.exposures[:, 1:], right, "intervals"),
                                             (self.exposures * [1, 1] + [0, 700 * SECOND], right, "intervals")):
            if intervals.shape[1] == 1:
                intervals = intervals[:, 0]
            with refused(ValueError, text):
                self.sky.diagnose(intervals, separations, SIGMA)


class Axes(unittest.TestCase):
    DAYS = 20

    # promise: causes-need-seven-sigmas
    def test_wrong_axes_of_an_observer_file_are_found(self):
        obliquity = 84381.448 / 3600
        cases = ((numpy.eye(3)[[1, 0, 2]], "axes", "x and y of the observer's states are exchanged", 82.2),
                 (numpy.diag([1, 1, -1]), "axes", "z of the observer's states is reversed", 97.8),
                 (numpy.eye(3)[[1, 2, 0]], "axes", "(x, y, z) should be (z, x, y) of the observer's states", None),
                 (-numpy.eye(3), "axes", "all signs of the observer's states are reversed", 97.8),
                 (rotation(0, -obliquity), "axes", "the observer's states have the axes of the ecliptic", None),
                 (rotation(2, 20), "rotation_z", "turned about their axis z by -", 97.8))
        with tempfile.TemporaryDirectory() as folder:
            right, wrong = os.path.join(folder, "right.csv"), os.path.join(folder, "wrong.csv")
            write_orbit(right, self.DAYS)
            sky = toliman.Sky("alpha-cen", right)
            times = exposures(self.DAYS, 8)
            separations = measured(sky, times, 3e-6, 11)
            for matrix, cause, text, inclination in cases:
                with self.subTest(text):
                    write_orbit(wrong, self.DAYS, matrix)
                    sky = toliman.Sky("alpha-cen", wrong)
                    found, all_of_them = sky.diagnose(times, separations, SIGMA)
                    self.assertEqual(found.cause, cause, all_of_them)
                    self.assertIn(text, all_of_them[cause].text)
                    if inclination is not None:
                        self.assertAlmostEqual(sky.info.inclination_deg, inclination, delta=0.1)
            write_orbit(wrong, self.DAYS, late_s=37)
            found, all_of_them = toliman.Sky("alpha-cen", wrong).diagnose(times, separations, SIGMA)
            self.assertIn("times are early by 3", all_of_them["time"].text)  # against those of the observer


if __name__ == "__main__":
    unittest.main()
