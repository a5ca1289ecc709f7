"""toliman report of experiment, track and bench folders, and toliman status --out."""
import json
import math
import shutil
import unittest

import numpy
import schemas
from pages import Reader, Recorder, ReportTest, lines, results
from test_outputs import write_scene

ROW = {"method": "cae", "amplitude_px": 1e-5, "seeds": 3, "found": 3, "period_error": 0.00123, "log10_fap": -831.26,
       "expected_log10_fap": -829.2, "slope": 0.999, "efficiency": 1.008}
TABLE = {"what": "the scene <as it is>", "flux_ratio": 3.12, "crb_px": 1.2e-6, "crb_projected_px": 1.2e-6,
         "crb_marginal_px": 3.4e-6, "threshold_px": 2.9e-7, "pca_threshold_px": 4.9e-6}
CONTROL = {"method": "cae", "series": 50, "frames": 6000, "alarms": 1, "ks_p": 0.37, "sigma_px": 1.24e-6,
           "efficiency": 0.995, "bias_px": 2e-9, "slope": 1}
HEAD = "# comment\ntable,method,amplitude_px,seed,series,period_days,period_error,log10_fap,found,slope,sigma,mean,efficiency\n"


class Experiment(ReportTest):
    def setUp(self):
        super().setUp()
        self.low = {**ROW, "amplitude_px": 1e-6, "log10_fap": -0.4, "found": 1, "efficiency": 0.123}
        other = {**ROW, "method": "pca<white>\udcfe", "efficiency": None, "amplitude_px": 1e-2, "slope": -10667038957.912,
                 "period_error": 5.8e-7}
        tables = [{"table": "real", **TABLE, "ladder": [ROW, other, self.low], "controls": [CONTROL]},
                  {"table": "pointing-0.1", **TABLE, "ladder": [ROW], "controls": [CONTROL]},
                  {"table": "equal", **TABLE, "ladder": [ROW], "controls": []}]
        self.result = {"schema": "toliman-experiment/1", "version": "0.1.0", "scene": "chapter", "frames": 1095,
                       "true_period_days": 365, "amplitude_px": 1e-6, "seeds": 3, "blind": 50,
                       "provenance": {"command": "python3 -m toliman.experiment", "date": "d", "processor": "p"},
                       "methods": [{"method": "cae", "what": "the autoencoder"}], "tables": tables}
        faps = [0.05] * 40 + [0.95] * 10
        rows = [f"real,cae,0,1,{k},365,0,{math.log10(fap)!r},0,1,1,0,nan" for k, fap in enumerate(faps)]
        (self.folder / "experiment.csv").write_text(HEAD + "\n".join(rows) + "\n")
        self.write()

    def write(self):  # \udcfe is a byte that is not UTF-8
        text = json.dumps(self.result, ensure_ascii=False).replace("Infinity", "1e999")
        (self.folder / "experiment.json").write_text(text, errors="surrogateescape")

    def test_page(self):
        self.report(".", "--out", "page")
        page = self.check_page(self.folder / "page", ["detection-real", "blind-real", "detection-equal"])
        self.assertIn("Table real: the scene <as it is>", page.text)
        self.assertEqual(page.row("cae")[:6], ["1.00 × 10⁻⁵", "3 of 3", "0.12", "−831.3", "0.999", "1.008"])
        self.assertEqual(page.row("pca<white>\ufffd")[:5], ["1.00 × 10⁻²", "3 of 3", "0.000058", "−831.3", "−1.07 × 10¹⁰"])
        self.assertIn("caethe autoencoder", page.text)
        self.assertIn("foundlog₁₀ FAP below −3", page.text)
        self.assertIn("1 of 3", page.cells)
        self.assertNotIn("0.123", page.cells)  # not found: an efficiency of noise
        self.assertIn("0.37", page.cells)
        self.assertIn("2.90 × 10⁻⁷ px", page.text)
        self.assertIn("python3 -m toliman.experiment · d · p · libtoliman 0.1.0", page.text)

    def test_controls_left_out(self):
        for word in ("none", "quick", "full"):
            self.result["controls"] = word
            self.write()
            text = Reader(Recorder(self.folder).html()).text
            self.assertIn("50 series", text)
            self.assertEqual(f"--controls {word}" in text, word != "full")

    def test_figures(self):
        page = Recorder(self.folder)
        top, bottom = page.figures["detection-real"].axes
        found = lines(top)
        for name, points in (("cae", [[1e-6, 1e-5], [0.4, 831.26]]), ("pca<white>\ufffd", [[1e-2], [831.26]]),
                             ("at the bound", [[1e-6, 1e-5, 1e-2], [829.2] * 3])):
            numpy.testing.assert_allclose(found[name], points)
        efficiency = next(line for line in bottom.get_lines() if len(line.get_xdata()) == 2 and line.get_marker() == "o")
        numpy.testing.assert_array_equal(efficiency.get_ydata(), [math.nan, 1.008])
        (bars,) = page.figures["blind-real"].axes[0].containers
        self.assertEqual([bar.get_height() for bar in bars], [40, 0, 0, 0, 0, 0, 0, 0, 0, 10])

    def test_refusals(self):
        for key, value, words in (("amplitude_px", 0, "= 0: "), ("expected_log10_fap", math.inf, "= Infinity: "), ("found", None, "= null: ")):
            kept, self.low[key] = self.low[key], value
            self.write()
            self.fail_with(f"experiment.json: tables[0].ladder[2].{key} {words}")
            self.low[key] = kept
        self.write()
        for text, words in ((HEAD + "real,cae\n", "3: "), (HEAD.replace("log10_fap", "x"), "2: "),
                            (HEAD + ",".join(["x"] * 13), "3: amplitude_px = x: ")):
            (self.folder / "experiment.csv").write_text(text)
            self.fail_with(f"experiment.csv:{words}")


