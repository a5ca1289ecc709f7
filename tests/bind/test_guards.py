"""Tests that the library refuses numbers in wrong units: separations, times, parallaxes and masses."""
import json
import logging
import math
import unittest

import numpy

from package import ROOT, toliman
from refusal import refused

SECOND = 10**9
START = toliman.parse_time("2027-01-01")
SYSTEM = json.loads((ROOT / "examples" / "systems" / "alpha-cen.json").read_text())


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


class Separations(unittest.TestCase):
    def setUp(self):
        self.sky = toliman.Sky(altitude_km=600)
        start = START + numpy.arange(20) * 5403 * SECOND
        self.exposures = numpy.stack([start, start + 60 * SECOND], 1)
        self.right = numpy.array([self.sky.predict_mean(one).separation_arcsec for one in self.exposures])

    # promise: separation-units-are-checked
    def test_other_units_are_named(self):
        for factor, unit in ((1e3, "mas"), (1e6, "uas"), (1 / 60, "arcmin"), (1 / 3600, "deg"), (math.radians(1 / 3600), "rad"),
                             (1 / 0.375, "px, or those of another system"), (0.4, "px, or those of another system")):
            with self.assertRaisesRegex(ValueError, f"y: median .* must be in arcsec; are they in {unit}\\?"):
                self.sky.reduce(self.exposures, self.right * factor)

    # promise: separation-units-are-checked
    def test_wrong_orbits_outliers_and_missing_values_are_not_units(self):
        for factor in (0.6, 0.8, 1.2, 1.9):
            self.sky.reduce(self.exposures, self.right * factor)
        damaged = self.right.copy()
        damaged[:9] *= 1e6
        self.assertEqual(len(self.sky.reduce(self.exposures, damaged)), 20)
        damaged[10] = math.nan
        with refused(ValueError, "y[10]"):
            self.sky.reduce(self.exposures, damaged)
        with refused(ValueError, "measured"):
            self.sky.reduce(self.exposures[:0], [])


class Times(unittest.TestCase):
    # promise: time-units-are-checked
    def test_numbers_that_are_no_nanoseconds(self):
        sky = toliman.Sky(altitude_km=600)
        for times, unit in (([START // SECOND], r"seconds\?"), ([START // 10**6], r"milliseconds\?"),
                            ([START // 10**3], r"microseconds\?"), ([61406, 61407], r"days \(MJD\)\?"),
                            ([2461406], r"days \(JD\)\?"), ([12345, 10**14 + 1], "nanoseconds of TAI$")):
            with self.assertRaisesRegex(ValueError, "is near 1970-01-01, as are all times of the call.*" + unit):
                sky.predict(times)
            pairs = [[time, time + 1] for time in times]
            for call in (lambda: sky.predict_mean(pairs[:1]), lambda: sky.reduce(pairs, [9.8] * len(pairs)),
                         lambda: sky.refit(pairs, [9.8] * len(pairs), 1e-6), lambda: sky.diagnose(pairs, [9.8] * len(pairs), 1e-6)):
                with refused(ValueError, "intervals"):
                    call()
        for dates in ([0], [12 * 86400 * SECOND], [12345, 60 * 86400 * SECOND], [-12345]):  # whole seconds, and others
            self.assertEqual(len(sky.predict(dates)), len(dates))
        self.assertEqual(len(sky.predict([])), 0)


class Properties(unittest.TestCase):
    def system(self, group, key, value):
        system = json.loads(json.dumps(SYSTEM))
        (system[group] if group else system)[key] = value
        return json.dumps(system)

    def test_parallax_and_masses_of_a_system(self):
        for group, key, value in (("barycentre", "parallax_mas", 750810), ("barycentre", "parallax_mas", 1332),
                                  ("masses", "A", 2.1e30), ("masses", "B", 1e-3)):
            with refused(toliman.InputError, f"{group}.{key}"):
                toliman.Sky(self.system(group, key, value))
        for group, key, value in (("barycentre", "parallax_mas", 768.07), ("masses", "A", 0.08), ("masses", "B", 150)):
            toliman.Sky(self.system(group, key, value))

    def test_parallax_and_masses_of_planets(self):
        t = numpy.arange(20) * 30.0
        y = 1e-6 * numpy.sin(t)
        for parallax, masses, text in ((750, (1, 1), "options->parallax_arcsec"),
                                       (1.33, (1, 1), "options->parallax_arcsec"), (0.75, (2e30, 1), "options->star_mass[0]"),
                                       (0.75, (1, 1e-6), "options->star_mass[1]")):
            with refused(ValueError, text):
                toliman.planets(t, y, 1e-6, unit=1, parallax_arcsec=parallax, star_masses=masses)

    def test_a_long_name_ends_with_a_whole_character(self):
        for name in ("\u03b1" * 40, "a" + "\u03b1" * 40, "\U0001f31f" * 20, "ab\U0001f31f" * 20, "a" * 100):
            self.assertTrue(name.startswith(toliman.Sky(self.system("", "name", name)).info.name))
            self.assertGreater(len(toliman.Sky(self.system("", "name", name)).info.name.encode()), 67)


if __name__ == "__main__":
    unittest.main()
