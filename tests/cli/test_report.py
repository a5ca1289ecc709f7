"""toliman report: pages of run, experiment, track and bench folders; every figure, number, colour and mistake."""
import base64
import html.parser
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
import zlib

import numpy
from program import PROGRAM, SCENES, ProgramTest
from test_outputs import write_scene

SEED = 2**53 + 1  # no double holds it
VOID = {"meta", "img", "br"}
# matplotlib's viridis at sixteenths, and ColorBrewer's RdBu from blue to red.
VIRIDIS = ("440154 481a6c 472f7d 414487 39568c 31688e 2a788e 23888e "
           "1f988b 22a884 35b779 54c568 7ad151 a5db36 d2e21b fde725").split()
BLUE_RED = "053061 2166ac 4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d b2182b 67001f".split()


class Reader(html.parser.HTMLParser):
    """Text, tags and pictures of a page; fails where a tag is not closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.words, self.images, self.cells = [], [], [], {}, []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag not in VOID:
            self.open.append(tag)
        if tag == "img":
            self.images[dict(attributes)["alt"]] = dict(attributes)["src"]
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        data = data.replace("\xa0", " ")
        if "style" not in self.open:
            self.words.append(data)
        if "td" in self.open or "th" in self.open:
            self.cells[-1] += data

    @property
    def text(self):
        return " ".join("".join(self.words).replace("\u2212", "-").split())

    def row(self, name):
        """Cells behind the one of this name."""
        at = self.cells.index(name)
        return [cell.replace("\u2212", "-") for cell in self.cells[at + 1 : at + 6]]


def png_pixels(data):
    """[row][column][rgb] of an 8-bit PNG without interlace, by the format's own words."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + size]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0]
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
            assert (depth, interlace) == (8, 0)
            channels = {2: 3, 6: 4}[colour]
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    step, above, rows = channels, bytearray(width * channels), []
    packed = zlib.decompress(packed)
    for row in range(height):
        start = row * (1 + width * channels)
        line = bytearray(packed[start + 1 : start + 1 + width * channels])
        undo(packed[start], line, above, step)
        rows.append(line)
        above = line
    return numpy.array(rows, int).reshape(height, width, channels)[:, :, :3]