class State(ReportTest):
    def track(self, state, days, frames="0:50", **scene):
        write_scene(self.folder / "scene.json", **scene)
        shutil.rmtree(self.folder / "in", ignore_errors=True)
        self.succeed("simulate", "scene.json", "--out", "in", "--session", "s", "--dtype", "u32le", "--frames", frames)
        done = self.run_program("track", "--template", "scene.json", "--state", state, "--mission-days", days, "--dtype", "u32le", "in")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_state(self):
        self.track("state", "60", cadence={"frames": 60, "interval_days": 1}, signal={"period_days": 20, "amplitude_px": 1e-4})
        self.assertEqual(self.succeed("report", "state"), "state/report/report.html\n")
        page = self.check_page(self.folder / "state" / "report", ["instrument", "series", "folded", "periodogram", "residual-periodogram"])
        status = json.loads(self.succeed("status", "state", "--json"))
        for name in ("received", "accepted", "rejected", "expected"):
            self.assertEqual(page.row(name)[0], str(status[name]))
        self.assertEqual(status["accepted"], 50)
        fit = status["fit"]
        decimals = max(0, 1 - int(f"{fit['period_error']:.1e}".split("e")[1]))
        self.assertEqual(page.text.count(f"period {fit['period']:.{decimals}f} ± {fit['period_error']:.{decimals}f} days"), 3)
        # The files are those of status --out, and hold what status prints.
        self.succeed("status", "state", "--out", "files")
        names = ["frames.csv", "periodogram.csv", "residual_periodogram.csv", "result.json", "series.csv"]
        self.assertEqual(sorted(path.name for path in (self.folder / "files").iterdir()), names)
        for name in ("series.csv", "periodogram.csv"):
            self.assertEqual((self.folder / "files" / name).read_text(), (self.folder / "state" / "report" / name).read_text())
        result = json.loads((self.folder / "files" / "result.json").read_text())
        schemas.check(json.dumps(result, indent=1))
        self.assertEqual((result["schema"], result["status"], result["unit_s"]), ("toliman-state/1", status, 86400))
        series = self.succeed("status", "state", "--series")
        self.assertEqual((self.folder / "files" / "series.csv").read_text().partition("\n")[2], series)
        t, y, _ = numpy.array([row.split(",") for row in series.splitlines()[1:]], float).T
        recorded = Recorder(self.folder / "files")
        (axes,) = recorded.figures["series"].axes
        factor = {"separation, 10⁻⁶ px": 1e6, "separation, 10⁻³ px": 1e3}[axes.get_ylabel()]
        numpy.testing.assert_allclose(lines(axes)["each frame"], [t, factor * (y - y.mean())], rtol=1e-9, atol=1e-9)

        def waves(times):
            angle = 2 * numpy.pi * times / fit["period"]
            return numpy.stack([numpy.ones(len(times)), numpy.cos(angle), numpy.sin(angle)], axis=1)

        x, wave = lines(axes)["best sinusoid"]
        best = waves(x) @ numpy.linalg.lstsq(waves(t), y, rcond=None)[0]
        self.assertLess(abs(wave - factor * (best - y.mean())).max(), 1e-3 * abs(wave).max())
        found = lines(recorded.figures["periodogram"].axes[0])
        self.assertEqual(found["grid peak"][0][0], status["frequency"])
        self.assertEqual(found["fit ± error"][0][0], 1 / fit["period"])
        frequency, power = found["all frames"]
        angle = 2 * numpy.pi * frequency[:, None] * t
        design = numpy.stack([numpy.ones_like(angle), numpy.cos(angle), numpy.sin(angle)], axis=2)
        square = [((y - d @ numpy.linalg.lstsq(d, y, rcond=None)[0]) ** 2).sum() for d in design[::97]]
        numpy.testing.assert_allclose(power[::97], 1 - numpy.array(square) / ((y - y.mean()) ** 2).sum(), atol=1e-5)
        # Not by the module alone, which does not read ledgers; and not with a lost setup.
        with self.assertRaisesRegex(results.Failure, r"`toliman report .*state`, or `toliman status"):
            Recorder(self.folder / "state")
        self.refuse(2, '--out: "": ', arguments=("status", "state", "--out", ""))
        self.refuse(2, "--series ", "--out", arguments=("status", "state", "--out", "x", "--series"))
        (self.folder / "files" / "result.json").write_text("notes")
        self.refuse(6, "files/result.json: ", arguments=("status", "state", "--out", "files"))
        (self.folder / "state" / "setup.tlms").unlink()
        self.refuse(5, "state: setup.tlms", "toliman rebuild", arguments=("report", "state"))

    def test_short_periods_and_no_period(self):
        self.track("state", "60", "0:60", cadence={"frames": 60, "interval_days": 1}, signal={"period_days": 2.6, "amplitude_px": 1e-3})
        self.succeed("status", "state", "--out", "x")
        page = Recorder(self.folder / "x")
        self.assertEqual(list(page.figures), ["instrument", "folded", "periodogram", "residual-periodogram"])
        status = json.loads(self.succeed("status", "state", "--json"))
        of_fit, of_grid = (f"{period:.5f}" for period in (status["fit"]["period"], status["period"]))
        self.assertNotEqual(of_fit, of_grid)
        (label,) = [note.get_text() for note in page.figures["periodogram"].axes[0].texts if "grid" in note.get_text()]
        self.assertRegex(label, f"^fit {of_fit} ± 0.000.. days\ngrid peak {of_grid} days$")
        self.assertIn(f"{of_grid} days", page.captions["periodogram"])
        # All at one time: a period, but no errors and no sinusoid. Then no frame at all.
        self.track("other", "10", cadence={"frames": 60, "interval_days": 1e-9})
        self.succeed("status", "other", "--out", "y")
        page = Recorder(self.folder / "y")
        self.assertEqual(list(page.figures), ["instrument", "series", "periodogram"])
        text = Reader(page.html()).text
        self.assertRegex(text, r"period \d+\.\d\d ± – days, log")
        self.assertNotIn("sinusoid", page.captions["series"])
        result = json.loads((self.folder / "y" / "result.json").read_text())
        result["status"].update(dict.fromkeys(("period", "frequency", "power", "log10_fap", "log10_fap_sequential", "fit")))
        (self.folder / "y" / "result.json").write_text(json.dumps(result))
        (self.folder / "y" / "series.csv").write_text("t,y,sigma\n")
        (self.folder / "y" / "frames.csv").unlink()
        page = Recorder(self.folder / "y")
        self.assertEqual(page.figures, {})
        self.assertIn("no period yet", Reader(page.html()).text)

    def test_refusals(self):
        self.track("state", "60", cadence={"frames": 60, "interval_days": 1})
        self.succeed("status", "state", "--out", "x")
        path = self.folder / "x" / "result.json"
        result = json.loads(path.read_text())
        for changes, words in (({"status": 3}, "status = 3: "), ({"unit_s": 0}, "unit_s = 0: "),
                               ({"status": {**result["status"], "rejected_by": []}}, "status.rejected_by = []: "),
                               ({"status": {**result["status"], "accepted": "x"}}, 'status.accepted = "x": ')):
            path.write_text(json.dumps({**result, **changes}))
            self.fail_with(f"x/result.json: {words}", "x")


