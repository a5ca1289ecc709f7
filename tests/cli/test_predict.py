"""toliman predict: the numbers of the library, times in every scale, and its refusals."""
import json
import logging
import unittest

import numpy
from observed import SYSTEM, toliman, write_orbit
from program import ProgramTest, leap_seconds

logging.getLogger("toliman").setLevel(logging.ERROR)
LOW = ("predict", "alpha-cen", "--altitude", 600)


class Predict(ProgramTest):
    def predictions(self, *arguments):
        return json.loads(self.succeed(*arguments, "--json"))

    def columns(self, *arguments):
        """The table by columns, and its head."""
        lines = self.succeed(*arguments).splitlines()
        head = [line for line in lines if line.startswith("#")]
        names, *rows = [line.split() for line in lines if not line.startswith("#")]
        return head, {name: [row[i] for row in rows] for i, name in enumerate(names)}

    def test_numbers_of_the_library(self):
        found = self.predictions("predict", "alpha-cen", "--altitude", 700, "--node", 6, "--without", "roemer,light_time",
                                 "--from", "2027-01-01", "--to", "2027-03-01", "--every", 10)
        rows = found.pop("predictions")
        self.assertEqual(found, {
            "schema": "toliman-predict/1", "version": toliman.__version__, "system": "alpha-cen",
            "name": "alpha Centauri AB", "orbit_digest": f"{toliman.Sky(altitude_km=600).info.orbit_digest:016x}",
            "observer": "circular orbit", "observer_file": None, "altitude_km": 700, "node_hours": 6, "observer_orbit": None,
            "without": ["roemer", "light_time"], "scale": "utc"})
        sky = toliman.Sky(altitude_km=700, node_hours=6, without=["roemer", "light_time"])
        times = toliman.parse_time("2027-01-01") + numpy.arange(6) * 864 * 10**12
        self.assertEqual([row["tai_ns"] for row in rows], times.tolist())
        self.assertEqual(rows[5]["time"], "2027-02-20T00:00:00")
        for name in ("separation_arcsec", "position_angle_deg", "geometric_arcsec", "geometric_angle_deg", "factor",
                     "barycentric_offset_s", "approach_m_s", "sun_angle_deg"):
            self.assertEqual([row[name] for row in rows], sky.predict(times)[name].tolist(), name)
        self.assertEqual([row["partials"] for row in rows], sky.predict(times)["partials"].tolist())

    def test_fractions_of_a_day(self):
        found = self.predictions(*LOW, "--from", "2027-01-01", "--to", "2027-01-02", "--every", 0.1)["predictions"]
        steps = numpy.diff([row["tai_ns"] for row in found])
        self.assertEqual(steps.tolist(), [8640 * 10**9] * 10)

    def test_table(self):
        arguments = (*LOW, "--times", "2027-01-01,61500,2461600.25,2028-02-29T12:00:00.5Z")
        head, table = self.columns(*arguments)
        self.assertEqual(head, ["# system    alpha Centauri AB",
                                "# observer  circular orbit, altitude 600 km, node at 18 h", "# without   nothing",
                                "# scale     utc"])
        rows = self.predictions(*arguments)["predictions"]
        self.assertEqual(table.pop("time"), ["2027-01-01", "61500", "2461600.25", "2028-02-29T12:00:00.5Z"])
        for name, form, value in (("separation_arcsec", "%.9f", lambda row: row["separation_arcsec"]),
                                  ("position_angle_deg", "%.7f", lambda row: row["position_angle_deg"]),
                                  ("geometric_arcsec", "%.9f", lambda row: row["geometric_arcsec"]),
                                  ("factor_ppm", "%.6f", lambda row: (row["factor"] - 1) * 1e6),
                                  ("offset_s", "%.6f", lambda row: row["barycentric_offset_s"]),
                                  ("approach_m_s", "%.3f", lambda row: row["approach_m_s"]),
                                  ("sun_deg", "%.3f", lambda row: row["sun_angle_deg"])):
            self.assertEqual(table.pop(name), [form % value(row) for row in rows], name)
        self.assertEqual(table, {})

    def test_time_scales(self):
        utc, *others = (self.predictions(*LOW, "--times", time, "--scale", scale)["predictions"][0]["tai_ns"]
                        for scale, time in (("utc", "2027-01-01"), ("tai", "2027-01-01T00:00:37"),
                                            ("tt", "2027-01-01T00:01:09.184"), ("gps", "2027-01-01T00:00:18")))
        self.assertEqual(others, [utc] * 3)
        # days of UTC, one of which has a leap second
        rows = self.predictions(*LOW, "--from", "2016-12-31", "--to", "2017-01-02")["predictions"]
        self.assertEqual(numpy.diff([row["tai_ns"] for row in rows]).tolist(), [86401 * 10**9, 86400 * 10**9])
        (self.folder / "leap-seconds.list").write_text(leap_seconds(61300, 61400))
        new = self.predictions(*LOW, "--times", "2027-01-01", "--leap-seconds", "leap-seconds.list")
        self.assertEqual(new["predictions"][0]["tai_ns"], utc + 2 * 10**9)

    def test_expired_leap_seconds(self):
        """Told once, whatever brings the dates: times, an observer file; not for other scales."""
        (self.folder / "new.list").write_text(leap_seconds())
        (self.folder / "old.list").write_text(leap_seconds(expires=61400))
        for more, count, text in (((), 1, "2031-01-01"), (("--leap-seconds", "old.list"), 1, "2026-12-26: --leap-seconds FILE"),
                                  (("--leap-seconds", "new.list"), 0, ""), (("--scale", "tai"), 0, "")):
            done = self.run_program(*LOW, "--times", "2030-01-01,2031-01-01", *more)
            self.assertEqual((done.returncode, done.stderr.count("\n"), text in done.stderr), (0, count, True), done.stderr)
        rows = ["t_utc,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s"]
        for minute in range(12):
            c, s = numpy.cos(0.0646806 * minute), numpy.sin(0.0646806 * minute)
            rows.append(f"2031-001 00:{minute:02d}:00,{7000 * c},{7000 * s},0,{-7.54607 * s},{7.54607 * c},0")
        (self.folder / "far.csv").write_text("\n".join(rows))
        done = self.run_program("predict", "alpha-cen", "--observer", "far.csv", "--times", "2031-01-01T00:05:40",
                                "--scale", "tai")
        self.assertIn("2031-01-01", done.stderr)
        (self.folder / "bad.list").write_text(leap_seconds().replace("#$\t", "#$\t1"))
        self.refuse(3, "bad.list: ", arguments=(*LOW, "--times", "2027-01-01", "--leap-seconds", "bad.list"))

    def test_times_of_a_file(self):
        (self.folder / "times.csv").write_text("date,y\n# a comment\n\n2027-01-01T00:00:00.25,5\n  61500 7\n")
        expected = self.succeed(*LOW, "--times", "2027-01-01T00:00:00.25,61500")
        self.assertEqual(self.succeed(*LOW, "--times-file", "times.csv"), expected)
        (self.folder / "marked.csv").write_bytes(b"\xef\xbb\xbf2027-01-01T00:00:00.25\n61500\n")  # by some editors
        self.assertEqual(self.succeed(*LOW, "--times-file", "marked.csv"), expected)
        self.assertEqual(self.succeed(*LOW, "--times-file", "-", input="2027-01-01T00:00:00.25\n61500"), expected)
        plain = self.predictions(*LOW, "--times", "2027-01-01T00:00:00.25,61500")["predictions"]
        (self.folder / "times.csv").write_text("2027-001 00:00:00.25+00:00 5\n61500 7\n")  # a blank within a time
        found = self.predictions(*LOW, "--times-file", "times.csv")["predictions"]
        self.assertEqual([row["tai_ns"] for row in found], [row["tai_ns"] for row in plain])
        self.refuse(2, "--times", "+02:00", arguments=(*LOW, "--times", "2027-01-01T00:00:00+02:00"))

    def test_many_times(self):
        """More than fit into one portion."""
        _, table = self.columns(*LOW, "--from", "2027-01-01", "--to", "2027-01-11", "--every", 1e-3)
        self.assertEqual(len(set(table["time"])), 10001)

    def test_node_at_midnight(self):
        """0 h is 24 h, not the default."""
        times = ("--times", "2027-01-01", "--node")
        self.assertEqual(*(self.predictions(*LOW, *times, hours)["predictions"] for hours in (0, 24)))
        self.assertNotEqual(*(self.predictions(*LOW, *times, hours)["predictions"] for hours in (0, 18)))

    def test_system_files(self):
        (self.folder / "binary.json").write_bytes(SYSTEM.read_bytes())
        found = self.predictions("predict", "binary.json", "--altitude", 600, "--times", "2027-01-01")
        self.assertEqual(found["system"], "binary.json")
        self.assertEqual(found["predictions"], self.predictions(*LOW, "--times", "2027-01-01")["predictions"])

    def test_observer_file(self):
        start = toliman.parse_time("2027-01-01")
        write_orbit(self.folder / "spacecraft.csv", start, 12)
        arguments = ("predict", "alpha-cen", "--observer", "spacecraft.csv", "--times")
        found = self.predictions(*arguments, "2027-01-01T00:05:00")
        self.assertEqual((found["observer"], found["observer_file"], found["altitude_km"], found["node_hours"]),
                         ("file", "spacecraft.csv", None, None))
        seen = toliman.Sky("alpha-cen", self.folder / "spacecraft.csv").predict(start + 300 * 10**9)
        self.assertEqual(found["predictions"][0]["separation_arcsec"], seen["separation_arcsec"])
        self.assertRegex(self.succeed(*arguments, "2027-01-01T00:05:00"), "# observer  spacecraft.csv: .* 622 to 622 km, .* 0.0 deg, ")
        done = self.run_program(*arguments, "2027-01-02")
        self.assertIn("spacecraft.csv", done.stderr)
        self.assertEqual((done.returncode, done.stdout), (2, ""))

    def test_inclined_observer(self):
        """An orbit of 7000 km with inclination 98 deg and node 40 deg, from 30 deg after the node on."""
        start, (c, s), (up, across) = toliman.parse_time("2027-01-01"), *((numpy.cos(numpy.radians(a)), numpy.sin(numpy.radians(a)))
                                                                          for a in (40, 98))
        to_node, further = numpy.array([c, s, 0]), numpy.array([-s * up, c * up, across])
        lines = ["t_tai_ns,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s"]
        for k in range(12):
            angle = numpy.radians(30) + 0.00107801 * 60 * k
            place = 7000 * (numpy.cos(angle) * to_node + numpy.sin(angle) * further)
            speed = 7.54607 * (numpy.cos(angle) * further - numpy.sin(angle) * to_node)
            lines.append(",".join(map(str, [start + 60 * k * 10**9, *place.tolist(), *speed.tolist()])))
        (self.folder / "polar.csv").write_text("\n".join(lines) + "\n")
        orbit = self.predictions("predict", "alpha-cen", "--observer", "polar.csv", "--times", "2027-01-01T00:05:00")["observer_orbit"]
        for name, expected in (("inclination_deg", 98), ("node_deg", 40), ("period_minutes", 2 * numpy.pi / 0.00107801 / 60)):
            self.assertAlmostEqual(orbit[name] / expected, 1, delta=1e-4, msg=name)

    def test_centre_of_the_earth(self):
        done = self.run_program("predict", "alpha-cen", "--times", "2027-01-01")
        self.assertEqual(done.returncode, 0)
        self.assertIn("# observer  centre of the Earth\n", done.stdout)
        self.assertIn("warning: ", done.stderr)
        self.succeed("predict", "alpha-cen", "--times", "2027-01-01", "--without", "spacecraft_aberration")

    def test_refusals(self):
        (self.folder / "bad.csv").write_text("2027-01-01\nnoon\n")
        (self.folder / "empty.csv").write_text("# nothing\n")
        times = ("--times", "2027-01-01")
        span = ("--from", "2027-01-01", "--to", "2027-01-02", "--every")
        self.refuse_all(
            (2, "--times, --times-file, or --from and --to"),
            *((2, f"--times {time}: ", "--times", time) for time in ("2027.5", "noon", "1850-01-01")),
            (2, "--from ", "--from", "2027-01-01"),
            (2, "--to 2027-01-01: ", "--from", "2027-02-01", "--to", "2027-01-01"),
            *((2, f"--every {step}: ", *span, step) for step in (0, 1e-30, 1e-9)),
            (2, "--times ", *times, "--times-file", "bad.csv"),
            (3, "bad.csv: line 2: noon: ", "--times-file", "bad.csv"),
            *((3, f"{name}: ", "--times-file", name) for name in ("empty.csv", "missing.csv")),
            (2, "--without aberration: ", *times, "--without", "aberration"),
            (2, "--scale local: ", *times, "--scale", "local"),
            (3, "missing.list: ", *times, "--leap-seconds", "missing.list"), command=LOW)
        for code, text, *arguments in (
            (2, "--altitude 0: ", "--altitude", 0), (2, "--altitude 600x", "--altitude", "600x"),
            (2, "--node 25: ", "--altitude", 600, "--node", 25), (2, "--node ", "--node", 6),
            (2, "--observer ", "--altitude", 600, "--observer", "spacecraft.oem"),
            (3, "spacecraft.oem: ", "--observer", "spacecraft.oem"), (3, "", "--observer", ""),
        ):
            with self.subTest(arguments):
                self.refuse(code, text, arguments=("predict", "alpha-cen", *arguments, *times))
        self.refuse(3, "beta-cen: ", arguments=("predict", "beta-cen", *times))


if __name__ == "__main__":
    unittest.main()
