"""toliman report of a run: every figure, number, colour and mistake."""
import base64
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

import numpy
from figures import BLUE_RED, VIRIDIS, Reader, coloured, plots_of, png_pixels
from program import PROGRAM, SCENES, ProgramTest

SEED = 2**53 + 1  # no double holds it


class ReportTest(ProgramTest):
    def check_page(self, folder, figures):
        """A page that reads as HTML, fetches nothing and has these figures {name: texts on them}, and their files."""
        text = (folder / "report.html").read_text()
        page = Reader(text)
        self.assertNotRegex(text, "https?:|<script|<link|url\\(")
        self.assertEqual(list(page.images), list(figures))
        self.assertEqual(sorted(os.listdir(folder / "figures")), sorted(f"{n}.{s}" for n in figures for s in ("png", "svg")))
        for name, labels in figures.items():
            svg = (folder / "figures" / f"{name}.svg").read_bytes()
            self.assertEqual(base64.b64decode(page.images[name].partition("base64,")[2]), svg)
            tree = xml.etree.ElementTree.fromstring(svg)
            self.assertEqual(tree.get("width"), "900")
            words = " ".join("".join(node.itertext()) for node in tree.iter("{http://www.w3.org/2000/svg}text"))
            words = " ".join(words.split())
            for label in labels:
                self.assertIn(label, words, name)
            png = (folder / "figures" / f"{name}.png").read_bytes()
            self.assertEqual(struct.unpack(">II", png[16:24]), (1800, 2 * int(tree.get("height"))))
        return page