class Bench(ReportTest):
    def test_bench(self):
        row = {"bench": "a b", "what": "33 nodes", "series": "Chebyshev", "seconds": 0.0481, "spread": 0.001,
               "error": 3.2e-10, "ratio_peer": 19.4, "peer": "numpy", "ratio_roofline": 1.3}
        errors = (2e-16, 3e-16, 4e-16, 5e-16, 6e-16)
        rows = [row, {**row, "what": "48 nodes", "seconds": 0.069, "error": 5e-13, "headline": True, "spread": 0.0003,
                       "error_of": "of peak", "error_at": "14 <nodes>"},
                *({**row, "series": "every wavelength", "error": error} for error in errors),
                {"bench": "fit", "what": "a fit", "seconds": 1, "error": 1.0234, "error_of": "of sigma, rms", "error_largest": 2.871,
                 "error_at": "100 frames"},
                {"bench": "commands", "what": "chapter", "seconds": 4.6, "wall_seconds": 2.3, "memory_bytes": 111661056},
                *({"bench": "growth", "what": f"{size} frames", "series": "status", "seconds": size / 1000, "size": size,
                   "exponent": 1.004} for size in range(1, 8)),
                *({"bench": "a-b", "what": "x", "series": "bf16", "seconds": 1, "bytes": 1e6 + i, "efficiency": 1.01}
                  for i in range(7))]
        (self.folder / "bench").mkdir()
        far = {**row, "what": "far", "headline": True}
        for name, cpu, its in (("a", "A <CPU>", rows), ("b", "A <CPU>", [far]), ("c", "Other", [far])):
            (self.folder / "bench" / (name + ".json")).write_text(json.dumps(
                {"schema": "toliman-bench/1", "machine": {"cpu": cpu, "isa": "avx2", "cores": 2}, "rows": its}))
        (self.folder / "bench" / "other.json").write_text("[")
        page = self.report("bench", "--png", "--pdf")
        self.check_page(self.folder / "bench" / "report", ["bench-a-b", "bench-growth", "bench-a-b-2"], ("svg", "png", "pdf"))
        # Benches of one machine share a table.
        self.assertEqual([page.text.count(text) for text in ("Machine: A <CPU>, avx2.", "Machine: Other, avx2.")], [1, 1])
        self.assertLess(page.text.index("far"), page.text.index("Machine: Other"))
        self.assertEqual(page.row("33 nodes", 8), ["48.1 ms", "2 %", "", "", "3 × 10⁻¹⁰", "numpy", "19.4", "1.30"])
        self.assertEqual(page.row("48 nodes")[1:5], ["< 1 %", "", "", "5 × 10⁻¹³ of peak at 14 <nodes>"])
        self.assertEqual(page.row("a fit")[4], "1.02 of sigma, rms, largest 2.9, at 100 frames")
        self.assertEqual(page.row("chapter")[:4], ["4.6 s", "", "2.3 s", "112 MB"])
        self.assertLess(page.text.index("48 nodes"), page.text.index("33 nodes"))  # the headlines come first
        figures = Recorder(self.folder / "bench").figures
        found = lines(figures["bench-a b"].axes[0])
        numpy.testing.assert_array_equal(found["Chebyshev"], [[3.2e-10, 5e-13], [0.0481, 0.069]])
        numpy.testing.assert_array_equal(found["every wavelength"], [errors, [0.0481] * 5])
        numpy.testing.assert_array_equal(lines(figures["bench-growth"].axes[0])["status: size^1.00"],
                                         [range(1, 8), numpy.arange(1, 8) / 1000])
        numpy.testing.assert_array_equal(lines(figures["bench-a-b"].axes[0])["bf16"][0], 1e6 + numpy.arange(7))


