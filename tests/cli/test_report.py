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
import unittest.mock

import numpy
from pages import Reader, Recorder, ReportTest, __main__, lines, results, write_bench
from program import PROGRAM
from toliman.report import run_simulation, style
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
        read = results.load(cls.run_folder / "result.json", "toliman-run/2")
        cls.pictures, _ = run_simulation.simulate(cls.run_folder, read)
        cls.page = cls.recorded_with(cls.pictures, cls.run_folder, cls.top / "page")
        cls.page.write()
        cls.copy_to(cls.top / "copy", images=None)
        __main__.report(__main__.parse([str(cls.top / "copy"), "--out", str(cls.top / "cheap")]))

    def check_cheap(self, folder):
        """The page has the bytes of that of a copy without images."""
        self.assertEqual(*((top / "report.html").read_bytes() for top in (self.folder / folder, self.top / "cheap")))

    @classmethod
    def copy_to(cls, folder, **changes):
        """A copy of the run with other keys of its result, and without its scene if images = None."""
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(cls.run_folder, folder)
        if changes.pop("images", True) is None:
            (folder / "scene.json").unlink()
        (folder / "result.json").write_text(json.dumps({**cls.result, **changes}))

    def copy(self, **changes):
        self.copy_to(self.folder / "copy", **changes)

    @staticmethod
    def recorded_with(pictures, folder, out=None):
        """The page of a run with pictures that were simulated before."""
        with unittest.mock.patch.object(run_simulation, "simulate", return_value=(pictures, "")):
            return Recorder(folder, out)

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
        distance = (result["fitted_amplitude_px"] - AMPLITUDE) / result["fitted_amplitude_error_px"]
        exponent = math.floor(math.log10(result["fitted_amplitude_px"]))
        amplitude = rounded(*(10**-exponent * result[f"fitted_amplitude{end}_px"] for end in ("", "_error")))
        for words in (f"{period} days", f"({amplitude}) × 10⁻{'⁰¹²³⁴⁵⁶⁷⁸⁹'[-exponent]} px", "1.00 × 10⁻⁴ px",
                      f"{abs(distance):.1f} sigma {'above' if distance > 0 else 'below'}", f"{result['timings']['total_s']:.1f} s",
                      f"{result['timings']['setup_s']:.1f}, "):
            self.assertIn(words, page.text)
        self.assertEqual(page.row("network")[1:4], [f"{result['efficiency']:.3f}", period, f"{result['log10_fap']:.1f}".replace("-", "−")])
        self.assertEqual(page.row("template")[2], rounded(result["template"]["period_days"], result["template"]["period_error_days"]))
        self.assertEqual(page.row("untrained network")[3].replace("−", "-"), f"{result['untrained']['log10_fap']:.1f}")
        self.assertEqual(page.row("network, no signal")[3].replace("−", "-"), f"{result['no_signal']['log10_fap']:.1f}")
        mantissa, exponent = f"{result['latent_sigma_px']:.2e}".split("e")
        self.assertEqual(page.row("network")[0], f"{mantissa} × 10⁻{'⁰¹²³⁴⁵⁶⁷⁸⁹'[-int(exponent)]}")
        span, truth = FRAMES, result["true_series"]  # a day apart
        self.assertEqual(page.row("signal")[0], f"{truth['period_days'] / span:.3f}; {truth['half_width_period_days'] / span:.3f}")
        self.assertEqual(page.row("network (atom)")[2], "0.33; 0.06, log₁₀ FAP −67.1")

    def test_figures_show_the_files(self):
        """tests/cli/test_report_figures.py has what is drawn of given data."""
        series, periodogram = (rows_of(self.run_folder / f"{name}.csv") for name in ("series", "periodogram"))
        for axes, name in zip(self.page.figures["series"].axes, ("latent", "template")):
            shown = [series["t"], 1e6 * (series[name] - series[name].mean())]
            numpy.testing.assert_allclose(lines(axes)["each frame"], shown, rtol=1e-9, atol=1e-6)
        keys = ((self.result["true_series"], "true"), (self.result, "power"), (self.result["template"], "template"))
        for axes, (own, name) in zip(self.page.figures["periodogram"].axes, keys):
            found = lines(axes)
            numpy.testing.assert_array_equal(found[next(iter(found))], [periodogram["frequency"], periodogram[name]])
            fit = found["fit" if name == "true" else "fit ± error"]
            self.assertAlmostEqual(fit[0][0] * own["period_days"], 1, delta=1e-12)

    def test_images_show_the_scene(self):
        geometry, scale = self.result["geometry"], self.result["geometry"]["pixel_scale_arcsec"]
        frame, psf = (self.pictures.images[name].values for name in ("frame", "psf_600nm"))
        axes = self.page.figures["frame"].axes[0]
        numpy.testing.assert_array_equal(axes.images[0].get_array(), frame)
        numpy.testing.assert_array_equal(self.page.figures["pupil"].axes[1].images[0].get_array(), psf)
        numpy.testing.assert_allclose(axes.images[0].get_extent(), [side * scale for side in (-COLUMNS / 2, COLUMNS / 2, -SIDE / 2, SIDE / 2)])
        places = {line.get_gid(): (line.get_xdata()[0] / scale, line.get_ydata()[0] / scale) for line in axes.get_lines()}
        for star in "ab":
            numpy.testing.assert_allclose(places[f"star-{star.upper()}"], [geometry[f"{star}_x_px"], geometry[f"{star}_y_px"]])
        # B lies at the position angle 30 deg from A, counted from the arrow N towards the arrow E.
        north, east = (numpy.subtract(arrow.xy, arrow.xyann) for arrow in axes.texts if getattr(arrow, "arrow_patch", None)
                       and arrow.get_text() == "")
        way = numpy.subtract(places["star-B"], places["star-A"])
        self.assertAlmostEqual(math.degrees(math.atan2(way @ east, way @ north)), 30, delta=1e-6)
        self.assertIn("0.99 arcsec, 4.95 px", self.page.captions["cut"])

    def test_which_series_are_drawn(self):
        """Along time, if periods can be told apart; folded, if there is a period."""
        period = {"true_period_days": 2.6, "period_days": 2.5993, "period_error_days": 0.0004}
        for count, changes, expected, words in (
            (300, period, ["folded"], "115.0 cycles"),
            (3500, {"true_period_days": 2.6, "period_days": 57, "log10_fap": -0.3}, ["folded"], "2.6 days"),
            (300, {"true_period_days": 100, "period_days": 100}, ["series", "folded"], "3.0 cycles"),
            (300, {"true_period_days": 0, "amplitude_px": 0, "true_series": None}, ["series"], None),
        ):
            self.copy(images=None, **changes)
            self.write_series(count, 2.6 if changes["true_period_days"] < 5 else 100)
            page = Recorder(self.folder / "copy")
            self.assertEqual([name for name in page.figures if name in ("series", "folded")], expected)
            if words:
                self.assertIn(words, page.captions["folded"])

    def test_without_signal_and_photon_noise(self):
        self.copy(amplitude_px=0, true_period_days=0, true_series=None, efficiency=None, efficiency_error=None,
                  peak_sigma=None, log10_fap=-0.5)
        page = self.recorded_with(self.pictures, self.folder / "copy")
        text = Reader(page.html()).text
        for words, has in (("not a significant period", True), ("Signal:", False), ("−67.1", False), ("True", False)):
            self.assertEqual(words in text, has, words)
        for axes in page.figures["series"].axes:
            self.assertNotIn("truth", lines(axes))
        self.assertEqual(len(page.figures["periodogram"].axes), 2)
        self.assertEqual(len([axes for axes in page.figures["frame"].axes if axes.images]), 1)

    def test_what_is_unknown(self):
        """No controls, nulls, a point spread function that the pupil cannot have, a grid of one frequency, a peak at the edge."""
        pictures = self.pictures._replace(reasons={**self.pictures.reasons, "psf_500-700nm": "a <reason>"})
        self.copy(period_error_days=None, fitted_amplitude_error_px=None, at_edge=True, controls="none",
                  latent_sigma_px=None, efficiency=None, efficiency_error=None, no_signal=None, untrained=None,
                  template={**self.result["template"], "sigma_px": None})
        (self.folder / "copy" / "periodogram.csv").write_text("frequency,power,template,true\n0.5,0.9,0.8,0.7\n")
        page = self.recorded_with(pictures, self.folder / "copy")
        text = Reader(page.html()).text + "".join(page.captions.values())
        for words, has in (("± – days", True), ("500–700 nm: a <reason>", True), ("at the edge", True), ("--controls none", True),
                           ("nan", False), ("network, no signal", False)):
            self.assertEqual(words in text, has, words)
        self.assertEqual(len(lines(page.figures["cut"].axes[0])), 2)

    def test_names_are_only_names(self):
        name = "<script>alert('1')</script>&$\\frac{"
        self.copy(images=None, scene=name, version='"><b>', provenance={"command": "x \x1b[2J</p>", "date": "d", "processor": "{{ 7*7 }}"})
        (self.folder / "copy").rename(self.folder / "$\udcfe<b>")
        __main__.report(__main__.parse([str(self.folder / "$\udcfe<b>"), "--out", str(self.folder / "page")]))
        read = self.check_page(self.folder / "page", CHEAP)
        self.assertIn(f"toliman run: {name}", read.text)
        self.assertIn("{{ 7*7 }}", read.text)
        self.assertFalse({"script", "b"} & set(read.tags))

    def test_several_folders(self):
        """Words are explained once; figures of the page before are removed, other files remain; the bytes are the same."""
        self.copy(images=None)
        self.enterContext(unittest.mock.patch.object(style, "drawn", return_value=b"<svg width='1pt'/>"))
        self.report("copy", "--out", "one")
        self.report("copy", "copy", "--out", "both")
        self.check_page(self.folder / "both", [prefix + name for prefix in ("", "2-") for name in CHEAP])
        html = (self.folder / "both" / "report.html").read_text()
        for word in ("<h2>Words</h2>", *(f"<dt>{word}</dt>" for word in ("network", "template", "FAP", "the chapter"))):
            self.assertEqual(html.count(word), 1, word)
        (self.folder / "both" / "figures" / "own.svg").touch()
        self.report("copy", "--out", "both")
        (self.folder / "both" / "figures" / "own.svg").unlink()
        self.check_page(self.folder / "both", CHEAP)
        self.assertEqual(*((self.folder / name / "report.html").read_bytes() for name in ("one", "both")))

    def test_refusals(self):
        self.fail_with("none: ", "none")
        for key, value, words in (
            ("schema", "toliman-run/1", 'schema = "toliman-run/1": '), ("scene", 7, "scene = 7: "),
            ("template", None, "template.sigma_px: "), ("at_edge", 1, "at_edge = 1: "), ("period_days", "x", 'period_days = "x": '),
            ("frames", 1.5, "frames = 1.5: "), ("grid", {"f0": -1}, "grid.f0 = -1: "),
        ):
            self.copy(images=None, **{key: value})
            self.fail_with(f"copy/result.json: {words}", "copy")
        for file, damage, words in (
            ("result.json", lambda text: text[:200], "copy/result.json: "), ("result.json", lambda text: "[]", "copy/result.json: "),
            ("series.csv", lambda text: text.replace("template", "other"), "copy/series.csv:2: "),
            ("series.csv", lambda text: text + "1,2\n", "copy/series.csv:23: "),
            ("series.csv", lambda text: text + "1,2,3,nan,5\n", "copy/series.csv:23: latent = nan: "),
            ("periodogram.csv", lambda text: "# nothing\n", "copy/periodogram.csv: "),
        ):
            self.copy(images=None)
            path = self.folder / "copy" / file
            path.write_text(damage(path.read_text()))
            self.fail_with(words, "copy")
        (self.folder / "copy" / "series.csv").unlink()
        self.refuse(3, "copy/series.csv: ", arguments=("report", "copy"))

    def test_files_that_cannot_be_simulated(self):
        """The page says why it has no images."""
        for name, content, words in (("weights.tlmw", b"TLMW", "weights.tlmw: "), ("scene.json", b"{", "No images: "),
                                     ("scene.json", b"{}", "schema: is missing")):
            self.copy()
            (self.folder / "copy" / name).write_bytes(content)
            page = Recorder(self.folder / "copy")
            self.assertEqual(list(page.figures), CHEAP)
            self.assertIn(words, Reader(page.html()).text)

    def test_without_a_package(self):
        """One line that names what to install, and nothing is written."""
        self.copy()
        for modules, packages in ((["matplotlib"], "python3-matplotlib"), (["jinja2", "numpy"], "python3-numpy python3-jinja2")):
            (self.folder / "sitecustomize.py").write_text(f"import sys\nfor name in {modules}: sys.modules[name] = None\n")
            done = self.run_program("report", "copy", env={**os.environ, "PYTHONPATH": str(self.folder)})
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertRegex(done.stderr, f"^toliman: .*: apt-get install {packages}\\n$")
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
        """Importing the package does not load libtoliman; python3 -m has the options of the program."""
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
        self.assertRegex(done.stderr, r"^toliman: \S+: [^\n]*\n$")
        self.assertEqual(os.listdir(self.folder / "b"), ["b.json"])
        with open("/dev/full", "w") as full:
            done = subprocess.run([PROGRAM, "report", "b"], cwd=self.folder, stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual((done.returncode, done.stderr.partition(": ")[2].partition(":")[0]), (6, "standard output"))


if __name__ == "__main__":
    unittest.main()
