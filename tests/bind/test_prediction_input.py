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

SYSTEM = json.loads((ROOT / "examples" / "systems" / "alpha-cen.json").read_text())
TIMES = toliman.parse_time("2027-01-01") + numpy.arange(50) * 10**15
logging.getLogger("toliman").setLevel(logging.ERROR)


class Refusals(unittest.TestCase):
    def refuse(self, kind, message, call):
        with self.assertRaises(kind) as raised:
            call()
        self.assertEqual(str(raised.exception), message)


class Arguments(Refusals):
    def test_options(self):
        input_error = toliman.InputError
        for kind, message, options in (
            (ValueError, "without: 'aberration': must be one of earth_aberration, spacecraft_aberration, parallax, roemer, "
             "light_time, radial_motion, transverse_motion, deflection", {"without": "aberration"}),
            (input_error, "options->altitude_km = 100: must be in [200, 2000] km, or 0 for none", {"altitude_km": 100}),
            (input_error, "options->altitude_km = nan: must be in [200, 2000] km, or 0 for none",
             {"altitude_km": float("nan")}),
            (input_error, "options->altitude_km = 600: must be 0 with observer", {"observer": "x", "altitude_km": 600}),
            (input_error, "options->node_hours = 25: must be in (0, 24] h, or 0 for 18",
             {"altitude_km": 600, "node_hours": 25}),
            (input_error, "options->node_hours = 6: needs altitude_km", {"node_hours": 6}),
            (toliman.NotFoundError, "missing.oem: No such file or directory", {"observer": "missing.oem"}),
            (toliman.NotFoundError, "missing.json: No such file or directory", {"system": "missing.json"}),
        ):
            with self.subTest(message):
                self.refuse(kind, message, lambda: toliman.Sky(**options))

    def test_times(self):
        sky, range_text = toliman.Sky(), "must be from 1900-01-01T12 to 2099-12-31T12 TT"
        longest = 2**63
        for kind, message, times in (
            (toliman.InputError, f"time = -3786825600000000000 ns TAI: {range_text}", [0, -3786825600 * 10**9]),
            (toliman.InputError, f"time = 4200000000000000000 ns TAI: {range_text}", [4200000000 * 10**9]),
            (toliman.InputError, f"time = {-longest} ns TAI: {range_text}", -longest),
            (toliman.InputError, f"time = {longest - 1} ns TAI: {range_text}", [longest - 1]),
            (TypeError, "tai_ns is an array of float64: must be integers, nanoseconds of TAI (parse_time)", [61000.5]),
            (TypeError, "tai_ns is an array of datetime64[D]: must be integers, nanoseconds of TAI (parse_time)",
             numpy.array(["2027-01-01"], "M8[D]")),
            (ValueError, f"tai_ns = {longest}: must be below 2^63", numpy.array([longest], "u8")),
        ):
            with self.subTest(message):
                self.refuse(kind, message, lambda: sky.predict(times))

    def test_intervals(self):
        sky, range_text = toliman.Sky(), "must be from 1900-01-01T12 to 2099-12-31T12 TT"
        for kind, message, intervals in (
            (toliman.InputError, "intervals: must not be empty", []),
            (toliman.InputError, "intervals: start 10, end 5 ns TAI: must begin before it ends", [10, 5]),
            (toliman.InputError, "intervals: start 7, end 7 ns TAI: must begin before it ends", [[0, 5], [7, 7]]),
            (toliman.InputError, "intervals: one ends at 9, another starts at 8 ns TAI: must not overlap", [[8, 12], [2, 9]]),
            (toliman.InputError, "intervals: 401 days: must be at most 400 days", [0, 401 * 86400 * 10**9]),
            (toliman.InputError, "intervals: start 10, end 5 ns TAI: must begin before it ends", [[0, 5], [10, 5]]),
            (toliman.InputError, f"time = {-2**63} ns TAI: {range_text}", [-2**63, 2**63 - 1]),
            (ValueError, "intervals has shape (3,): must be (2,) or (n, 2)", [1, 2, 3]),
            (ValueError, "intervals has shape (2, 3): must be (2,) or (n, 2)", [[1, 2, 3], [1, 2, 3]]),
            (TypeError, "intervals is an array of float64: must be integers, nanoseconds of TAI (parse_time)",
             [[0.5, 1]]),
        ):
            with self.subTest(message):
                self.refuse(kind, message, lambda: sky.predict_mean(intervals))

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
        sky = toliman.Sky(altitude_km=600)
        self.refuse(toliman.InputError, "intervals: zero length: must be start and end of the exposure for an observer in orbit",
                    lambda: sky.predict_mean([TIMES[0], TIMES[0]]))

    def test_refit(self):
        sky, separations = toliman.Sky(), numpy.full(50, 10)
        self.refuse(TypeError, "tai_ns is an array of float64: must be integers, nanoseconds of TAI (parse_time)",
                    lambda: sky.refit(TIMES / 86400e9, separations, 1e-6))

    def test_warning(self):
        """The Earth's centre is hardly ever meant; an observer, or leaving the spacecraft out, is a decision."""
        with self.assertLogs("toliman", "WARNING") as logs:
            toliman.Sky()
        self.assertRegex(logs.output[0], "no observer given: predictions are for the Earth's centre; the velocity of a "
                         r"spacecraft in a low orbit changes the separation \(10.3 arcsec in 2030\) by up to 261 uas$")
        with self.assertNoLogs("toliman", "WARNING"):
            toliman.Sky(altitude_km=600)
            toliman.Sky(without=["spacecraft_aberration"])