class Budget(ReportTest):
    def parameter(self, name, unit, amount, free=False):
        return {"name": name, "unit": unit, "free": free, "bias_px": None, "curvature_px": None, "earth_amount": amount,
                "tenth_crb_amount": amount and amount / 10, "deviation": None, "correlation": None}

    def setUp(self):
        super().setUp()
        steps = [{"name": "alone", "crb_px": 1.03e-6, "crb_shared_px": 1e-6}, {"name": "<eight>", "crb_px": None, "crb_shared_px": None}]
        rows = [self.parameter("flux_a", "", None, True), self.parameter("shift_x", "px", 0.02, True),
                *(self.parameter(f"zernike_{noll}", "nm", 0.01 * noll) for noll in range(5, 30)),
                self.parameter("temperature_a", "K", 0.19)]
        self.result = {"schema": "toliman-budget/1", "version": "0.2.0", "scene": "mission<1>.json", "frames": 1,
                       "uas_per_px": 375000.0, "earth_px": 6.8e-6, "earth_from": "the amplitude of the signal",
                       "scene_mask": {"crb_px": 1.03e-6, "crb_shared_px": 1e-6, "steps": steps, "parameters": rows,
                                      "correlations": []},
                       "without_mask": None}
        schemas.check(json.dumps(self.result, indent=1))
        (self.folder / "b").mkdir()
        self.write()

    def write(self):
        (self.folder / "b" / "budget.json").write_text(json.dumps(self.result))

    def test_page(self):
        page = self.report("b")
        self.check_page(self.folder / "b" / "report", ["budget-bounds"])
        self.assertIn("Error budget of mission<1>.json", page.text)
        self.assertIn("6.80 × 10⁻⁶ px, 2.55 µas", page.text)
        self.assertEqual(page.row("temperature_a", 2), ["0.19 K", "0.019 K"])
        self.assertEqual(page.row("shift_x", 1), ["0.02 px"])
        self.assertEqual(page.row("flux_a", 1), ["–"])
        self.assertIn("zernike_15", page.cells)  # twelve rows that limit, with both units
        self.assertNotIn("zernike_16", page.cells)
        (axes,) = Recorder(self.folder / "b").figures["budget-bounds"].axes
        numpy.testing.assert_array_equal(lines(axes)["with the mask of the scene"], [[1.03e-6, math.nan], [1, 0]])
        self.assertEqual(list(lines(axes)["an Earth"][0]), [6.8e-6] * 2)

    def test_without_mask(self):
        clear = {**self.result["scene_mask"], "parameters": [self.parameter("temperature_a", "K", 63.0)]}
        self.result["without_mask"] = clear
        self.write()
        page = self.report("b")
        self.assertEqual(page.row("temperature_a", 3), ["0.19 K", "0.019 K", "63 K"])
        self.assertEqual(page.row("zernike_5", 3)[2], "–")

    def test_refusals(self):
        del self.result["scene_mask"]["steps"][1]["crb_px"]
        self.write()
        self.fail_with("scene_mask.steps[1].crb_px: is missing", "b")


if __name__ == "__main__":
    unittest.main()