class Run(ReportTest):
    FIGURES = {
        "pupil": ["x, mm", "x, px", "optical path difference, nm", "fraction of the light in a pixel"],
        "bandwidths": ["580 nm", "50 nm about 580 nm", "110 nm about 580 nm", "x, px", "fraction of the light in a pixel"],
        "frame": ["frame 0", "x, px", "y, px", "photons"],
        "reconstruction": ["frame 0", "reconstruction", "residual over its sigma", "photons", "sigma of the pixel"],
        "series": ["phase, days of the found period", "latent, 10-6 px", "template, 10-6 px", "microarcsec", "truth",
                   "mean over 1/24 of a period"],
        "periodogram": ["frequency, 1/day", "power (no unit)", "FWHM", "FAP 0.001"],
        "training": ["step", "loss (no unit)"],
    }

    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.top = pathlib.Path(kept.name)
        star = {"spectrum": {"kind": "blackbody", "temperature_k": 5800}}
        scene = json.loads((SCENES / "chapter.json").read_text())
        scene["name"], scene["band"] = "short.1", {"wavelength_nm": 580}
        scene["telescope"]["pupil_samples"] = 70
        scene["cadence"].update(frames=40, interval_days=30)
        scene["signal"]["amplitude_px"] = 1e-5
        for name in scene["stars"]:
            scene["stars"][name].update(star)
        (cls.top / "scene.json").write_text(json.dumps(scene))
        for command in (["run", "scene.json", "--seed", SEED, "--json"], ["report", "short.1.run", "--out", "page"]):
            done = subprocess.run([PROGRAM, *map(str, command)], cwd=cls.top, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            cls.printed, cls.told = getattr(cls, "told", ""), done.stdout
        cls.run_folder = cls.top / "short.1.run"
        cls.result = json.loads((cls.run_folder / "result.json").read_text())

    def report(self, folder="copy"):
        """Makes a page of a folder here; its Reader."""
        self.succeed("report", folder)
        return Reader((self.folder / folder / "report" / "report.html").read_text())

    def check_series(self, period, means, error):
        """The figure against write_series, in px; on the right in microarcsec."""
        def wave(points):
            return numpy.sin(2 * numpy.pi * points[:, 0] / period + 1)

        for sign, plot in zip((1, -1), self.figure("series"), strict=True):
            for points, size in ((plot.line("truth"), 2), (plot.marks("each frame"), sign), (plot.line(means), sign)):
                self.assertGreater(len(points), 20)
                self.assertLess(abs(points[:, 1] - size * wave(points)).max(), error)
            per_px = self.result["amplitude_uas"] / self.result["amplitude_px"]
            left, right = (numpy.polyfit(*numpy.array(plot.ticks[side]).T, 1)[0] for side in ("y", "right"))
            self.assertAlmostEqual(right / left / per_px, 1, delta=1e-3)

    def drawn(self, name):
        return (self.folder / "copy" / "report" / "figures" / f"{name}.svg").read_text()

    def texts(self, name):
        """Every text on a figure: (x, its side of x, text)."""
        return re.findall(r'translate\(([\d.]+),[^>]*text-anchor="(\w+)">\s*<text>(?:<tspan[^>]*>)?\s*([^<]*)<', self.drawn(name))

    def write_series(self, count, period):
        """A day apart, without noise; the template's values have the other sign."""
        rows = "".join(f"{k},{k},{2 * y!r},{y!r},{1 - y!r}\n" for k in range(count) for y in [numpy.sin(2 * numpy.pi * k / period + 1)])
        (self.folder / "copy" / "series.csv").write_text("frame,t,true,latent,template\n" + rows)

    def copy(self, *, without=(), **changes):
        """A copy of the run as folder `copy`, with other keys of its result and without some files."""
        shutil.rmtree(self.folder / "copy", ignore_errors=True)
        shutil.copytree(self.run_folder, self.folder / "copy", ignore=shutil.ignore_patterns(*without))
        (self.folder / "copy" / "result.json").write_text(json.dumps({**self.result, **changes}))

    def embedded(self, name, page=None):
        svg = ((page or self.top / "page") / "figures" / f"{name}.svg").read_text()
        return [png_pixels(base64.b64decode(data)) for data in re.findall(r"data:image/png;base64,([^'\"]+)", svg)]

    def test_page(self):
        self.assertEqual(self.told, "page/report.html\n")
        page = self.check_page(self.top / "page", self.FIGURES)
        for words in ("short.1", f"seed {SEED},", "0.2.0", "40 frames", "365 days"):
            self.assertIn(words, page.text)

    def figure(self, name, folder=None):
        return plots_of((folder or self.folder / "copy" / "report") / "figures" / f"{name}.svg")

    def test_periodogram_has_the_peak_of_the_result(self):
        power = numpy.loadtxt(self.run_folder / "periodogram.csv", delimiter=",", skiprows=2)
        plots = self.figure("periodogram", self.top / "page")
        for plot, own, column, name in zip(plots, (self.result, self.result["template"]), (1, 2),
                                           ("network's latents", "template's values"), strict=True):
            frequency, top = 1 / own["period_days"], power[:, column].max()
            x, y = plot.marks(None, "x")[0]
            self.assertAlmostEqual(x / frequency, 1, delta=1e-3)
            self.assertAlmostEqual(y, top, delta=1e-3)
            x, y = plot.label(f"{own['period_days']:.2f} days", "x")
            self.assertTrue(0 < x / frequency - 1 < 0.05)
            self.assertAlmostEqual(y, top, delta=0.05)
            arrow = plot.line(None, "x")
            half = own["fwhm_period_days"] * frequency**2 / 2
            self.assertAlmostEqual(arrow[:, 0].min() / (frequency - half), 1, delta=1e-3)
            self.assertAlmostEqual(arrow[:, 0].max() / (frequency + half), 1, delta=1e-3)
            self.assertAlmostEqual(arrow[:, 1].mean() / top, 0.5, delta=0.01)
            self.assertLess(abs(plot.line("FAP 0.001", "x")[:, 1] - self.result["power_at_fap_1e-3"]).max(), 1e-3)
            curve = plot.line(name, "x")
            self.assertLess(abs(numpy.interp(curve[:, 0], power[:, 0], power[:, column]) - curve[:, 1]).max(), 5e-3)

    def test_the_seed_is_told_in_full(self):
        self.assertIn(f'"seed":\t{SEED},', self.printed)
        self.assertEqual(self.result["seed"], SEED)

    def test_numbers_are_those_of_the_result(self):
        page, result = Reader((self.top / "page" / "report.html").read_text()), self.result
        self.assertIn(f"{result['period_days']:.2f} \u00b1 {result['period_error_days']:.2f} days", page.text)
        self.assertEqual(page.row("network")[1:4], [f"{result['efficiency']:.3f}", f"{result['period_days']:.2f}",
                                                    f"{result['log10_fap']:.1f}"])
        self.assertEqual(page.row("template")[2:4], [f"{result['template']['period_days']:.2f}",
                                                     f"{result['template']['log10_fap']:.1f}"])
        self.assertEqual(page.row("untrained network")[3], f"{result['untrained']['log10_fap']:.1f}")
        self.assertEqual(page.row("network, no signal")[3], f"{result['no_signal']['log10_fap']:.1f}")
        mantissa, exponent = f"{result['latent_sigma_px']:.2e}".split("e")
        self.assertEqual(page.row("network")[0], f"{mantissa} \u00d7 10{int(exponent)}")
        mantissa, exponent = f"{result['crb_px']:.2e}".split("e")
        self.assertEqual(page.row("Cram\u00e9r-Rao bound")[0], f"{mantissa} \u00d7 10{int(exponent)}")
        spent = [f"{result['timings'][name + '_s']:.1f}" for name in ("total", "setup", "train", "simulate", "encode", "period", "controls")]
        self.assertEqual(page.row("seconds in all: set-up, training, frames, encoding, period, controls")[0],
                         f"{spent[0]}: {', '.join(spent[1:])}")
        span = 1200  # 40 frames 30 days apart
        truth, fap = result["true_series"], result["log10_fap"]
        self.assertEqual(page.row("signal")[0], f"{truth['period_days'] / span:.4f} \u00b1 "
                                                f"{truth['half_width_period_days'] / span:.4f}")
        row = page.row("network (atom)")
        self.assertEqual(row[0], f"{result['period_days'] / span:.4f} \u00b1 {result['half_width_period_days'] / span:.4f}")
        self.assertEqual(row[1:3], [f"{fap:.1f}", "0.33 \u00b1 0.06, -67.1"])

    def test_digits_follow_from_the_error(self):
        """Two digits of the error; a period of days is not rounded to an error of 0.00."""
        template = {**self.result["template"], "period_days": 2.59927}
        self.copy(without=("scene.json", "training.csv"), period_days=2.599307, period_error_days=0.00041953,
                  half_width_period_days=0.0100, fwhm_period_days=0.0200, template=template)
        (self.folder / "copy" / "periodogram.csv").write_text("frequency,power,template\n0.1,0.1,0.2\n0.5,0.9,0.8\n")
        page = self.report()
        self.assertIn("2.59931 \u00b1 0.00042 days", page.text)
        self.assertIn("peak at 2.59931 days, full width at half maximum 0.020 days", page.text)
        self.assertIn("error of the period is 0.00042 days", page.text)
        self.assertEqual((page.row("network")[2], page.row("template")[2]), ("2.59931", "2.59927"))
        self.assertEqual(page.row("network (atom)")[0], "0.0021661 \u00b1 0.0000083")  # of 1200 days
        labels = [text for _, _, text in self.texts("periodogram")]
        self.assertIn("2.59931 days", labels)
        self.assertIn("2.59927 days", labels)
        self.copy(without=("scene.json", "training.csv"), period_days=363.1109, period_error_days=3.1323)
        self.assertIn("363.11 \u00b1 3.13 days", self.report().text)

    def test_short_periods_are_folded(self):
        self.copy(without=("scene.json", "training.csv"), true_period_days=2.6, period_days=2.5993, period_error_days=0.0004)
        self.write_series(300, 2.6)
        self.assertIn("Folded: all 115 periods lie over one, that found, 2.59930 days, each frame", self.report().text)
        self.assertIn("phase, days of the found period", self.figure("series")[1].labels)
        self.check_series(2.5993, "mean over 1/24 of a period", 0.4)
        # Where the highest peak is one of noise, by the true period.
        self.copy(without=("scene.json", "training.csv"), true_period_days=2.6, period_days=57, log10_fap=-0.3)
        self.write_series(3500, 2.6)
        text = self.report().text
        self.assertIn("Folded: all 1346 periods lie over one, the true one, 2.6 days", text)
        self.assertIn("Of 3500 frames one of 2 is drawn.", text)
        self.assertEqual(len(self.figure("series")[0].marks("each frame")), 1750)

    def test_long_periods_stand_along_time(self):
        """And grids are narrow, or but one frequency."""
        for truth, words in ((100, "mean over 1/24 of a period"), (0, "mean over 1/72 of the time")):
            self.copy(without=("scene.json", "training.csv"), true_period_days=truth, period_days=100)
            self.write_series(300, 100)
            rows = ["0.3,0.4,0.1\n", "0.4,0.9,0.2\n", "0.5,0.1,0.3\n"][: 3 if truth else 1]
            (self.folder / "copy" / "periodogram.csv").write_text("frequency,power,template\n" + "".join(rows))
            text = self.report().text
            self.assertNotIn("Folded", text)
            if truth:  # no decade
                self.assertEqual([tick for _, tick in self.figure("periodogram")[1].ticks["x"]], [0.3, 0.35, 0.4, 0.45, 0.5])
            else:
                self.assertIn("No figure of the periodogram: its grid has no two frequencies above 0", text)
            self.assertIn("time, days", self.figure("series")[1].labels)
            self.check_series(100, words, 0.05)

    def test_labels_of_a_peak_stay_on_the_figure(self):
        frequency = numpy.linspace(0.005, 0.5, 500)
        for period, place in ((150, "left"), (20, "middle"), (2.01, "edge")):
            self.copy(without=("scene.json", "training.csv"), period_days=period, fwhm_period_days=0.004 * period**2,
                      period_error_days=0.1, template={**self.result["template"], "period_days": period,
                                                               "fwhm_period_days": 9e9})  # wider than the figure
            power = numpy.exp(-(((frequency - 1 / period) / 0.003) ** 2)).tolist()
            rows = "".join(f"{f!r},{p!r},{p!r}\n" for f, p in zip(frequency.tolist(), power))
            (self.folder / "copy" / "periodogram.csv").write_text("frequency,power,template\n" + rows)
            self.report()
            at = {text: (float(x), side) for x, side, text in self.texts("periodogram")}
            self.assertEqual(sum(text == "FWHM" for _, _, text in set(self.texts("periodogram"))), 1)
            peak, side = at[f"{period:.2f} days"]
            legend = at["network's latents"][0]
            if place == "left":
                self.assertEqual((side, at["FWHM"][1]), ("start", "start"))
                self.assertLess(peak + 100, legend)
            else:
                self.assertEqual((side, at["FWHM"][1]), ("end", "end"))
                self.assertLess(legend + 200, peak)
            for x in (peak, at["FWHM"][0]):
                self.assertTrue(88 < x < 882, (place, x))

    def test_colours_of_a_frame(self):
        """Against frames that `simulate` makes, row 0 at the bottom."""
        self.succeed("simulate", self.top / "scene.json", "--seed", SEED, "--frames", "0", "--out", "f.npy")
        frame = numpy.load(self.folder / "f.npy")[0]
        shown = self.embedded("frame")[0][::-1]
        parts = numpy.log(frame / (frame.max() * 1e-5)) / numpy.log(1e5)
        self.assertLessEqual(abs(shown - coloured(parts, VIRIDIS)).max(), 0.51)
        self.assertEqual(shown[numpy.unravel_index(frame.argmax(), frame.shape)].tolist(), [0xFD, 0xE7, 0x25])

    def test_colours_of_pupil_and_wobble(self):
        pupil = self.embedded("pupil")[0]
        self.assertEqual(pupil.shape, (70, 70, 3))
        self.assertEqual(pupil[0, 0].tolist(), [0xB8] * 3)  # outside
        self.assertEqual(pupil[35, 35].tolist(), [0xB8] * 3)  # behind the secondary
        colours = {tuple(colour) for colour in pupil.reshape(-1, 3)}
        self.assertEqual(colours, {(0xB8, 0xB8, 0xB8), (0x44, 0x01, 0x54), (0xFD, 0xE7, 0x25)})  # 0 nm and 297.5 nm
        change = self.still(1e-3) - self.still(1e-9)  # what 1e-5 px change is linear in it
        parts = 0.5 + change / abs(change).max() / 2
        self.assertLessEqual(abs(self.embedded("frame")[1][::-1] - coloured(parts, BLUE_RED)).max(), 3)

    def still(self, amplitude, phase=numpy.pi / 2):
        """Frame 0 without noise, by `simulate`; the crest of the signal if not told otherwise."""
        scene = json.loads((self.top / "scene.json").read_text())
        scene["noise"] = {"photon": False}
        scene["signal"].update(phase_rad=phase, amplitude_px=amplitude)
        scene["cadence"]["frames"] = 1
        (self.folder / "still.json").write_text(json.dumps(scene))
        self.succeed("simulate", "still.json", "--out", "f.npy")
        return numpy.load(self.folder / "f.npy")[0]

    def test_colours_of_bandwidths(self):
        """Against images that `psf` makes of one star alone."""
        scene = json.loads((self.top / "scene.json").read_text())
        for name in ("binary", "signal", "noise"):
            del scene[name]
        scene["stars"] = {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 1e9}}
        scene["cadence"], scene["accuracy"] = {"frames": 1, "exposure_s": 1}, 1e-6
        images = []
        for band in ({"wavelength_nm": 580}, {"min_nm": 555, "max_nm": 605, "step_nm": 1},
                     {"min_nm": 525, "max_nm": 635, "step_nm": 1}):
            scene["band"] = band
            (self.folder / "star.json").write_text(json.dumps(scene))
            self.succeed("psf", "star.json", "--out", "f.npy")
            images.append(numpy.load(self.folder / "f.npy"))
        parts = numpy.log(numpy.array(images) / (numpy.max(images) * 1e-5)) / numpy.log(1e5)
        shown = numpy.array(self.embedded("bandwidths"))[:, ::-1]
        self.assertLessEqual(abs(shown - [coloured(part, VIRIDIS) for part in parts]).max(), 1)
        self.assertLessEqual(abs(self.embedded("pupil")[1][::-1] - shown[0]).max(), 1 + 0.2 * 255)

    def test_colours_of_the_reconstruction(self):
        """It is the frame without its noise, all but exactly, and the residual that noise."""
        self.succeed("simulate", self.top / "scene.json", "--seed", SEED, "--frames", "0", "--out", "f.npy")
        frame, expected = numpy.load(self.folder / "f.npy")[0], self.still(1e-5, 0.4)
        original, again, residual = (picture[::-1] for picture in self.embedded("reconstruction"))
        self.assertTrue((original == self.embedded("frame")[0][::-1]).all())
        of_frame, of_expected = (coloured(numpy.log(image / (frame.max() * 1e-5)) / numpy.log(1e5), VIRIDIS)
                                 for image in (frame, expected))
        self.assertLessEqual(abs(again - of_expected).max(), 1)
        differ = [numpy.count_nonzero((again != numpy.rint(of)).any(axis=-1)) for of in (of_expected, of_frame)]
        self.assertLess(10 * differ[0], differ[1], differ)  # dark pixels show which it is
        noise = (frame - expected) / numpy.sqrt(expected)
        self.assertLessEqual(abs(residual - coloured(0.5 + noise / 8, BLUE_RED)).max(), 8)

    def test_without_signal_and_photon_noise(self):
        """Another scene's images, whose pixels hold 6e-7 of the light at most, beside this run's series."""
        self.copy(amplitude_px=0, true_series=None, efficiency=None, efficiency_error=None)
        scene = json.loads((self.top / "scene.json").read_text())
        scene["noise"] = {"photon": False, "read_e": 5}
        scene["detector"]["pixel_scale_arcsec"] = 0.015
        scene["binary"] = {"separation_arcsec": 0.1}
        del scene["signal"]
        (self.folder / "copy" / "scene.json").write_text(json.dumps(scene))
        self.run_program("train", "copy/scene.json", "--steps", "1", "--out", "copy/weights.tlmw")
        figures = {**self.FIGURES, "frame": ["frame 0"], "reconstruction": ["frame 0", "reconstruction"]}
        figures["series"] = ["latent, 10-6 px", "mean over 1/72 of the time"]
        self.succeed("report", "copy")
        page = self.check_page(self.folder / "copy" / "report", figures)
        self.assertIn("not given as the bound counts photon noise, which these frames do not have", page.text)
        for words in ("noise of the brightest", "where noise alone", "MMSE; noise alone", "rms", "truth", "the chapter's column", "The signal:"):
            self.assertNotIn(words, page.text)
        self.assertNotIn("-67.1", page.text)
        self.assertEqual([len(self.embedded(name, self.folder / "copy" / "report")) for name in ("bandwidths", "reconstruction")],
                         [3, 2])
        for plot in self.figure("series"):
            self.assertNotIn("truth", plot.drawn)

    def test_older_runs_and_lost_files(self):
        older = ("scene.json", "weights.tlmw", "training.csv")
        self.copy(without=older)
        page = self.folder / "copy" / "report"
        self.assertEqual(self.succeed("report", "copy/"), "copy/report/report.html\n")
        read = self.check_page(page, {name: self.FIGURES[name] for name in ("series", "periodogram")})
        self.assertIn("No images: the folder has no scene.json", read.text)
        self.copy()
        scene = json.loads((self.top / "scene.json").read_text())
        scene["telescope"]["mask"] = {"kind": "file", "file": "lost.npy", "quantity": "opd_m"}
        (self.folder / "copy" / "scene.json").write_text(json.dumps(scene))
        self.succeed("report", "copy")
        read = self.check_page(page, {name: self.FIGURES[name] for name in ("series", "periodogram", "training")})
        self.assertRegex(read.text, "No images: a file that the scene names is gone: .*lost.npy")

    def test_names_are_only_names(self):
        self.copy(without=("scene.json",), scene="<script>alert('1')</script>&", version='"><b>')
        self.succeed("report", "copy")
        read = self.check_page(self.folder / "copy" / "report", {name: [] for name in ("series", "periodogram", "training")})
        self.assertIn("toliman run: <script>alert('1')</script>&", read.text)
        self.assertNotIn("script", read.tags)

    def test_several_folders(self):
        """Figures are more than a process may have files, words stand once; figures of the page before go, other files stay."""
        self.copy(without=("scene.json", "training.csv"))
        done = subprocess.run(["bash", "-c", 'ulimit -n 12; exec "$@"', "-", PROGRAM, "report", "copy", "copy", "copy",
                               "--out", "both"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        names = ["series", "periodogram"]
        self.check_page(self.folder / "both", {prefix + name: [] for prefix in ("", "2-", "3-") for name in names})
        html = (self.folder / "both" / "report.html").read_text()
        self.assertEqual(html.count("<h2>Words</h2>"), 1)
        for word in ("network", "template", "untrained network", "signal", "network (atom)", "the chapter", "MMSE", "FAP",
                     "decoder: cosine, gain", "1 &minus; MSSIM"):
            self.assertEqual(html.count(f"<dt>{word}</dt><dd>"), 1, word)
        own = self.folder / "both" / "figures" / "own.svg"
        own.touch()
        self.succeed("report", "copy", "--out", "both")
        own.unlink()
        self.check_page(self.folder / "both", {name: [] for name in names})

    @unittest.skipIf(os.environ.get("TOLIMAN_SANITIZE"), "a sanitizer looks at memory through files of its own")
    def test_no_file_is_left_for_gnuplot(self):
        self.copy(without=("scene.json", "training.csv"))
        done = subprocess.run(["bash", "-c", 'ulimit -n 6; exec "$@"', "-", PROGRAM, "report", "copy"],
                              cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (1, "toliman: gnuplot: Too many open files\n"))

    def test_refusals(self):
        self.refuse(3, "none: No such folder", arguments=("report", "none"))
        (self.folder / "empty").mkdir()
        self.refuse(3, "empty: contains neither result.json", "experiment.json", "ledger.tlml", "toliman-bench/1",
                    arguments=("report", "empty"))
        (self.folder / "file").write_text("{}")
        self.refuse(3, "file: is not a folder", arguments=("report", "file"))
        self.copy(schema="toliman-run/1")
        self.refuse(3, "copy/result.json: schema = toliman-run/1: must be toliman-run/2", arguments=("report", "copy"))
        self.copy(template=None)
        self.refuse(3, "copy/result.json: template.sigma_px: must be a number", arguments=("report", "copy"))
        self.copy(scene=7)
        self.refuse(3, "copy/result.json: scene: must be text", arguments=("report", "copy"))
        self.copy()
        result, series = self.folder / "copy" / "result.json", self.folder / "copy" / "series.csv"
        result.write_text(result.read_text()[:200])
        self.refuse(3, "copy/result.json: is damaged", arguments=("report", "copy"))
        self.copy(without=("scene.json",))
        series.write_text(series.read_text().replace("template", "other"))
        self.refuse(3, "copy/series.csv", "template", arguments=("report", "copy"))
        series.unlink()
        self.refuse(3, "copy/series.csv: No such file", arguments=("report", "copy"))
        self.copy()
        weights = self.folder / "copy" / "weights.tlmw"
        weights.write_bytes(weights.read_bytes()[:-9])
        self.refuse(3, "weights.tlmw", arguments=("report", "copy"))
        scene = self.folder / "copy" / "scene.json"
        scene.write_text(scene.read_text() + " ")
        shutil.copy(self.run_folder / "weights.tlmw", weights)
        self.refuse(3, "copy: scene.json and weights.tlmw are of different scenes", arguments=("report", "copy"))

    def test_without_gnuplot(self):
        self.copy(without=("scene.json",))
        done = self.run_program("report", "copy", env={**os.environ, "PATH": str(self.folder)})
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(done.stderr, "toliman: gnuplot, which draws the figures, is not installed: apt-get install gnuplot-nox\n")
        self.assertFalse((self.folder / "copy" / "report").exists())
        done = self.run_program("report", "copy", "--out", "copy/result.json", env={**os.environ, "PATH": str(self.folder)})
        self.assertEqual((done.returncode, done.stderr), (6, "toliman: copy/result.json: is not a folder\n"))  # said first
        stand_in = self.folder / "gnuplot"
        stand_in.write_text("#!/bin/sh\necho 'gnuplot> plot' >&2\necho 'line 3: warning: a' >&2\n"
                            "echo '     line 7: no such thing' >&2\necho 'line 9: warning: b' >&2\nexit 1\n")
        stand_in.chmod(0o755)
        done = self.run_program("report", "copy", env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"})
        self.assertEqual((done.returncode, done.stderr), (1, "toliman: gnuplot: line 7: no such thing\n"))

    def test_a_full_disk_leaves_nothing(self):
        self.copy(without=("scene.json",))
        before = sorted(os.listdir(self.folder / "copy"))
        done = subprocess.run(["bash", "-c", 'trap "" XFSZ; ulimit -f 60; exec "$@"', "-", PROGRAM, "report", "copy"],
                              cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (6, ""), done.stderr)
        self.assertIn("cannot be written", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertEqual(sorted(os.listdir(self.folder / "copy")), before)


if __name__ == "__main__":
    unittest.main()
