"""Bad arguments, times and system files of predictions: what is refused, and with which message."""
import copy
import json
import logging
import os
import pathlib
import tempfile
import unittest

import numpy

from package import ROOT, toliman
from refusal import refused

SYSTEM = json.loads((ROOT / "examples" / "systems" / "alpha-cen.json").read_text())
TIMES = toliman.parse_time("2027-01-01") + numpy.arange(50) * 10**15
logging.getLogger("toliman").setLevel(logging.ERROR)


class Arguments(unittest.TestCase):
    """The library's own refusals: tests/unit/test_sky_api.c."""

    def test_types_and_words(self):
        sky = toliman.Sky()
        for kind, name, call in (
                (ValueError, "without", lambda: toliman.Sky(without="aberration")),
                (toliman.InputError, "options->altitude_km", lambda: toliman.Sky(altitude_km=100)),
                (toliman.NotFoundError, "missing.oem", lambda: toliman.Sky(observer="missing.oem")),
                (toliman.NotFoundError, "missing.json", lambda: toliman.Sky("missing.json")),
                (toliman.InputError, "time", lambda: sky.predict([0, -3786825600 * 10**9])),
                (TypeError, "tai_ns", lambda: sky.predict([61000.5])),
                (ValueError, "tai_ns", lambda: sky.predict(numpy.array(["NaT"], "M8[D]"))),
                (ValueError, "tai_ns", lambda: sky.predict(numpy.array([2**63], "u8"))),
                (TypeError, "tai_ns", lambda: sky.refit(TIMES / 86400e9, numpy.full(50, 10), 1e-6))):
            with self.subTest(name), refused(kind, name):
                call()

    def test_intervals(self):
        sky = toliman.Sky()
        for kind, intervals in (
                (toliman.InputError, []), (toliman.InputError, [[0, 5], [7, 7]]), (toliman.InputError, [[8, 12], [2, 9]]),
                (toliman.InputError, [0, 401 * 86400 * 10**9]), (toliman.InputError, [[0, 5], [10, 5]]), (ValueError, [1, 2, 3]),
                (ValueError, [[1, 2, 3], [1, 2, 3]]), (TypeError, [[0.5, 1]])):
            with self.subTest(intervals=intervals), refused(kind, "intervals"):
                sky.predict_mean(intervals)

    def test_intervals_that_touch(self):
        """In any order, they are one."""
        sky, (start, middle, end) = toliman.Sky(altitude_km=600), TIMES[0] + numpy.array([0, 700, 2000]) * 10**9
        whole, parts = (sky.predict_mean(one) for one in ([start, end], [[middle, end], [start, middle]]))
        numpy.testing.assert_allclose(parts.separation_arcsec, whole.separation_arcsec, rtol=1e-12)
        with refused(toliman.InputError, "intervals"):
            sky.predict_mean([[middle - 1, end], [start, middle]])

    def test_an_instant(self):
        sky = toliman.Sky()
        time = TIMES[0]
        self.assertEqual(sky.predict_mean([time, time]).separation_arcsec, sky.predict(time)["separation_arcsec"])

    def test_shapes(self):
        sky = toliman.Sky()
        self.assertEqual(sky.predict([]).shape, (0,))
        self.assertEqual(sky.predict(TIMES[0]).shape, ())
        self.assertEqual(sky.predict(TIMES.reshape(5, 10)).shape, (5, 10))
        numpy.testing.assert_array_equal(sky.predict(TIMES[::-1]), sky.predict(TIMES)[::-1])

    def test_mean_of_an_instant(self):
        with refused(toliman.InputError, "intervals"):
            toliman.Sky(altitude_km=600).predict_mean([TIMES[0], TIMES[0]])

    def test_warning(self):
        """The Earth's centre is hardly ever meant; an observer, or leaving the spacecraft out, is a decision."""
        with self.assertLogs("toliman", "WARNING") as logs:
            toliman.Sky()
        self.assertRegex(logs.output[0], "no observer given: predictions are for the Earth's centre; the velocity of a "
                         r"spacecraft in a low orbit changes the separation \(10.3 arcsec in 2030\) by up to 261 uas$")
        with self.assertNoLogs("toliman", "WARNING"):
            toliman.Sky(altitude_km=600)
            toliman.Sky(without=["spacecraft_aberration"])