def undo(kind, line, above, step):
    """Takes a PNG filter back, in place."""
    for i in range(len(line) if kind else 0):
        a, b, c = (line[i - step], above[i], above[i - step]) if i >= step else (0, above[i], 0)
        if kind == 4:
            to_a, to_b, to_c = abs(b - c), abs(a - c), abs(a + b - 2 * c)
            guess = a if to_a <= to_b and to_a <= to_c else b if to_b <= to_c else c
        else:
            guess = (0, a, b, (a + b) // 2)[kind]
        line[i] = (line[i] + guess) & 255


def coloured(parts, colours):
    """Colours of parts 0 ... 1 of a palette."""
    table = numpy.array([[int(colour[i : i + 2], 16) for i in (0, 2, 4)] for colour in colours])
    places = numpy.linspace(0, 1, len(colours))
    return numpy.stack([numpy.interp(parts, places, table[:, channel]) for channel in range(3)], axis=-1)


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
        "series": ["phase, days of the found period", "latent, standard deviations", "template, standard deviations",
                   "truth", "mean over 1/24 of a period"],
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

    def drawn(self, name):
        return (self.folder / "copy" / "report" / "figures" / f"{name}.svg").read_text()

    def texts(self, name):
        """Every text on a figure: (x, its side of x, text)."""
        return re.findall(r'translate\(([\d.]+),[^>]*text-anchor="(\w+)">\s*<text>(?:<tspan[^>]*>)?\s*([^<]*)<', self.drawn(name))

    def write_series(self, count, period):
        """A day apart, without noise."""
        rows = "".join(f"{k},{k},{y!r},{y!r},{y!r}\n" for k in range(count) for y in [numpy.sin(2 * numpy.pi * k / period + 1)])
        (self.folder / "copy" / "series.csv").write_text("frame,t,true,latent,template\n" + rows)

    def copy(self, *, without=(), **changes):
        """A copy of the run as folder `copy`, with other keys of its result and without some files."""
        shutil.rmtree(self.folder / "copy", ignore_errors=True)
        shutil.copytree(self.run_folder, self.folder / "copy", ignore=shutil.ignore_patterns(*without))
        (self.folder / "copy" / "result.json").write_text(json.dumps({**self.result, **changes}))

    def embedded(self, name):
        svg = (self.top / "page" / "figures" / f"{name}.svg").read_text()
        return [png_pixels(base64.b64decode(data)) for data in re.findall(r"data:image/png;base64,([^'\"]+)", svg)]

    def test_page(self):
        self.assertEqual(self.told, "page/report.html\n")
        page = self.check_page(self.top / "page", self.FIGURES)
        for words in ("short.1", f"seed {SEED},", "0.1.0", "40 frames", "365 days"):
            self.assertIn(words, page.text)

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
        span = 1200  # 40 frames 30 days apart
        truth, fap = result["true_series"], result["log10_fap"]
        self.assertEqual(page.row("signal")[0], f"{truth['period_days'] / span:.4f} \u00b1 "
                                                f"{truth['period_half_width_days'] / span:.4f}")
        row = page.row("network (atom)")
        self.assertEqual(row[0], f"{result['period_days'] / span:.4f} \u00b1 {result['period_half_width_days'] / span:.4f}")
        found = re.fullmatch(r"(\d\.\d) \u00d7 10(-\d+)", row[2])
        self.assertAlmostEqual(numpy.log10(float(found[1])) + int(found[2]), fap, delta=0.03)

    def test_digits_follow_from_the_error(self):
        """Two digits of the error; a period of days is not rounded to an error of 0.00."""
        template = {**self.result["template"], "period_days": 2.59927}
        self.copy(without=("scene.json", "training.csv"), period_days=2.599307, period_error_days=0.00041953,
                  period_half_width_days=0.0100, period_fwhm_days=0.0200, template=template)
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
        labels = [text for _, _, text in self.texts("series")]
        self.assertIn("phase, days of the found period", labels)
        # The truth rises to a crest and falls to a trough once, however it was sampled.
        truth = re.findall(r"<path stroke='rgb\(213,  94,   0\)'  d='([^']*)'", self.drawn("series"))
        for path in truth:
            y = numpy.array([float(point.split(",")[1]) for point in path.rpartition("M")[2].replace("L", " ").split()])
            rising = numpy.diff(y)[abs(numpy.diff(y)) > 0.02] > 0
            self.assertGreater(len(y), 200)
            self.assertEqual(numpy.count_nonzero(numpy.diff(rising.astype(int))), 2)
        self.assertEqual(len(truth), 2)
        # Where the highest peak is one of noise, by the true period.
        self.copy(without=("scene.json", "training.csv"), true_period_days=2.6, period_days=57, log10_fap=-0.3)
        self.write_series(300, 2.6)
        self.assertIn("Folded: all 115 periods lie over one, the true one, 2.6 days", self.report().text)

    def test_long_periods_stand_along_time(self):
        for truth, words in ((100, "mean over 1/24 of a period"), (0, "mean over 1/72 of the time")):
            self.copy(without=("scene.json", "training.csv"), true_period_days=truth, period_days=100)
            self.write_series(300, 100)
            self.assertNotIn("Folded", self.report().text)
            labels = [text for _, _, text in self.texts("series")]
            self.assertIn("time, days", labels)
            self.assertIn(words, labels)

    def test_labels_of_a_peak_stay_on_the_figure(self):
        frequency = numpy.linspace(0.005, 0.5, 500)
        for period, place in ((150, "left"), (20, "middle"), (2.01, "edge")):
            self.copy(without=("scene.json", "training.csv"), period_days=period, period_fwhm_days=0.004 * period**2,
                      period_error_days=0.1, template={**self.result["template"], "period_days": period,
                                                               "period_fwhm_days": 9e9})  # wider than the figure
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

    def test_words_stand_at_the_end_once(self):
        self.copy(without=("scene.json", "training.csv"))
        self.succeed("report", "copy", "copy", "--out", "both")
        html = (self.folder / "both" / "report.html").read_text()
        self.assertEqual(html.count("<h2>Words</h2>"), 1)
        for word in ("network", "template", "untrained network", "signal", "network (atom)", "the chapter", "MMSE", "FAP",
                     "decoder: cosine, gain", "1 &minus; MSSIM"):
            self.assertEqual(html.count(f"<dt>{word}</dt><dd>"), 1, word)

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
        scene = json.loads((self.top / "scene.json").read_text())
        scene["noise"] = {"photon": False}
        scene["signal"]["phase_rad"] = numpy.pi / 2  # frame 0 is the crest
        scene["cadence"]["frames"] = 1
        images = []
        for amplitude in (1e-3, 1e-9):  # what 1e-5 px change is linear in it
            scene["signal"]["amplitude_px"] = amplitude
            (self.folder / "still.json").write_text(json.dumps(scene))
            self.succeed("simulate", "still.json", "--out", "f.npy")
            images.append(numpy.load(self.folder / "f.npy")[0])
        change = images[0] - images[1]
        parts = 0.5 + change / abs(change).max() / 2
        self.assertLessEqual(abs(self.embedded("frame")[1][::-1] - coloured(parts, BLUE_RED)).max(), 3)

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
        self.copy(without=("scene.json", "training.csv"))
        self.succeed("report", "copy", "copy", "--out", "both")
        names = ["series", "periodogram"]
        self.check_page(self.folder / "both", {prefix + name: [] for prefix in ("", "2-") for name in names})

    def test_refusals(self):
        self.refuse(3, "none: No such folder", arguments=("report", "none"))
        (self.folder / "empty").mkdir()
        self.refuse(3, "empty: holds neither result.json", "experiment.json", "ledger.tlml", "toliman-bench/1",
                    arguments=("report", "empty"))
        (self.folder / "file").write_text("{}")
        self.refuse(3, "file: is no folder", arguments=("report", "file"))
        self.copy(schema="toliman-run/2")
        self.refuse(3, "copy/result.json: schema = toliman-run/2: must be toliman-run/1", arguments=("report", "copy"))
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
        stand_in.write_text("#!/bin/sh\necho 'gnuplot> plot' >&2\necho '     line 7: no such thing' >&2\nexit 1\n")
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


class Others(ReportTest):
    def test_experiment(self):
        rung = {"method": "cae", "amplitude_px": 1e-5, "seeds": 3, "found": 3, "period_error": 0.00123,
                "log10_fap": -831.26, "expected_log10_fap": -829.2, "slope": 0.999, "efficiency": 1.008}
        low = {**rung, "amplitude_px": 1e-6, "log10_fap": -0.4, "found": 1, "efficiency": 0.123}
        other = {**rung, "method": "pca<white>", "efficiency": None, "amplitude_px": 1e-2, "slope": -10667038957.912,
                 "period_error": 5.8e-7}
        control = {"method": "cae", "series": 50, "frames": 6000, "alarms": 1, "ks_p": 0.37, "sigma_px": 1.24e-6,
                   "efficiency": 0.995, "bias_px": 2e-9, "slope": 1}
        facts = {"what": "the scene <as it is>", "flux_ratio": 3.12, "crb_px": 1.2e-6, "crb_projected_px": 1.2e-6,
                 "crb_marginal_px": 3.4e-6, "threshold_px": 2.9e-7, "pca_threshold_px": 4.9e-6}
        tables = [{"table": "real", **facts, "ladder": [rung, other, low], "controls": [control]},
                  {"table": "pointing-0.1", **facts, "ladder": [rung], "controls": [control]}]
        result = {"schema": "toliman-experiment/1", "version": "0.1.0", "scene": "chapter", "frames": 1095,
                  "true_period_days": 365, "amplitude_px": 1e-6, "seeds": 3, "blind": 50,
                  "grid": {"f0": 1, "df": 1, "nf": 9}, "tables": tables}
        folder = self.folder / "table"
        folder.mkdir()
        (folder / "experiment.json").write_text(json.dumps(result))
        # FAPs k/50 less a little: five in each tenth.
        rows = [f"real,cae,0,1,{k},365,0,{numpy.log10((k + 0.5) / 50)!r},0,1,1,0,1" for k in range(50)]
        head = ("# remark\ntable,method,amplitude_px,seed,series,period_days,period_error,log10_fap,found,slope,sigma,mean,"
                "efficiency\n")
        (folder / "experiment.csv").write_text(head + "\n".join(rows) + "\n")
        self.assertEqual(self.succeed("report", "table"), "table/report/report.html\n")
        page = self.check_page(folder / "report", {
            "ladder-real": ["amplitude of the signal, px", "FAP (no unit)", "efficiency (no unit)", "pca<white>"],
            "blind-real": ["FAP of the highest peak (no unit)", "number of series"]})
        self.assertIn("Table real: the scene <as it is>", page.text)
        self.assertEqual(page.row("cae")[:5], ["1.00 \u00d7 10-5", "3 of 3", "0.12", "-831.3", "0.999"])
        self.assertEqual(page.row("pca<white>")[:5], ["1.00 \u00d7 10-2", "3 of 3", "0.000058", "-831.3", "-1.07 \u00d7 1010"])
        self.assertIn("caethe autoencoder, trained once for each seed of weights", page.text)  # its line of --help
        self.assertIn("foundlog10 FAP below -3", page.text)
        self.assertIn("1 of 3", page.cells)
        self.assertNotIn("0.123", page.cells)  # not found: an efficiency of noise
        self.assertIn("0.37", page.cells)
        self.assertIn("2.90 \u00d7 10-7 px", page.text)
        bars = re.findall(r"fill-opacity|<polygon|<rect", (folder / "report/figures/blind-real.svg").read_text())
        self.assertGreater(len(bars), 10)
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

    def test_bench(self):
        row = {"bench": "optics", "what": "33 nodes", "series": "Chebyshev", "seconds": 0.0481, "spread": 0.001,
               "error": 3.2e-10, "ratio_peer": 19.4, "peer": "numpy", "ratio_roofline": 1.3}
        rows = [row, {**row, "what": "48 nodes", "seconds": 0.069, "error": 5e-13, "headline": True},
                *({**row, "series": "every wavelength", "error": error} for error in (2e-16, 3e-16, 4e-16, 5e-16, 6e-16)),
                {"bench": "end to end", "what": "chapter", "seconds": 4.6, "headline": False},
                *({"bench": "blobs", "what": "x", "series": "bf16", "seconds": 1, "bytes": 1e6 + i, "efficiency": 1.01}
                  for i in range(7))]
        (self.folder / "bench").mkdir()
        far = {**row, "what": "far", "headline": True}
        for name, cpu, its in (("a", "A <CPU>", rows), ("b", "A <CPU>", [far]), ("c", "Other", [far])):
            (self.folder / "bench" / (name + ".json")).write_text(json.dumps(
                {"schema": "toliman-bench/1", "machine": {"cpu": cpu, "isa": "avx2", "cores": 2}, "rows": its}))
        (self.folder / "bench" / "other.json").write_text("[")
        self.succeed("report", "bench")
        page = self.check_page(self.folder / "bench" / "report", {
            "bench-optics": ["error (relative)", "seconds", "Chebyshev", "every wavelength"],
            "bench-blobs": ["bytes of the weights file", "efficiency (no unit)", "bf16"]})
        # Benches of one machine share a table.
        self.assertEqual([page.text.count(text) for text in ("Machine: A <CPU>, avx2.", "Machine: Other, avx2.")], [1, 1])
        self.assertLess(page.text.index("far"), page.text.index("Machine: Other"))
        self.assertEqual(page.row("33 nodes")[:5], ["48.1 ms", "2 %", "3 \u00d7 10-10", "numpy", "19.4"])
        self.assertEqual(page.row("chapter")[0], "4.6 s")
        self.assertLess(page.text.index("48 nodes"), page.text.index("33 nodes"))  # the headlines come first


if __name__ == "__main__":
    unittest.main()
