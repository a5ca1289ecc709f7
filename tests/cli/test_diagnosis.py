"""Commands that reduce separations name the mistake that explains a poor chi-square, and describe observer files."""
import json
import logging
import math
import unittest

import numpy
from observed import toliman
from program import ProgramTest

logging.getLogger("toliman").setLevel(logging.ERROR)
SECOND, SIGMA, COUNT = 10**9, 1e-6, 40
LOW = ("--altitude", 600, "--exposure", 60)


class Diagnosis(ProgramTest):
    def setUp(self):
        super().setUp()
        random = numpy.random.default_rng(4)
        sky = toliman.Sky(altitude_km=600)
        middle = toliman.parse_time("2027-01-01") + numpy.sort(random.integers(0, 700 * 86400, COUNT)) * SECOND
        values = [sky.predict_mean([t - 30 * SECOND, t + 30 * SECOND]).separation_arcsec for t in middle.tolist()]
        values += SIGMA * random.normal(size=COUNT)
        for name, late_s in (("right", 0), ("late", 37), ("early", -30)):
            mjd = (middle + late_s * SECOND) / 86400e9 + 40587
            rows = [f"{t:.9f},{value:.12f},{SIGMA}" for t, value in zip(mjd, values)]
            (self.folder / f"{name}.csv").write_text("\n".join(["mjd,y,sigma", *rows]) + "\n")

    def run_json(self, *arguments):
        done = self.run_program(*arguments, "--json")
        return json.loads(done.stdout) if done.returncode in (0, 4) else {}, done.stderr

    def test_times_are_named(self):
        """Numbers: tests/bind/test_diagnosis.py."""
        for command, name, late_s in (("period", "right", 0), ("period", "late", 37), ("refit", "early", -30)):
            system = ("--system",) if command == "period" else ()
            files = ("alpha-cen", f"{name}.csv") if command == "refit" else (f"{name}.csv", *system, "alpha-cen")
            result, errors = self.run_json(command, *files, *LOW, "--time-scale", "tai")
            found = result["reduction"]["diagnosis"] if system else result["diagnosis"]
            with self.subTest(command=command, name=name):
                if name == "right":
                    self.assertIsNone(found)
                    continue
                self.assertIn(found["text"], errors)
                self.assertEqual(found["cause"], "time")
                self.assertLess(abs(found["value"] - late_s), 4 * found["sigma"])
                self.assertGreater(found["chi_square_before"], 10)
                self.assertLess(found["chi_square"], 2)

    def test_overlapping_exposures_are_a_warning(self):
        rows = [f"{61406 + k / 1440:.9f},9.77,1" for k in range(5)]  # one per minute
        (self.folder / "fast.csv").write_text("\n".join(["mjd,y,sigma", *rows]) + "\n")
        for exposure, warned in ((600, True), (60, False)):
            done = self.run_program("refit", "alpha-cen", "fast.csv", "--altitude", 600, "--exposure", exposure, "--time-scale", "tai")
            self.assertEqual(done.stderr.count(f"--exposure {exposure}: samples 1 and 2 "), int(warned), done.stderr)

    def test_a_unit_is_named(self):
        text = (self.folder / "right.csv").read_text().splitlines()
        rows = [line.split(",") for line in text[1:]]
        (self.folder / "mas.csv").write_text("\n".join([text[0], *(f"{t},{float(y) * 1e3},{s}" for t, y, s in rows)]) + "\n")
        self.refuse(3, "mas.csv: ", "--plate-scale", arguments=("period", "mas.csv", "--system", "alpha-cen", *LOW, "--time-scale", "tai"))


class ObserverFiles(ProgramTest):
    def test_the_orbit_is_described(self):
        """A circular orbit of 600 km and 97.8 deg, with its node at the mean Sun plus 6 h, exchanged axes and a shift of time."""
        radius, tilt = 6978.137, math.radians(97.8)
        motion = math.sqrt(398600.4418 / radius**3)
        start = toliman.parse_time("2029-01-01")
        days = (start / SECOND + 32.184 - 946728000) / 86400
        node = 2 * math.pi * (days / 365.2422 + 280.46 / 360 + 0.25)
        axes = [numpy.array([math.cos(node), math.sin(node), 0]),
                numpy.array([-math.sin(node) * math.cos(tilt), math.cos(node) * math.cos(tilt), math.sin(tilt)])]
        for name, order in (("right.csv", [0, 1, 2]), ("exchanged.csv", [1, 0, 2])):
            rows = []
            for k in range(120):
                c, s = math.cos(motion * 40 * k), math.sin(motion * 40 * k)
                place, speed = radius * (c * axes[0] + s * axes[1]), radius * motion * (c * axes[1] - s * axes[0])
                rows.append(f"{start + 40 * k * SECOND}," + ",".join(f"{x:.9f}" for x in (*place[order], *speed[order])))
            (self.folder / name).write_text("t_tai_ns,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s\n" + "\n".join(rows) + "\n")
        line = r": .* 600 to 600 km, .* 97.8 deg, .* 18.0 h .*, 2029-01-01 to 2029-01-01, 1.5 "
        predict = ("predict", "alpha-cen", "--times", "2029-01-01T00:10:00", "--observer")
        self.assertRegex(self.succeed(*predict, "right.csv"), "# observer  right.csv" + line)
        self.assertRegex(self.run_program("doctor", "--observer", "right.csv").stdout, "observer     right.csv" + line)
        for command in (predict, ("doctor", "--observer")):
            right, exchanged = (json.loads(self.run_program(*command, name, "--json").stdout)["observer_orbit"]
                                for name in ("right.csv", "exchanged.csv"))
            self.assertAlmostEqual(right["inclination_deg"], 97.8, delta=1e-3)
            self.assertAlmostEqual(exchanged["inclination_deg"], 82.2, delta=1e-3)
            self.assertAlmostEqual(right["node_hours"], 18, delta=1e-3)
            self.assertAlmostEqual(right["node_deg"], math.degrees(node) % 360, delta=1e-3)
            self.assertAlmostEqual(right["period_minutes"], 2 * math.pi / motion / 60, delta=1e-3)
            self.assertAlmostEqual(right["altitude_max_km"], 600, delta=1e-3)
            self.assertEqual((right["states"], right["segments"]), (120, 1))
        self.assertIsNone(json.loads(self.succeed(*predict[:-1], "--altitude", 600, "--json"))["observer_orbit"])


if __name__ == "__main__":
    unittest.main()
