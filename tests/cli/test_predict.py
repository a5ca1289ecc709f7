"""toliman predict: the numbers of the library, times in every scale, and its refusals."""
import json
import logging
import os
import pathlib
import sys
import unittest

import numpy
from program import PROGRAM, ROOT, ProgramTest, leap_seconds

os.environ.setdefault("TOLIMAN_LIBRARY", str(pathlib.Path(PROGRAM).parents[1] / "lib" / "libtoliman.so"))
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402

SYSTEM = ROOT / "examples" / "systems" / "alpha-cen.json"
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
        known = "dates of UTC up to 2031-01-01 were converted, but leap seconds are known only before "
        for more, text in (((), known), (("--leap-seconds", "old.list"), known + "2026-12-26: --leap-seconds FILE reads"),
                           (("--leap-seconds", "new.list"), ""), (("--scale", "tai"), "")):
            done = self.run_program(*LOW, "--times", "2030-01-01,2031-01-01", *more)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (0, 1 if text else 0), done.stderr)
            self.assertIn(text, done.stderr)
        rows = ["t_utc,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s"]
        for minute in range(12):
            c, s = numpy.cos(0.0646806 * minute), numpy.sin(0.0646806 * minute)
            rows.append(f"2031-001 00:{minute:02d}:00,{7000 * c},{7000 * s},0,{-7.54607 * s},{7.54607 * c},0")
        (self.folder / "far.csv").write_text("\n".join(rows))
        done = self.run_program("predict", "alpha-cen", "--observer", "far.csv", "--times", "2031-01-01T00:05:40",
                                "--scale", "tai")
        self.assertIn(known, done.stderr)
        (self.folder / "bad.list").write_text(leap_seconds().replace("#$\t", "#$\t1"))
        self.refuse(3, "bad.list: its hash (#h) is not that of its rows",
                    arguments=(*LOW, "--times", "2027-01-01", "--leap-seconds", "bad.list"))

    def test_times_of_a_file(self):
        (self.folder / "times.csv").write_text("date,y\n# a comment\n\n2027-01-01T00:00:00.25,5\n  61500 7\n")
        expected = self.succeed(*LOW, "--times", "2027-01-01T00:00:00.25,61500")
        self.assertEqual(self.succeed(*LOW, "--times-file", "times.csv"), expected)
        (self.folder / "marked.csv").write_bytes(b"\xef\xbb\xbf2027-01-01T00:00:00.25\n61500\n")  # by some editors
        self.assertEqual(self.succeed(*LOW, "--times-file", "marked.csv"), expected)
        self.assertEqual(self.succeed(*LOW, "--times-file", "-", input="2027-01-01T00:00:00.25\n61500"), expected)
        plain = self.predictions(*LOW, "--times", "2027-01-01T00:00:00.25,61500")["predictions"]
        for form in ("2027-01-01 00:00:00.25", "2027-001T00:00:00.25Z", "2027-001 00:00:00.25+00:00"):
            (self.folder / "times.csv").write_text(f"{form} 5\n61500 7\n")
            for times in (("--times-file", "times.csv"), ("--times", form + ",61500")):
                found = self.predictions(*LOW, *times)["predictions"]
                self.assertEqual([row["tai_ns"] for row in found], [row["tai_ns"] for row in plain])
        self.refuse(2, "is +02:00 from UTC", arguments=(*LOW, "--times", "2027-01-01T00:00:00+02:00"))

    def test_fractions_of_seconds(self):
        _, table = self.columns(*LOW, "--from", "2027-01-01T00:00:00.5", "--to", "2027-01-01T00:00:01", "--every",
                                0.125 / 86400)
        self.assertEqual(table["time"], [f"2027-01-01T00:00:0{text}" for text in ("0.5", "0.625", "0.75", "0.875", "1")])

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
        start, lines = toliman.parse_time("2027-01-01"), ["t_tai_ns,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s"]
        for i in range(12):
            c, s = numpy.cos(0.00107801 * 60 * i), numpy.sin(0.00107801 * 60 * i)
            lines.append(f"{start + i * 60 * 10**9},{7000 * c:.6f},{7000 * s:.6f},0,{-7.54607 * s:.9f},{7.54607 * c:.9f},0")
        (self.folder / "spacecraft.csv").write_text("\n".join(lines) + "\n")
        arguments = ("predict", "alpha-cen", "--observer", "spacecraft.csv", "--times")
        found = self.predictions(*arguments, "2027-01-01T00:05:00")
        self.assertEqual((found["observer"], found["observer_file"], found["altitude_km"], found["node_hours"]),
                         ("file", "spacecraft.csv", None, None))
        seen = toliman.Sky("alpha-cen", self.folder / "spacecraft.csv").predict(start + 300 * 10**9)
        self.assertEqual(found["predictions"][0]["separation_arcsec"], seen["separation_arcsec"])
        self.assertIn("# observer  spacecraft.csv: altitude 622 to 622 km, inclination 0.0 deg, ascending node at ", self.succeed(*arguments, "2027-01-01T00:05:00"))
        done = self.run_program(*arguments, "2027-01-02")
        self.assertIn("spacecraft.csv", done.stderr)
        self.assertEqual((done.returncode, done.stdout), (2, ""))

    def test_centre_of_the_earth(self):
        done = self.run_program("predict", "alpha-cen", "--times", "2027-01-01")
        self.assertEqual(done.returncode, 0)
        self.assertIn("# observer  centre of the Earth\n", done.stdout)
        self.assertIn("warning: no observer given: predictions are for the Earth's centre", done.stderr)
        self.succeed("predict", "alpha-cen", "--times", "2027-01-01", "--without", "spacecraft_aberration")

    def test_refusals(self):
        (self.folder / "bad.csv").write_text("2027-01-01\nnoon\n")
        (self.folder / "empty.csv").write_text("# nothing\n")
        must = "must be a date (2027-07-02T12:00:00), a Modified Julian Day or a Julian Day"
        for code, text, arguments in (
            (2, "give times: --times, --times-file, or --from and --to", ()),
            (2, f"--times 2027.5: {must}", ("--times", "2027.5")),
            (2, "--times noon: must be YYYY-MM-DD or YYYY-DDD, alone or with Thh:mm:ss", ("--times", "noon")),
            (2, "--times 1850-01-01: must be from 1972-01-01", ("--times", "1850-01-01")),
            (2, "--from requires --to", ("--from", "2027-01-01")),
            (2, "--to 2027-01-01: must not be before --from 2027-02-01", ("--from", "2027-02-01", "--to", "2027-01-01")),
            (2, "--every 0: must be at least 1 ns, in days", ("--from", "2027-01-01", "--to", "2027-01-02", "--every", 0)),
            (2, "--every 1e-30: must be at least 1 ns, in days",
             ("--from", "2027-01-01", "--to", "2027-01-01", "--every", 1e-30)),
            (2, "--every 1e-09: more than 1000000 times",
             ("--from", "2027-01-01", "--to", "2027-01-02", "--every", 1e-9)),
            (2, "--times excludes --times-file", ("--times", "2027-01-01", "--times-file", "bad.csv")),
            (3, "bad.csv: line 2: noon: must be YYYY-MM-DD", ("--times-file", "bad.csv")),
            (3, "empty.csv: contains no times", ("--times-file", "empty.csv")),
            (3, "missing.csv: No such file or directory", ("--times-file", "missing.csv")),
            (2, "--without aberration: must be one of earth_aberration, ",
             ("--times", "2027-01-01", "--without", "aberration")),
            (2, "--scale local: must be one of utc, tai, tt, tdb, gps", ("--times", "2027-01-01", "--scale", "local")),
            (3, "missing.list: No such file or directory", ("--times", "2027-01-01", "--leap-seconds", "missing.list")),
        ):
            with self.subTest(text):
                self.refuse(code, text, arguments=(*LOW, *arguments))
        for code, text, arguments in (
            (2, "--altitude 0: must be in [200, 2000] km", ("--altitude", 0)),
            (2, "--altitude 600x", ("--altitude", "600x")),
            (2, "--node 25: must be in [0, 24] h", ("--altitude", 600, "--node", 25)),
            (2, "--node requires --altitude", ("--node", 6)),
            (2, "excludes --", ("--altitude", 600, "--observer", "spacecraft.oem")),
            (3, "spacecraft.oem: No such file or directory", ("--observer", "spacecraft.oem")),
            (3, "No such file or directory", ("--observer", "")),
        ):
            with self.subTest(text):
                self.refuse(code, text,
                            arguments=("predict", "alpha-cen", *arguments, "--times", "2027-01-01"))
        self.refuse(3, "beta-cen: No such file or directory", arguments=("predict", "beta-cen", "--times", "2027-01-01"))


if __name__ == "__main__":
    unittest.main()