class Systems(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)

    def sky_of(self, text):
        pathlib.Path("binary.json").write_text(text)
        return toliman.Sky("binary.json")

    def test_file_of_the_built_in_system(self):
        for options in ({}, {"altitude_km": 600}):
            named = toliman.Sky(**options)
            read = toliman.Sky(ROOT / "examples" / "systems" / "alpha-cen.json", **options)
            self.assertEqual(named.predict(TIMES).tobytes(), read.predict(TIMES).tobytes())
            self.assertEqual(named.elements, read.elements)
            self.assertEqual(named.info, read.info)

    def test_saved_systems_have_the_same_bits(self):
        toliman.Sky().save("saved.json")
        saved = toliman.Sky("saved.json")
        self.assertEqual(saved.predict(TIMES).tobytes(), toliman.Sky().predict(TIMES).tobytes())
        self.assertEqual(saved.elements, toliman.Sky().elements)
        system = {key: value for key, value in SYSTEM.items() if key not in ("name", "sigma")}
        system["orbit"] = {**SYSTEM["orbit"], "epoch": 1955.564 + 2**-42}  # the last bit needs 17 digits
        sky = self.sky_of(json.dumps(system))
        sky.save("saved.json")
        self.assertEqual(set(json.loads(pathlib.Path("saved.json").read_text())), set(system))
        self.assertEqual(toliman.Sky("saved.json").elements, sky.elements)
        self.assertNotEqual(sky.elements["epoch"], toliman.Sky().elements["epoch"])

    def test_kinds_of_radial_velocity(self):
        system = copy.deepcopy(SYSTEM)
        system["barycentre"].update(radial_velocity_km_s=-22.3796, radial_velocity_kind="spectroscopic",
                                    line_shift_km_s=-0.0614)
        numpy.testing.assert_allclose(self.sky_of(json.dumps(system)).predict(TIMES)["separation_arcsec"],
                                      toliman.Sky().predict(TIMES)["separation_arcsec"], rtol=1e-15)

    def test_errors_and_name_are_optional(self):
        system = {key: value for key, value in SYSTEM.items() if key not in ("name", "sigma")}
        sky = self.sky_of(json.dumps(system))
        self.assertEqual(sky.info.name, "")
        self.assertEqual(sky.elements["eccentricity"], (0.51947, 0))
        self.assertEqual(sky.info.orbit_digest, toliman.Sky().info.orbit_digest)

    def test_not_json(self):
        for text in '{"schema": ', "", "[]", '{"schema": NaN}':
            with self.subTest(text), self.assertRaises(toliman.InputError):
                self.sky_of(text)

    def test_contents(self):
        for group, changes, *names in (
                ("", {"schema": "toliman-scene/1"}), ("", {"schema": None}), ("", {"masses": None}), ("", {"barycenter": {}}),
                ("orbit", {"epoch": None}), ("orbit", {"ecentricity": 0.5}), ("orbit", {"eccentricity": 1}),
                ("orbit", {"period_years": 0}), ("orbit", {"node_deg": 361}), ("orbit", {"source": 5}),
                ("barycentre", {"radial_velocity_kind": None}), ("barycentre", {"parallax_mas": 0}),
                ("barycentre", {"radial_velocity_kind": "optical"}), ("barycentre", {"line_shift_km_s": 0.06}),
                ("barycentre", {"radial_velocity_kind": "spectroscopic"}, "barycentre.line_shift_km_s"),
                ("masses", {"A": -1}), ("masses", {"B": "heavy"}), ("sigma", {"orbits": {}}),
                # mistaken units, and numbers that no prediction resolves
                ("barycentre", {"parallax_mas": 0.747}, "barycentre"), ("barycentre", {"parallax_mas": 1e-300}),
                ("barycentre", {"pm_ra_mas_yr": 0, "pm_dec_mas_yr": 0, "parallax_mas": 0.747}, "masses"),
                ("orbit", {"semi_major_arcsec": 17493}, "masses"), ("orbit", {"semi_major_arcsec": 1e-9}),
                ("orbit", {"period_years": 79.762 * 365.25}, "masses"), ("orbit", {"period_years": 1e-300}),
                ("sigma", {"orbit": {"epoch": -1}}, "sigma.orbit.epoch")):
            system = copy.deepcopy(SYSTEM)
            part = system[group] if group else system
            part.update(changes)
            for key in [key for key, value in part.items() if value is None]:
                del part[key]
            name = names[0] if names else ".".join(filter(None, (group, *changes)))
            with self.subTest(name), refused(toliman.InputError, name):
                self.sky_of(json.dumps(system))


if __name__ == "__main__":
    unittest.main()
