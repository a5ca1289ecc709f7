"""toliman period --out, and toliman report of its folder."""
import json
import os
import unittest

import numpy
from pages import Reader, Recorder, ReportTest, lines, results
from test_period_nuisance import DF, F0, GRID, NF, Nuisance, Reference, chebyshev

FILES = ["periodogram.csv", "residual_periodogram.csv", "result.json", "series.csv"]


class Folder(Nuisance, ReportTest):
    def table(self, name, folder="out"):
        return results.Table(self.folder / folder / name)

    def test_files(self):
        """Against least squares by numpy."""
        t, y, sigma = self.trending()
        found = self.period("s.csv", *GRID, "--trend", 3, "--out", "out", "--power", "power.npy")
        self.assertEqual(sorted(os.listdir(self.folder / "out")), FILES)
        written = json.loads((self.folder / "out" / "result.json").read_text())
        self.assertEqual({key: written[key] for key in found}, found)
        self.assertEqual(sorted(set(written) - set(found)), ["power_at_fap_1e-3", "provenance", "version"])
        self.assertTrue(0 < written["power_at_fap_1e-3"] < 1)
        frequency = F0 + DF * numpy.arange(NF)
        power = self.table("periodogram.csv")
        numpy.testing.assert_array_equal(power.numbers("power"), numpy.load(self.folder / "power.npy"))
        numpy.testing.assert_allclose(power.numbers("frequency"), frequency, rtol=1e-15)
        reference = Reference(t, y, sigma, chebyshev(t, 3))
        best = reference.at(found["peak"]["frequency"])[0]
        series = self.table("series.csv")
        self.assertEqual(series.names, ["t", "y", "sigma", "nuisance"])
        for name, values in (("t", t), ("y", y), ("sigma", sigma)):
            numpy.testing.assert_array_equal(series.numbers(name), values)
        model = numpy.column_stack([numpy.ones_like(t), chebyshev(t, 3)]) @ best[2:]
        numpy.testing.assert_allclose(series.numbers("nuisance"), model, rtol=0, atol=1e-7)
        angle = 2 * numpy.pi * found["peak"]["frequency"] * (t - t[0])
        rest = y - numpy.column_stack([numpy.cos(angle), numpy.sin(angle)]) @ best[:2]
        numpy.testing.assert_allclose(self.table("residual_periodogram.csv").numbers("power"),
                                      Reference(t, rest, sigma, chebyshev(t, 3)).powers(), rtol=0, atol=1e-7)

    def test_all_or_none(self):
        self.trending()
        (self.folder / "out").mkdir()
        (self.folder / "out" / "series.csv").write_text("my notes\n")
        self.refuse(6, "out/series.csv: ", arguments=("period", "s.csv", "--out", "out"))
        self.assertEqual(os.listdir(self.folder / "out"), ["series.csv"])
        (self.folder / "out" / "series.csv").unlink()
        (self.folder / "few.csv").write_text("1,2\n2,3\n")
        self.refuse(3, "few.csv: ", arguments=("period", "few.csv", "--out", "new"))
        self.assertFalse((self.folder / "new").exists())
        for _ in range(2):  # own files are replaced
            self.succeed("period", "s.csv", *GRID, "--trend", 3, "--out", "out")
        self.assertEqual(sorted(os.listdir(self.folder / "out")), FILES)
        self.refuse(2, "out/series.csv: ", arguments=("period", "out/series.csv", *GRID, "--out", "out"))
        for other in (("--from-state", "x"), ("--follow",)):
            self.refuse(2, "excludes", "--out", arguments=("period", "s.csv", "--out", "new", *other))

    def test_page(self):
        t, y, _ = self.trending()
        self.succeed("period", "s.csv", *GRID, "--trend", 3, "--out", "drift.period")
        self.report("drift.period")
        page = self.check_page(self.folder / "drift.period" / "report", ["nuisance", "periodogram", "residual-periodogram"])
        result = json.loads((self.folder / "drift.period" / "result.json").read_text())
        peak, functions = result["peak"], result["functions"]["coefficients"]
        self.assertIn("toliman period: drift.period", page.text)
        self.assertRegex(page.text, f"200 samples: period {peak['period']:.2f} ± {peak['period_error']:.2f} units of t, ")
        self.assertNotIn("not a significant", page.text)
        self.assertEqual(page.row("T1")[0].replace("−", "-"), f"{functions[1]['value']:.6g}")
        figures = Recorder(self.folder / "drift.period").figures
        series = self.table("series.csv", "drift.period")
        nuisance = series.numbers("nuisance")
        top, bottom = figures["nuisance"].axes
        numpy.testing.assert_allclose(lines(top)["each sample"], [t, y - nuisance.mean()], rtol=1e-12, atol=1e-12)
        numpy.testing.assert_allclose(lines(top)["mean and nuisance functions"][1], nuisance - nuisance.mean(), atol=1e-12)
        self.assertLess(numpy.ptp(lines(bottom)["each sample less these"][1]), numpy.ptp(y) / 4)
        wave = lines(bottom)["best sinusoid"][1]
        self.assertAlmostEqual(wave.max(), peak["amplitude"], delta=1e-3)
        self.assertAlmostEqual(wave.mean(), 0, delta=0.1)
        for name, file, label in (("periodogram", "periodogram.csv", "series"),
                                  ("residual-periodogram", "residual_periodogram.csv", "without the sinusoid")):
            (axes,) = figures[name].axes
            power = self.table(file, "drift.period").numbers("power")
            numpy.testing.assert_array_equal(lines(axes)[label][1], power)
            self.assertEqual(lines(axes)["FAP 0.001"][1][0], result["power_at_fap_1e-3"])

    def test_other_models(self):
        """The mean alone, without sigmas; correlated noise; and damaged results."""
        t, y, _ = self.trending()
        self.write(t, y)
        found = self.period("s.csv", *GRID, "--out", "out")
        series = self.table("series.csv")
        self.assertEqual(series.names, ["t", "y", "nuisance"])
        numpy.testing.assert_allclose(series.numbers("nuisance"), found["peak"]["offset"], rtol=1e-12)
        result = json.loads((self.folder / "out" / "result.json").read_text())
        text = Reader(Recorder(self.folder / "out").html()).text
        self.assertEqual(("half the time span" in text, "Coefficients" in text), (True, False))
        found = self.period("s.csv", *GRID, "--trend", 2, "--noise", "ar1", "--out", "out")
        coefficients = [one["value"] for one in found["functions"]["coefficients"]]
        model = numpy.column_stack([numpy.ones_like(t), chebyshev(t, 2)]) @ coefficients
        numpy.testing.assert_allclose(self.table("series.csv").numbers("nuisance"), model, rtol=0, atol=1e-9)
        self.assertIn("(baluev, noise ar1)", Reader(Recorder(self.folder / "out").html()).text)
        for changes, words in (({"peak": 3}, "peak = 3: "), ({"n": "x"}, 'n = "x": '),
                               ({"schema": "toliman-period/9"}, 'schema = "toliman-period/9": ')):
            (self.folder / "out" / "result.json").write_text(json.dumps({**result, **changes}))
            self.fail_with(f"out/result.json: {words}", "out")


if __name__ == "__main__":
    unittest.main()