class Systems(Refusals):
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
        for text, message in (('{"schema": ', "binary.json: line 1, column 12: JSON syntax error"),
                              ("", "binary.json: is empty"),
                              ("[]", "binary.json: the system = an array: must be an object"),
                              ('{"schema": NaN}', "binary.json: line 1, column 12: unexpected character")):
            with self.subTest(message):
                self.refuse(toliman.InputError, message, lambda: self.sky_of(text))

    def test_contents(self):
        def changed(group, **changes):
            system = copy.deepcopy(SYSTEM)
            part = system[group] if group else system
            part.update(changes)
            for key in [key for key, value in part.items() if value is None]:
                del part[key]
            return json.dumps(system)

        for message, text in (
            ('schema = "toliman-scene/1": must be one of "toliman-system/1"; did you mean "toliman-system/1"?',
             changed("", schema="toliman-scene/1")),
            ("schema: is missing", changed("", schema=None)),
            ("masses: is missing", changed("", masses=None)),
            ("orbit.epoch: is missing", changed("orbit", epoch=None)),
            ("barycentre.radial_velocity_kind: is missing", changed("barycentre", radial_velocity_kind=None)),
            ('orbit.ecentricity: unknown key; did you mean "eccentricity"?', changed("orbit", ecentricity=0.5)),
            ('barycenter: unknown key; did you mean "barycentre"?', changed("", barycenter={})),
            ('sigma.orbits: unknown key; did you mean "orbit"?', changed("sigma", orbits={})),
            ("orbit.eccentricity = 1: must be in [0, 0.9999]", changed("orbit", eccentricity=1)),
            ("orbit.period_years = 0: must be in (0, 1000000] years", changed("orbit", period_years=0)),
            ("orbit.node_deg = 361: must be in [-360, 360] deg", changed("orbit", node_deg=361)),
            ("barycentre.parallax_mas = 0: must be in (0, 770] mas", changed("barycentre", parallax_mas=0)),
            ("masses.A = -1: must be in [0.01, 500] solar masses", changed("masses", A=-1)),
            ('masses.B = "heavy": must be a number in [0.01, 500] solar masses', changed("masses", B="heavy")),
            ("orbit.source = 5: must be a string", changed("orbit", source=5)),
            ('barycentre.radial_velocity_kind = "optical": must be one of "kinematic", "spectroscopic"',
             changed("barycentre", radial_velocity_kind="optical")),
            ("barycentre.line_shift_km_s: is missing", changed("barycentre", radial_velocity_kind="spectroscopic")),
            ("barycentre.line_shift_km_s: needs radial_velocity_kind spectroscopic",
             changed("barycentre", line_shift_km_s=0.06)),
            ("sigma.orbit.epoch = -1: must be in [0, 1000000] years", changed("sigma", orbit={"epoch": -1})),
        ):
            with self.subTest(message):
                self.refuse(toliman.InputError, "binary.json: " + message, lambda: self.sky_of(text))


if __name__ == "__main__":
    unittest.main()
