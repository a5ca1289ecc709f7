"""toliman report of a run: the numbers, figures and files of the page, and every mistake."""
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy
from pages import Reader, Recorder, ReportTest, lines, write_bench
from program import PROGRAM
from shared_run import AMPLITUDE, COLUMNS, FRAMES, NAME, PERIOD, SEED, SIDE, rows_of, shared_run

FIGURES = ["series", "folded", "periodogram", "pupil", "cut", "frame", "whiteness", "signal-and-atom", "bandwidths",
           "reconstructions", "displacement", "architecture", "pooling", "activations", "training"]
CHEAP = ["series", "folded", "periodogram", "training"]  # of a run without images
MODULE = ["/usr/bin/python3", "-m", "toliman.report"]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(pathlib.Path(PROGRAM).parents[1] / "python"), "TOLIMAN_LIBRARY": "/nowhere/libtoliman.so"}


class Run(ReportTest):
    run_folder = shared_run()

    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.top = pathlib.Path(kept.name)
        cls.result = json.loads((cls.run_folder / "result.json").read_text())
        cls.page = Recorder(cls.run_folder)
        cls.copy_to(cls.top / "copy", images=None)
        for folder, out in ((cls.run_folder, "page"), ("copy", "cheap")):
            done = subprocess.run([PROGRAM, "report", folder, "--out", out], cwd=cls.top, capture_output=True, text=True)
            assert (done.returncode, done.stdout, done.stderr) == (0, f"{out}/report.html\n", ""), done

    def check_cheap(self, folder):
        """The page has the bytes of that of a copy without images."""
        self.assertEqual(*((top / "report.html").read_bytes() for top in (self.folder / folder, self.top / "cheap")))

    @classmethod
    def copy_to(cls, folder, **changes):
        """A copy of the run with other keys of its result, and without its images if they are None."""
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(cls.run_folder, folder, ignore=shutil.ignore_patterns("images"))
        if changes.get("images", True):
            (folder / "images").mkdir()
            for path in (cls.run_folder / "images").iterdir():
                (folder / "images" / path.name).symlink_to(path)
        (folder / "result.json").write_text(json.dumps({**cls.result, **changes}))

    def copy(self, **changes):
        self.copy_to(self.folder / "copy", **changes)

    def recorded(self, **changes):
        self.copy(**changes)
        return Recorder(self.folder / "copy")

    def write_series(self, count, period):
        """A day apart, without noise; the template's values have the other sign."""
        rows = "".join(f"{k},{k},{2 * y!r},{y!r},{1 - y!r}\n" for k in range(count) for y in [math.sin(2 * math.pi * k / period + 1)])
        (self.folder / "copy" / "series.csv").write_text("frame,t,true,latent,template\n" + rows)

    def test_page(self):
        page = self.check_page(self.top / "page", FIGURES)
        for words in (f"toliman run: {NAME}", f"seed {SEED}.", "libtoliman 0.3.0", f"{FRAMES} frames", f"period {PERIOD} days",
                      self.result["provenance"]["command"], self.result["provenance"]["date"], "doi:10.1007/978-3-030-65867-0_8"):
            self.assertIn(words, page.text)
        self.assertNotIn("MMSE", page.text)

    def test_numbers_are_those_of_the_result(self):
        page, result = Reader((self.top / "page" / "report.html").read_text()), self.result

        def rounded(value, error):
            decimals = max(0, 1 - int(f"{error:.1e}".split("e")[1]))
            return f"{value:.{decimals}f} ± {error:.{decimals}f}"

        period = rounded(result["period_days"], result["period_error_days"])
        self.assertIn(f"Period found: {period} days", page.text)
        distance = (result["fitted_amplitude_px"] - AMPLITUDE) / result["fitted_amplitude_error_px"]
        exponent = math.floor(math.log10(result["fitted_amplitude_px"]))
        amplitude = rounded(*(10**-exponent * result[f"fitted_amplitude{end}_px"] for end in ("", "_error")))
        self.assertIn(f"({amplitude}) × 10⁻{'⁰¹²³⁴⁵⁶⁷⁸⁹'[-exponent]} px", page.text)
        self.assertIn(f"{abs(distance):.1f} sigma {'above' if distance > 0 else 'below'} the true value, 1.00 × 10⁻⁴ px", page.text)
        self.assertEqual(page.row("network")[1:4], [f"{result['efficiency']:.3f}", period, f"{result['log10_fap']:.1f}".replace("-", "−")])
        self.assertEqual(page.row("template")[2], rounded(result["template"]["period_days"], result["template"]["period_error_days"]))
        self.assertEqual(page.row("untrained network")[3].replace("−", "-"), f"{result['untrained']['log10_fap']:.1f}")
        self.assertEqual(page.row("network, no signal")[3].replace("−", "-"), f"{result['no_signal']['log10_fap']:.1f}")
        mantissa, exponent = f"{result['latent_sigma_px']:.2e}".split("e")
        self.assertEqual(page.row("network")[0], f"{mantissa} × 10⁻{'⁰¹²³⁴⁵⁶⁷⁸⁹'[-int(exponent)]}")
        self.assertIn(f"Time: {result['timings']['total_s']:.1f} s in total; set-up {result['timings']['setup_s']:.1f}, ", page.text)
        span, truth = FRAMES, result["true_series"]  # a day apart
        self.assertEqual(page.row("signal")[0], f"{truth['period_days'] / span:.3f}; {truth['half_width_period_days'] / span:.3f}")
        self.assertEqual(page.row("network (atom)")[2], "0.33; 0.06, log₁₀ FAP −67.1")

    def test_digits_follow_from_the_error(self):
        template = {**self.result["template"], "period_days": 2.59927, "period_error_days": 0.00041}
        self.copy(period_days=2.599307, period_error_days=0.00041953, half_width_period_days=0.0100,
                  fwhm_period_days=0.0200, template=template)
        recorded = Recorder(self.folder / "copy")
        page = Reader(recorded.html())
        self.assertIn("2.59931 ± 0.00042 days", page.text)
        self.assertIn("FWHM 0.020 days", recorded.captions["periodogram"])
        self.assertEqual((page.row("network")[2], page.row("template")[2]), ("2.59931 ± 0.00042", "2.59927 ± 0.00041"))

    def test_figures_show_the_files(self):
        series, periodogram, training = (rows_of(self.run_folder / f"{name}.csv") for name in ("series", "periodogram", "training"))
        t, truth = series["t"], series["true"]
        for axes, name in zip(self.page.figures["series"].axes, ("latent", "template")):
            found = lines(axes)
            for shown, expected in (("each frame", series[name]), ("truth", truth)):
                numpy.testing.assert_allclose(found[shown], [t, 1e6 * (expected - expected.mean())], rtol=1e-9, atol=1e-6)
        self.assertEqual(axes.get_ylabel(), "separation, 10⁻⁶ px")
        (right,) = axes.child_axes
        self.page.figures["series"].draw_without_rendering()
        per_px = self.result["amplitude_uas"] / self.result["amplitude_px"]
        self.assertAlmostEqual(right.get_ylim()[1] / axes.get_ylim()[1] * 1e6 / per_px, 1, delta=1e-9)
        phase, wave = lines(self.page.figures["folded"].axes[0])["truth"]
        expected = 1e6 * AMPLITUDE * numpy.sin(2 * numpy.pi * phase + 0.4)
        numpy.testing.assert_allclose(wave, expected, atol=1e-5)
        phase, wave = lines(self.page.figures["folded"].axes[0])["best sinusoid"]
        near = numpy.interp((t / self.result["period_days"]) % 1, phase, wave)
        self.assertGreater(numpy.corrcoef(near, series["latent"])[0, 1], 0.9)
        frequency = periodogram["frequency"]
        keys = ((self.result["true_series"], "true"), (self.result, "power"), (self.result["template"], "template"))
        for axes, (own, name) in zip(self.page.figures["periodogram"].axes, keys):
            power, found = periodogram[name], lines(axes)
            numpy.testing.assert_array_equal(found[next(iter(found))], [frequency, power])
            self.assertEqual([v[0] for v in found["grid peak"]], [frequency[power.argmax()], power.max()])
            fit = found["fit" if name == "true" else "fit ± error"]
            self.assertAlmostEqual(fit[0][0] * own["period_days"], 1, delta=1e-12)
        numpy.testing.assert_array_equal(lines(self.page.figures["training"].axes[0])["loss"], [training["step"], training["loss"]])

    def test_images_show_the_files(self):
        geometry, scale = self.result["geometry"], self.result["geometry"]["pixel_scale_arcsec"]
        load = {name: numpy.load(self.run_folder / "images" / f"{name}.npy") for name in
                ("frame", "difference", "pupil_opd", "psf_600nm", "residuals")}
        axes = self.page.figures["frame"].axes[0]
        numpy.testing.assert_array_equal(axes.images[0].get_array(), load["frame"])
        numpy.testing.assert_allclose(axes.images[0].get_extent(), [side * scale for side in (-COLUMNS / 2, COLUMNS / 2, -SIDE / 2, SIDE / 2)])
        places = {line.get_gid(): (line.get_xdata()[0] / scale, line.get_ydata()[0] / scale) for line in axes.get_lines()}
        for star in "ab":
            numpy.testing.assert_allclose(places[f"star-{star.upper()}"], [geometry[f"{star}_x_px"], geometry[f"{star}_y_px"]])
        # B lies at the position angle 30 deg from A, counted from the arrow N towards the arrow E.
        north, east = (numpy.subtract(arrow.xy, arrow.xyann) for arrow in axes.texts if getattr(arrow, "arrow_patch", None)
                       and arrow.get_text() == "")
        way = numpy.subtract(places["star-B"], places["star-A"])
        self.assertAlmostEqual(math.degrees(math.atan2(way @ east, way @ north)), 30, delta=1e-6)
        shown = self.page.figures["frame"].axes[1].images[0]
        self.assertAlmostEqual(shown.norm.vmax, -shown.norm.vmin)
        numpy.testing.assert_allclose(shown.get_array() / shown.get_array()[0, 0], load["difference"] / load["difference"][0, 0])
        pupil, psf = (axes.images[0].get_array() for axes in self.page.figures["pupil"].axes[:2])
        self.assertTrue((numpy.ma.getmaskarray(pupil) == numpy.isnan(load["pupil_opd"])).all())
        numpy.testing.assert_array_equal(psf, load["psf_600nm"])
        x, values = lines(self.page.figures["cut"].axes[0])["600 nm"]
        numpy.testing.assert_allclose(x, scale * (numpy.arange(SIDE) - (SIDE - 1) / 2))
        self.assertIn(list(values), [list(load["psf_600nm"][row]) for row in (127, 128)])
        self.assertIn("λ/D at 600 nm is 0.99 arcsec, 4.95 px", self.page.captions["cut"])
        residuals = load["residuals"]
        heights = self.page.figures["whiteness"].axes[0].patches[0].get_data().values
        self.assertAlmostEqual(heights[25], ((residuals >= 0) & (residuals < 0.2)).mean() / 0.2, delta=1e-3)

    def test_which_series_are_drawn(self):
        """Along time, if periods can be told apart; folded, if there is a period."""
        period = {"true_period_days": 2.6, "period_days": 2.5993, "period_error_days": 0.0004}
        for count, changes, expected, words in (
            (300, period, ["folded"], "all 115.0 cycles over one period, the found one, 2.5993"),
            (3500, {"true_period_days": 2.6, "period_days": 57, "log10_fap": -0.3}, ["folded"], "the true one, 2.6 days"),
            (300, {"true_period_days": 100, "period_days": 100}, ["series", "folded"], "all 3.0 cycles over one period"),
            (300, {"true_period_days": 0, "amplitude_px": 0, "true_series": None}, ["series"], None),
        ):
            self.copy(images=None, **changes)
            self.write_series(count, 2.6 if changes["true_period_days"] < 5 else 100)
            page = Recorder(self.folder / "copy")
            self.assertEqual([name for name in page.figures if name in ("series", "folded")], expected)
            self.assertEqual("One of 2 frames is drawn." in page.captions[expected[0]], count == 3500)
            if words:
                self.assertIn(words, page.captions["folded"])

    def test_without_signal_and_photon_noise(self):
        page = self.recorded(amplitude_px=0, true_period_days=0, true_series=None, efficiency=None, efficiency_error=None,
                             peak_sigma=None, log10_fap=-0.5)
        text = Reader(page.html()).text
        self.assertIn("not given, because the bound assumes photon noise, which these frames do not have", text)
        self.assertIn("Highest peak: ", text)
        self.assertIn("This is not a significant period.", text)
        for words in ("noise of the brightest", "noise alone, no unit", "the chapter's", "Signal:", "−67.1", "True"):
            self.assertNotIn(words, text)
        for axes in page.figures["series"].axes:
            self.assertNotIn("truth", lines(axes))
        self.assertEqual(len(page.figures["periodogram"].axes), 2)
        self.assertEqual(len([axes for axes in page.figures["frame"].axes if axes.images]), 1)

    def test_without_controls(self):
        template = {**self.result["template"], "sigma_px": None}
        page = self.recorded(controls="none", latent_sigma_px=None, efficiency=None, efficiency_error=None, no_signal=None,
                             untrained=None, template=template)
        text = Reader(page.html()).text
        self.assertIn("Controls were left out (--controls none): without frames without signal, sigma and efficiency are "
                      "unknown", text)
        self.assertIn("Residuals are divided by the noise that the bound assumes; their rms is ",
                      page.captions["reconstructions"])
        self.assertTrue(page.captions["series"].split(". One of")[0].endswith("the displacement without noise."))
        text += "".join(page.captions.values())
        for words in ("lack photon noise", "do not have", "network, no signal", "of the scatter of one latent"):
            self.assertNotIn(words, text)

    def test_what_is_unknown(self):
        """Nulls, a point spread function that the pupil cannot have, a grid of one frequency, a peak at the edge."""
        images = {**self.result["images"], "psf_500-700nm": {**self.result["images"]["psf_500-700nm"], "reason": "a <reason>"}}
        self.copy(period_error_days=None, fitted_amplitude_error_px=None, at_edge=True, images=images)
        (self.folder / "copy" / "periodogram.csv").write_text("frequency,power,template,true\n0.5,0.9,0.8,0.7\n")
        page = Recorder(self.folder / "copy")
        text = Reader(page.html()).text
        for words in ("± – days", "No point spread function of 500–700 nm: a <reason>", "The peak is at the edge",
                      "its grid does not have two frequencies above 0"):
            self.assertIn(words, text)
        self.assertNotIn("nan", text)
        self.assertEqual(len(lines(page.figures["cut"].axes[0])), 2)
        for name in ("psf_600nm", "psf_550-600nm"):
            images[name] = {**images[name], "reason": "no"}
        self.assertNotIn("cut", self.recorded(images=images).figures)
        self.copy(images=None)
        self.assertIn("No images", Reader(Recorder(self.folder / "copy").html()).text)

    def test_names_are_only_names(self):
        name = "<script>alert('1')</script>&$\\frac{"
        self.copy(images=None, scene=name, version='"><b>', provenance={"command": "x \x1b[2J</p>", "date": "d", "processor": "{{ 7*7 }}"})
        (self.folder / "copy").rename(self.folder / "$\udcfe<b>")
        self.succeed("report", "$\udcfe<b>", "--out", "page")
        read = self.check_page(self.folder / "page", CHEAP)
        self.assertIn(f"toliman run: {name}", read.text)
        self.assertIn("{{ 7*7 }}", read.text)
        self.assertFalse({"script", "b"} & set(read.tags))

    def test_several_folders(self):
        """Words are explained once; figures of the page before are removed, other files remain; the bytes are the same."""
        self.copy(images=None)
        self.succeed("report", "copy", "copy", "--out", "both")
        self.check_page(self.folder / "both", [prefix + name for prefix in ("", "2-") for name in CHEAP])
        html = (self.folder / "both" / "report.html").read_text()
        for word in ("<h2>Words</h2>", *(f"<dt>{word}</dt>" for word in ("network", "template", "FAP", "the chapter"))):
            self.assertEqual(html.count(word), 1, word)
        (self.folder / "both" / "figures" / "own.svg").touch()
        self.succeed("report", "copy", "--out", "both")
        (self.folder / "both" / "figures" / "own.svg").unlink()
        self.check_page(self.folder / "both", CHEAP)
        self.check_cheap("both")

    def test_refusals(self):
        self.refuse(3, "none: No such folder", arguments=("report", "none"))
        for key, value, words in (
            ("schema", "toliman-run/1", 'schema = "toliman-run/1": must be toliman-run/2'), ("scene", 7, "scene = 7: must be text"),
            ("template", None, "template.sigma_px: is missing"), ("at_edge", 1, "at_edge = 1: must be true or false"),
            ("period_days", "x", 'period_days = "x": must be a finite number'), ("frames", 1.5, "frames = 1.5: must be a whole number"),
            ("grid", {"f0": -1}, "grid.f0 = -1: must be above 0"), ("geometry", {}, "geometry.pixel_scale_arcsec: is missing"),
        ):
            self.copy(**{key: value})
            self.fail_with(f"copy/result.json: {words}", "copy")
        for file, damage, words in (
            ("result.json", lambda text: text[:200], "copy/result.json: is damaged: "),
            ("result.json", lambda text: text.replace(f'"frames": {FRAMES},', '"frames": 1e999,'), "copy/result.json: frames = Infinity: must be a whole"),
            ("result.json", lambda text: "[]", "copy/result.json: is not a JSON object"),
            ("result.json", lambda text: "[" * 100000, "copy/result.json: is damaged: "),
            ("series.csv", lambda text: text.replace("template", "other"), "copy/series.csv:2: has no column template"),
            ("series.csv", lambda text: text + "1,2\n", "copy/series.csv:23: has 2 columns, the header 5"),
            ("series.csv", lambda text: text + "1,2,3,nan,5\n", "copy/series.csv:23: latent = nan: must be a finite number"),
            ("series.csv", lambda text: text + "1,2,3,x,5\n", "copy/series.csv:23: latent = x: must be a finite number"),
            ("periodogram.csv", lambda text: "# nothing\n", "copy/periodogram.csv: is empty"),
            ("training.csv", lambda text: "step,loss\n", "copy/training.csv: has no rows"),
        ):
            self.copy()
            path = self.folder / "copy" / file
            path.write_text(damage(path.read_text()))
            self.fail_with(words, "copy")
        for file, damage, words in (("frame", lambda data: data[:1000], "is damaged"), ("frame", None, "No such file"),
                                    ("residuals", lambda data: self.bytes_of("frame"), "must be an array of real numbers with 3 axes")):
            self.copy()
            path = self.folder / "copy" / "images" / f"{file}.npy"
            data = path.read_bytes()
            path.unlink()
            if damage:
                path.write_bytes(damage(data))
            self.fail_with(f"copy/images/{file}.npy: {words}", "copy")
        (self.folder / "copy" / "series.csv").unlink()
        self.refuse(3, "copy/series.csv: No such file", arguments=("report", "copy"))

    def bytes_of(self, name):
        return (self.run_folder / "images" / f"{name}.npy").read_bytes()

    def test_without_a_package(self):
        """One line that names what to install, and nothing is written."""
        self.copy()
        for modules, packages in ((["matplotlib"], "python3-matplotlib"), (["jinja2", "numpy"], "python3-numpy python3-jinja2")):
            (self.folder / "sitecustomize.py").write_text(f"import sys\nfor name in {modules}: sys.modules[name] = None\n")
            done = self.run_program("report", "copy", env={**os.environ, "PYTHONPATH": str(self.folder)})
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertEqual(done.stderr, "toliman: report needs Debian packages that are not installed: apt-get install "
                             f"{packages}\n")
        self.assertFalse((self.folder / "copy" / "report").exists())

    def test_nothing_else_is_said_or_needed(self):
        """No library, no home to write to, no display, no settings of the user or of the current folder."""
        self.copy(images=None)
        (self.folder / "matplotlibrc").write_text("lines.linewidth: 7\nno.such.key: 1\n")
        for name in ("numpy.py", "json.py"):
            (self.folder / name).write_text("raise ImportError")
        home = {"HOME": "/proc/self", "XDG_CACHE_HOME": "/proc/self", "XDG_CONFIG_HOME": "/proc/self", "MPLBACKEND": "TkAgg",
                "TOLIMAN_LIBRARY": "/nowhere"}
        environment = {key: value for key, value in {**os.environ, **home}.items() if key not in ("DISPLAY", "MPLCONFIGDIR")}
        done = self.run_program("report", "copy", "--out", "page", env=environment)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "page/report.html\n", ""))
        self.check_cheap("page")

    def test_the_module_alone(self):
        """The same page by python3 -m, without libtoliman, which importing the package does not load either."""
        self.copy(images=None)
        done = subprocess.run([*MODULE, "copy", "--out", "by_module"], cwd=self.folder, env=ENVIRONMENT, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "by_module/report.html\n", ""))
        self.check_cheap("by_module")
        text = "import sys, toliman, toliman.report; from toliman.report import figures, images; print('toliman._raw' in sys.modules)"
        done = subprocess.run([sys.executable, "-c", text], env=ENVIRONMENT, capture_output=True, text=True)
        self.assertEqual((done.stdout, done.stderr), ("False\n", ""))
        own, others = (subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True).stdout
                       for command in ([*MODULE, "--help"], [PROGRAM, "report", "--help"]))
        for option in ("--out", "--png", "--pdf", "--force"):
            self.assertIn(option, own)
            self.assertIn(option, others)

    def test_a_full_disk_leaves_nothing(self):
        write_bench(self.folder / "b")
        done = subprocess.run(["bash", "-c", 'ulimit -f 8; exec "$@"', "-", PROGRAM, "report", "b"],
                              cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (6, ""), done.stderr)
        self.assertRegex(done.stderr, r"^toliman: \S+: cannot be written: File too large\n$")
        self.assertEqual(os.listdir(self.folder / "b"), ["b.json"])
        with open("/dev/full", "w") as full:
            done = subprocess.run([PROGRAM, "report", "b"], cwd=self.folder, stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual((done.returncode, done.stderr), (6, "toliman: standard output: No space left on device\n"))
        self.refuse(6, "b/b.json: is not a folder", arguments=("report", "b", "--out", "b/b.json"))


if __name__ == "__main__":
    unittest.main()
