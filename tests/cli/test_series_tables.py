"""Tables of archives and journals in toliman period, planet and refit: files, pipes and growing input; units, missing
values and instruments. tests/unit/test_series_tables.c has the formats."""
import json
import math
import os
import random
import threading
import unittest

from program import ProgramTest

PERIOD = 17.3
GRID = ("--f0", 0.03, "--df", 2e-4, "--nf", 200)
CHANCE = random.Random(7)
TIMES = [round(8.1 * k + 1.7 * math.sin(k * k), 3) for k in range(50)]
ROWS = [(t, round(50 * math.sin(2 * math.pi * t / PERIOD) + CHANCE.gauss(0, 1.2), 4)) for t in TIMES]


def table(head, row="{t},{y},{s}", offset=2459000.0, time=1.0, value=1.0, sigma=1.0, every=""):
    lines = [row.format(t=f"{(offset + t) * time:.6f}", y=f"{y * value:.7f}", s=f"{sigma * (1 + k % 3 / 4):.7f}", k=k % 2)
             for k, (t, y) in enumerate(ROWS)]
    return head + "".join(line + "\n" for line in lines) + every


class Tables(ProgramTest):
    def found(self, text, *options, name="s.txt", warning=""):
        (self.folder / name).write_text(text)
        done = self.run_program("period", name, *GRID, "--json", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(warning, done.stderr)
        self.assertEqual(done.stderr == "", warning == "", done.stderr)
        return json.loads(done.stdout)

    def test_the_same_result(self):
        expected = self.found(table("t,y,sigma\n"))["peak"]
        self.assertAlmostEqual(expected["period"], PERIOD, delta=0.02)
        for text, *options in (
                (table("# BJD RV e_RV\n", "{t} {y} {s}"), "--time-format", "days"),
                (table("bjd;rv;e_rv\nd;m/s;m/s\n", "{t};{y};{s}"), "--time-format", "days"),
                (table("A,B,C\n", "{s},{t},{y}"), "--columns", "2,3,1"),
                (table("# %ECSV 1.0\n# ---\n# datatype:\n# - {name: y, unit: m / s, datatype: float64}\n"
                       "# - {name: sigma, unit: km / s, datatype: float64}\ny t sigma\n", "{y} {t} {s}", sigma=1e-3),),
                (json.dumps([{"t": float(t) + 2459000, "y": y, "sigma": 1 + k % 3 / 4}
                             for k, (t, y) in enumerate(ROWS)]),)):
            with self.subTest(text=text[:40]):
                peak = self.found(text, *options)["peak"]
                for key in ("period", "power", "amplitude", "log10_fap"):
                    self.assertAlmostEqual(peak[key], expected[key], delta=1e-6 * abs(expected[key]))

    def test_warnings(self):
        """tests/unit/test_series_tables.c has the kinds; here each is told with the name of the file or column."""
        for head, row, end, warning in (
                ("t,y,sigma\n", "{t},{y},{s}", "1,,1\n2,nan,1\n", "s.txt: 2 of 52 rows "),
                ("", "{t} {y} {s} HARPS", "", "columns 1, 2 and 3 of 4 "),
                ("t,y,sigma,tel\n", "{t},{y},{s},{k}", "", "column tel "),
                ("t,y,sigma_of_y\n", "{t},{y},{s}", "", "column sigma_of_y ")):
            self.found(table(head, row, every=end), warning=warning)
        self.found(table("jd,y,sigma\n", offset=59000), warning="jd = 59000.000000: ")
        hours = self.found(table("t (h),y,sigma\n", time=24), warning="s.txt: ")
        self.assertAlmostEqual(hours["peak"]["period"], PERIOD, delta=0.02)

    def test_pipes_and_growing_input(self):
        """The same table from a file, standard input and a named pipe, and line by line."""
        text = table("# Title\nBJD_TDB\tRV\terr\n----\t---\t---\n", "{t}\t{y}\t{s}", every="2459999\t--\t1\n")
        warning = "1 of 51 rows "
        expected = self.found(text, warning=warning)
        self.assertEqual(expected["time_scale"], "TDB")
        done = self.run_program("period", "-", *GRID, "--json", input=text)
        self.assertIn("standard input: " + warning, done.stderr)
        self.assertEqual(json.loads(done.stdout), expected)
        os.mkfifo(self.folder / "pipe")
        writer = threading.Thread(target=lambda: (self.folder / "pipe").write_text(text))
        writer.start()
        self.assertEqual(json.loads(self.run_program("period", "pipe", *GRID, "--json").stdout), expected)
        writer.join()
        done = self.run_program("period", "s.txt", *GRID, "--follow")
        last = json.loads(done.stdout.splitlines()[-1])
        self.assertEqual((last["n"], last["time_scale"]), (50, "TDB"))
        self.assertIn("s.txt: 1 rows ", done.stderr)

    # promise: missing-marks-are-no-values
    def test_marks_of_missing_values(self):
        end = "2459990,-9999,1\n2459991,-9999,1\n"
        (self.folder / "s.txt").write_text(table("t,y,sigma\n", every=end))
        self.refuse(3, "s.txt: y = -9999 on lines 52, 53", arguments=("period", "s.txt"))
        done = self.run_program("period", "s.txt", *GRID, "--follow")
        self.assertIn("y = -9999 on line 52: ", done.stderr)

    def test_units(self):
        planet = ("--period-min", 10, "--period-max", 30, "--json", "--star-masses", 1)
        (self.folder / "s.txt").write_text(table("bjd,rv (km/s),err (m/s)\n", value=1e-3))
        (self.folder / "plain.txt").write_text(table("bjd,rv,err\n"))
        with_unit = json.loads(self.succeed("planet", "s.txt", *planet))
        by_option = json.loads(self.succeed("planet", "plain.txt", "--unit", "m/s", *planet))
        amplitudes = [result["candidates"][0]["amplitude"] for result in (with_unit, by_option)]
        masses = [result["candidates"][0]["mass_a_earth"] for result in (with_unit, by_option)]
        for one, other in zip([1e3 * value for value in amplitudes[0]] + masses[0], amplitudes[1] + masses[1]):
            self.assertAlmostEqual(one, other, delta=0.03 * other)
        self.refuse(2, "--unit m/s: s.txt ", arguments=("planet", "s.txt", "--unit", "m/s", *planet))
        for unit, code, why in (("km/s", 3, "s.txt: y is in km/s: "), ("px", 2, "--plate-scale: ")):
            (self.folder / "s.txt").write_text(table(f"bjd,separation ({unit}),err\n"))
            done = self.run_program("period", "s.txt", "--system", "alpha-cen")
            self.assertEqual((done.returncode, why in done.stderr), (code, True), done.stderr)
        (self.folder / "s.txt").write_text(table("bjd,rv (m/s),err (mas)\n"))
        self.refuse(3, "s.txt:2: err (mas): ", arguments=("period", "s.txt"))

    def test_other_times_have_the_scale_of_the_name(self):
        (self.folder / "s.txt").write_text(table("bjd_tdb,rv,err\n"))
        (self.folder / "n.csv").write_text("t,x\n" + "".join(f"{2459000 + t:.6f},{k % 5}\n" for k, t in enumerate(TIMES)))
        out = self.succeed("period", "s.txt", *GRID, "--nuisance-file", "n.csv", "--trend", 1, "--span", "58999,59500")
        self.assertIn("Modified Julian Day in TDB", out)

    def test_choices(self):
        for head, why in (("bjd,rv,vrad\n", "rv and vrad"), ("a,b,c\n", "column t")):
            (self.folder / "s.txt").write_text(table(head))
            self.refuse(3, "s.txt:1: ", why, "--columns", arguments=("period", "s.txt"))


if __name__ == "__main__":
    unittest.main()
