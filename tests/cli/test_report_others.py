"""toliman report of experiment, track and bench folders."""
import json
import re
import unittest

import numpy
from figures import plots_of
from test_outputs import write_scene
from test_report import ReportTest


class Others(ReportTest):
    def test_experiment(self):
        rung = {"method": "cae", "amplitude_px": 1e-5, "seeds": 3, "found": 3, "period_error": 0.00123,
                "log10_fap": -831.26, "expected_log10_fap": -829.2, "slope": 0.999, "efficiency": 1.008}
        low = {**rung, "amplitude_px": 1e-6, "log10_fap": -0.4, "found": 1, "efficiency": 0.123}
        other = {**rung, "method": "pca<white>\udcfe", "efficiency": None, "amplitude_px": 1e-2, "slope": -10667038957.912,
                 "period_error": 5.8e-7}
        control = {"method": "cae", "series": 50, "frames": 6000, "alarms": 1, "ks_p": 0.37, "sigma_px": 1.24e-6,
                   "efficiency": 0.995, "bias_px": 2e-9, "slope": 1}
        facts = {"what": "the scene <as it is>", "flux_ratio": 3.12, "crb_px": 1.2e-6, "crb_projected_px": 1.2e-6,
                 "crb_marginal_px": 3.4e-6, "threshold_px": 2.9e-7, "pca_threshold_px": 4.9e-6}
        tables = [{"table": "real", **facts, "ladder": [rung, other, low], "controls": [control]},
                  {"table": "pointing-0.1", **facts, "ladder": [rung], "controls": [control]},
                  {"table": "real", **facts, "ladder": [rung], "controls": []}]
        result = {"schema": "toliman-experiment/1", "version": "0.1.0", "scene": "chapter", "frames": 1095,
                  "true_period_days": 365, "amplitude_px": 1e-6, "seeds": 3, "blind": 50,
                  "grid": {"f0": 1, "df": 1, "nf": 9}, "tables": tables}
        folder = self.folder / "table"
        folder.mkdir()

        def write_result():  # \udcfe is a byte that is no UTF-8
            text = json.dumps(result, ensure_ascii=False).replace("Infinity", "1e999")
            (folder / "experiment.json").write_text(text, errors="surrogateescape")

        write_result()
        heights = [40, 0, 1, 2, 3, 0, 0, 1, 0, 3]  # of 50 FAPs, by tenths
        faps = [0.1 * k + 0.05 for k, height in enumerate(heights) for _ in range(height)]
        rows = [f"real,cae,0,1,{k},365,0,{numpy.log10(fap)!r},0,1,1,0,1" for k, fap in enumerate(faps)]
        head = ("# remark\ntable,method,amplitude_px,seed,series,period_days,period_error,log10_fap,found,slope,sigma,mean,"
                "efficiency\n")
        (folder / "experiment.csv").write_text(head + "\n".join(rows) + "\n")
        self.assertEqual(self.succeed("report", "table"), "table/report/report.html\n")
        page = self.check_page(folder / "report", {
            "ladder-real": ["amplitude of the signal, px", "FAP (no unit)", "efficiency (no unit)", "pca<white>\ufffd"],
            "blind-real": ["FAP of the highest peak (no unit)", "number of series"], "ladder-real-2": [], "blind-real-2": []})
        self.assertIn("Table real: the scene <as it is>", page.text)
        self.assertEqual(page.row("cae")[:5], ["1.00 \u00d7 10-5", "3 of 3", "0.12", "-831.3", "0.999"])
        self.assertEqual(page.row("pca<white>\ufffd")[:5], ["1.00 \u00d7 10-2", "3 of 3", "0.000058", "-831.3", "-1.07 \u00d7 1010"])
        self.assertIn("caethe autoencoder, trained once for each seed of weights", page.text)  # its line of --help
        self.assertIn("foundlog10 FAP below -3", page.text)
        self.assertIn("1 of 3", page.cells)
        self.assertNotIn("0.123", page.cells)  # not found: an efficiency of noise
        self.assertIn("0.37", page.cells)
        self.assertIn("2.90 \u00d7 10-7 px", page.text)
        top, bottom = plots_of(folder / "report/figures/ladder-real.svg")
        for plot, name, log, points in ((top, "cae", "xy", [[1e-6, 0.4], [1e-5, 831.26]]), (top, "pca<white>\ufffd", "xy", [[1e-2, 831.26]]),
                                        (top, "at the bound", "xy", [[1e-6, 829.2], [1e-5, 829.2], [1e-2, 829.2]]),
                                        (bottom, "gnuplot_plot_1b", "x", [[1e-5, 1.008]])):
            at = plot.line(name, log) if name == "at the bound" else plot.marks(name, log)
            self.assertLess(abs(at / points - 1).max(), 0.005, name)
        self.assertLess(abs(top.line("found: FAP 0.001", "xy")[:, 1] - 3).max(), 0.01)
        self.assertLess(abs(top.line(None, "xy")[:, 0] / 2.9e-7 - 1).max(), 0.005)  # the threshold
        (blind,) = plots_of(folder / "report/figures/blind-real.svg")
        bars = [[0.1 * k + 0.05, height] for k, height in enumerate(heights) if height]
        self.assertLess(abs(blind.bars("cae") - bars).max(), 0.05)
        for key, value, words in (("amplitude_px", 0, "must be above 0"), ("expected_log10_fap", numpy.inf, "must be a finite number")):
            kept, low[key] = low[key], value
            write_result()
            self.refuse(3, f"table/experiment.json: {key}: {words}", arguments=("report", "table"))
            low[key] = kept
        write_result()
        (folder / "experiment.csv").write_text(head + "real,cae\n")
        self.refuse(3, "table/experiment.csv:3: has 2 columns, the header 13", arguments=("report", "table"))
        (folder / "experiment.csv").write_text(head.replace("log10_fap", "x"))
        self.refuse(3, "table/experiment.csv:2: has no column log10_fap", arguments=("report", "table"))

    def test_many_methods_look_different(self):
        names = [f"method {i}" for i in range(12)]
        rung = {"amplitude_px": 1e-5, "seeds": 1, "found": 1, "period_error": 0.001, "log10_fap": -8, "expected_log10_fap": -8,
                "slope": 1, "efficiency": 1}
        table = {"table": "real", "what": "all", "flux_ratio": 1, "crb_px": 1, "crb_projected_px": 1, "crb_marginal_px": 1,
                 "threshold_px": 1e-6, "pca_threshold_px": 1, "controls": [],
                 "ladder": [{"method": name, **rung} for name in names]}
        result = {"schema": "toliman-experiment/1", "version": "0.1.0", "scene": "x", "frames": 9, "true_period_days": 3,
                  "seeds": 1, "blind": 0, "tables": [table]}
        (self.folder / "experiment.json").write_text(json.dumps(result))
        (self.folder / "experiment.csv").write_text("table,method,amplitude_px,log10_fap\n")
        self.succeed("report", ".", "--out", "page")
        svg = (self.folder / "page" / "figures" / "ladder-real.svg").read_text()
        looks = list(dict.fromkeys(re.findall(r"<use xlink:href='#(gpPt\d+)'[^>]*color='([^']*)'", svg)))
        self.assertEqual(len(looks), 12)
        self.assertEqual(len({colour for _, colour in looks[:9]}), 9)

    def test_state(self):
        write_scene(self.folder / "scene.json", cadence={"frames": 60, "interval_days": 20})
        self.succeed("simulate", "scene.json", "--out", "in", "--session", "s", "--dtype", "u32le", "--frames", "0:50")
        done = self.run_program("track", "--template", "scene.json", "--state", "state", "--mission-days", "1200",
                                "--dtype", "u32le", "in")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.succeed("report", "state", "--out", "page")
        page = self.check_page(self.folder / "page", {
            "series": ["time, days", "separation, 10", "px", "best sinusoid"],
            "periodogram": ["frequency, 1/day", "power (no unit)", "FAP 0.001"]})
        status = json.loads(self.succeed("status", "state", "--json"))
        for name in ("received", "accepted", "rejected", "expected"):
            self.assertEqual(page.row(name)[0], str(status[name]))
        self.assertEqual(status["accepted"], 50)
        fit = status["fit"]
        decimals = max(2, 1 - int(f"{fit['period_error']:.1e}".split("e")[1]))
        self.assertEqual(page.text.count(f"period {fit['period']:.{decimals}f} \u00b1 {fit['period_error']:.{decimals}f} days"), 2)
        (plot,) = plots_of(self.folder / "page" / "figures" / "series.svg")
        exponent = int(re.search(r"separation, 10(-?\d+)", " ".join(plot.labels).replace("\u2212", "-"))[1])
        series = self.succeed("status", "state", "--series").splitlines()
        t, y, sigma = numpy.array([row.split(",") for row in series if row[0] in "-.0123456789"], float).T
        self.assertLess(abs(plot.marks("frames") - numpy.stack([t, y / 10.0**exponent], axis=1)).max(axis=0)[1], 0.01)

        def waves(times):
            angle = 2 * numpy.pi * times / fit["period"]
            return numpy.stack([numpy.ones(len(times)), numpy.cos(angle), numpy.sin(angle)], axis=1)

        best = numpy.linalg.lstsq(waves(t) / sigma[:, None], y / sigma, rcond=None)[0]
        line = plot.line("best sinusoid")
        self.assertLess(abs(line[:, 1] - waves(line[:, 0]) @ best / 10.0**exponent).max(), 0.05 * abs(line[:, 1]).max())
        self.assertNotIn("+-", page.text)
        self.assertIn("sequential, for who looks after every frame, ", page.text)
        self.assertIn("sequential FAPthe same for who looks", page.text)
        (self.folder / "state" / "setup.tlms").unlink()
        self.refuse(5, "state: setup.tlms", "toliman rebuild", arguments=("report", "state"))

    def test_state_of_a_short_period(self):
        write_scene(self.folder / "scene.json", cadence={"frames": 60, "interval_days": 1},
                    signal={"period_days": 2.6, "amplitude_px": 1e-3})
        self.succeed("simulate", "scene.json", "--out", "in", "--session", "s", "--dtype", "u32le")
        done = self.run_program("track", "--template", "scene.json", "--state", "state", "--mission-days", "60",
                                "--dtype", "u32le", "in")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.succeed("report", "state", "--out", "page")
        page = self.check_page(self.folder / "page", {"series": ["phase, days of the best period"], "periodogram": ["FWHM"]})
        self.assertIn("into one of which all are folded", page.text)
        status = json.loads(self.succeed("status", "state", "--json"))
        of_fit, of_grid = (f"{period:.5f} days" for period in (status["fit"]["period"], status["period"]))
        self.assertNotEqual(of_fit, of_grid)
        (plot,) = plots_of(self.folder / "page" / "figures" / "periodogram.svg")
        self.assertIn(of_fit, plot.labels)
        self.assertNotIn(of_grid, plot.labels)
        self.assertIn(f"a period of {of_grid} (grid peak)", page.text)
        self.assertAlmostEqual(plot.marks(None, "x")[0][0] * status["fit"]["period"], 1, delta=1e-3)
        # All at one time: a period, but no errors and no sinusoid.
        scene = json.loads((self.folder / "scene.json").read_text())
        scene["cadence"]["interval_days"] = 1e-9
        (self.folder / "scene.json").write_text(json.dumps(scene))
        self.succeed("simulate", "scene.json", "--out", "at_once", "--session", "s", "--dtype", "u32le", "--frames", "0:30")
        done = self.run_program("track", "--template", "scene.json", "--state", "other", "--mission-days", "10",
                                "--dtype", "u32le", "at_once")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.succeed("report", "other", "--out", "page")
        page = self.check_page(self.folder / "page", {"series": ["frames"], "periodogram": []})
        self.assertRegex(page.text, r"period 3\.8\d \u00b1 \u2013 days, log")
        self.assertNotIn("sinusoid", page.text)

    def test_bench(self):
        row = {"bench": "a b", "what": "33 nodes", "series": "Chebyshev", "seconds": 0.0481, "spread": 0.001,
               "error": 3.2e-10, "ratio_peer": 19.4, "peer": "numpy", "ratio_roofline": 1.3}
        rows = [row, {**row, "what": "48 nodes", "seconds": 0.069, "error": 5e-13, "headline": True, "spread": 0.0003,
                       "error_of": "of peak", "error_at": "14 <nodes>"},
                *({**row, "series": "every wavelength", "error": error} for error in (2e-16, 3e-16, 4e-16, 5e-16, 6e-16)),
                {"bench": "end to end", "what": "chapter", "seconds": 4.6, "headline": False},
                *({"bench": "a-b", "what": "x", "series": "bf16", "seconds": 1, "bytes": 1e6 + i, "efficiency": 1.01}
                  for i in range(7))]
        (self.folder / "bench").mkdir()
        far = {**row, "what": "far", "headline": True}
        for name, cpu, its in (("a", "A <CPU>", rows), ("b", "A <CPU>", [far]), ("c", "Other", [far])):
            (self.folder / "bench" / (name + ".json")).write_text(json.dumps(
                {"schema": "toliman-bench/1", "machine": {"cpu": cpu, "isa": "avx2", "cores": 2}, "rows": its}))
        (self.folder / "bench" / "other.json").write_text("[")
        self.succeed("report", "bench")
        page = self.check_page(self.folder / "bench" / "report", {
            "bench-a-b": ["error (relative)", "seconds", "Chebyshev", "every wavelength"],
            "bench-a-b-2": ["bytes of the weights file", "efficiency (no unit)", "bf16"]})
        (plot,) = plots_of(self.folder / "bench" / "report" / "figures" / "bench-a-b.svg")
        for name, points in (("Chebyshev", [[3.2e-10, 0.0481], [5e-13, 0.069]]),
                             ("every wavelength", [[error, 0.0481] for error in (2e-16, 3e-16, 4e-16, 5e-16, 6e-16)])):
            self.assertLess(abs(plot.marks(name, "xy") / points - 1).max(), 0.02)
        # Benches of one machine share a table.
        self.assertEqual([page.text.count(text) for text in ("Machine: A <CPU>, avx2.", "Machine: Other, avx2.")], [1, 1])
        self.assertLess(page.text.index("far"), page.text.index("Machine: Other"))
        self.assertEqual(page.row("33 nodes")[:5], ["48.1 ms", "2 %", "3 \u00d7 10-10", "numpy", "19.4"])
        self.assertEqual(page.row("48 nodes")[1:3], ["< 1 %", "5 \u00d7 10-13 of peak at 14 <nodes>"])
        self.assertEqual(page.row("chapter")[0], "4.6 s")
        self.assertLess(page.text.index("48 nodes"), page.text.index("33 nodes"))  # the headlines come first


if __name__ == "__main__":
    unittest.main()
