"""Tests `planet` and `period` with a column of instruments, and `planet` with velocities and separations together."""
import json
import math
import sys

import numpy

from program import ROOT, ProgramTest, unittest

sys.path.append(str(ROOT / "tests" / "support"))
import planet_model as model  # noqa: E402


class Programs(ProgramTest):
    def setUp(self):
        super().setUp()
        random = numpy.random.default_rng(4)
        t = numpy.sort(random.uniform(0, 900, 90)) + 60000
        self.which = random.integers(0, 3, 90)
        offsets, jitters = numpy.array([0, 9000, -40.0]), numpy.array([0.2, 4, 1])
        y = offsets[self.which] + random.normal(size=90) * numpy.hypot(1, jitters[self.which])
        y += 6 * numpy.cos(2 * math.pi * t / 83)
        self.names = ["HARPS", "UVES", "CES"]
        self.write("rv.csv", "mjd,rv,e_rv,tel", (f"{a:.6f},{b:.4f},1,{self.names[k]}" for a, b, k in zip(t, y, self.which)))

    def write(self, name, head, rows):
        (self.folder / name).write_text("\n".join([head, *rows]) + "\n")

    def json_of(self, *arguments):
        return json.loads(self.succeed(*arguments, "--json"))

    def test_period_fits_offsets_and_adds_jitters(self):
        self.assertIn("column tel ", self.run_program("period", "rv.csv", "--f0", 0.01, "--df", 1e-3, "--nf", 9, "--json").stderr)
        result = self.json_of("period", "rv.csv", "--instrument", "tel")
        self.assertAlmostEqual(result["peak"]["period"], 83, delta=1)
        self.assertEqual([one["name"] for one in result["instruments"]], list(dict.fromkeys(self.names[k] for k in self.which)))
        jitters = {one["name"]: one["jitter"] for one in result["instruments"]}
        self.assertTrue(jitters["UVES"][0] / 1.3 < 4 < 1.3 * jitters["UVES"][2], jitters)

    def test_planet_of_several_instruments(self):
        result = self.json_of("planet", "rv.csv", "--instrument", "tel", "--unit", "m/s", "--star-masses", "1",
                              "--samples", "100", "--out", "out")
        planet = result["candidates"][0]
        self.assertEqual((planet["verdict"], planet["star"]), ("planet", None))
        self.assertAlmostEqual(planet["period"][1], 83, delta=1)
        self.succeed("report", "out")
        self.assertIn("UVES", (self.folder / "out" / "report" / "report.html").read_text())

    def test_bad_columns_of_instruments(self):
        self.write("gap.csv", "t,y,sigma,tel", ["1,2,1,a", "2,3,1,"])
        for code, message, *arguments in ((3, "telescope", "rv.csv", "--instrument", "telescope"), (3, "gap.csv", "gap.csv", "--instrument", "tel"),
                                          (2, "--instrument", "rv.csv", "--instrument", "tel", "--follow", "--f0", "1", "--df", "1", "--nf", "9")):
            with self.subTest(arguments):
                done = self.run_program("period", *arguments)
                self.assertEqual((done.returncode, message in done.stderr), (code, True), done.stderr)

    def test_velocities_tell_the_star(self):
        random, axis, motion = numpy.random.default_rng(6), 1e-4, model.AU / model.DAY / 0.75
        times = [numpy.sort(random.uniform(60000, 61000, count)) for count in (120, 90, 90)]

        def place(t):
            return model.places(2 * math.pi * (t - 60040) / 300, 0.3)
        rows = zip(times[0], -axis * place(times[0])[0] * 1e6 + 0.3 * random.normal(size=120))
        self.write("s.csv", "mjd,y,sigma", (f"{t:.6f},{y:.6f},0.3" for t, y in rows))
        for name, t, size in (("a.csv", times[1], 0), ("b.csv", times[2], axis * motion)):
            v = 20 + 1e-3 * (t - 60000) + random.normal(size=90) - size * (place(t + 0.5)[1] - place(t - 0.5)[1])
            self.write(name, "mjd,rv (km/s),err (m/s)", (f"{one:.6f},{value / 1000:.7f},1" for one, value in zip(t, v)))
        given = ["planet", "s.csv", "--unit", "uas", "--parallax", "750", "--star-masses", "1.08,0.91", "--samples", "500"]
        result = self.json_of(*given, "--velocities", "a.csv", "--velocities-b", "b.csv", "--out", "both")
        planet = result["candidates"][0]
        self.assertEqual((planet["star"], result["velocities"], planet["mass_a_earth"]), ("B", 180, None))
        self.assertLess(planet["log10_star"], -20)
        self.assertEqual([one["source"] for one in result["instruments"]], [0, 1, 2])
        for arguments, code, message in ((given[:2] + ["--velocities", "a.csv"], 2, "--velocities: "),
                                         (given + ["--velocities", "none.csv"], 3, "none.csv"),
                                         (["planet", "rv.csv", "--unit", "m/s", "--velocities", "a.csv"], 2, "--velocities: ")):
            with self.subTest(arguments):
                done = self.run_program(*arguments)
                self.assertEqual((done.returncode, message in done.stderr), (code, True), done.stderr)


if __name__ == "__main__":
    unittest.main()
