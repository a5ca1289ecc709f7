"""python3 -m toliman.experiment: its numbers against numpy and astropy on the same frames, and that a stopped one resumes."""
import csv
import fcntl
import json
import re
import signal
import subprocess
import sys
import time
import unittest

import numpy
from astropy.timeseries import LombScargle

from package import ROOT
sys.path.append(str(ROOT / "tests/cli"))
from program import PATIENCE, ProgramTest, long, one_wavelength  # noqa: E402
from toliman.experiment.methods import METHODS  # noqa: E402
import test_run_moving  # noqa: E402
import test_stops  # noqa: E402

PLACES = {"A": [-4.0, -6.0], "B": [8.0, 10.0]}
ALONG = numpy.array([-12.0, -16.0]) / 20  # of star A, where it lengthens the separation


def tiny_scene():
    """64 x 64 px, two wavelengths, a bound of 1e-4 px."""
    star = {"spectrum": {"kind": "lines", "wavelength_nm": [570, 580], "weight": [1, 2]}}
    return {
        "schema": "toliman-scene/1",
        "name": "tiny",
        "telescope": {
            "aperture_m": 0.125,
            "pupil_samples": 64,
            "mask": {"kind": "spiral", "edges": "cell", "opd_nm": 288, "terms": [{"a": 1, "f": 2, "m": 3}, {"a": 0.5, "f": 5, "p": 1}]},
        },
        "stars": {"A": {**star, "photons_per_s": 2e7}, "B": {**star, "photons_per_s": 1e7}},
        "binary": {"offsets_px": PLACES},
        "signal": {"kind": "sinusoid", "star": "A", "amplitude_px": 3e-3, "period_days": 20, "phase_rad": 0.4},
        "cadence": {"frames": 60, "interval_days": 1, "exposure_s": 10},
        "detector": {"shape": [64, 64], "pixel_scale_arcsec": 0.2},
        "noise": {"photon": True, "seed": 7},
    }


class Experiment(ProgramTest):
    modules = ("experiment",)

    def setUp(self):
        super().setUp()
        self.write(tiny_scene())

    def write(self, scene, name="tiny.json"):
        (self.folder / name).write_text(json.dumps(scene))

    def experiment(self, *arguments, scene="tiny.json"):
        return json.loads(self.succeed("experiment", scene, *arguments, "--json"))

    def rows(self, folder):
        with open(self.folder / folder / "experiment.csv") as file:
            return list(csv.DictReader(line for line in file if line[0] != "#"))

    def frames(self, seed, scene="tiny.json"):
        self.succeed("simulate", scene, "--seed", seed, "--out", "f.npy")
        return numpy.load(self.folder / "f.npy")

    def image(self, step=0.0):
        scene = tiny_scene()
        scene["binary"] = {"offsets_px": {**PLACES, "A": list(numpy.array(PLACES["A"]) + step * ALONG)}}
        self.write(scene, "moved.json")
        self.succeed("psf", "moved.json", "--out", "p.npy")
        return numpy.load(self.folder / "p.npy")

    def search(self, values, grid, block=1):
        """Period and log10 FAP of the highest peak, by astropy on a grid 200 times as fine about the grid's highest."""
        periodogram = LombScargle(numpy.arange(len(values)) * float(block), values)
        frequency = grid["f0"] + grid["df"] * numpy.arange(grid["nf"])
        top = frequency[periodogram.power(frequency, method="slow").argmax()]
        fine = numpy.clip(top + grid["df"] * numpy.linspace(-1, 1, 401), frequency[0], frequency[-1])
        power = periodogram.power(fine, method="slow")
        fap = periodogram.false_alarm_probability(power.max(), method="baluev", maximum_frequency=frequency[-1])
        return 1 / fine[power.argmax()], numpy.log10(fap)


class Units(Experiment):
    def test_magnitudes_and_focal_length(self):
        """The same numbers as fluxes and pixels in arcsec; both stars are equally bright in the second table."""
        scene = tiny_scene()
        for star in scene["stars"].values():
            star.update(magnitude=-2.5 * numpy.log10(star.pop("photons_per_s") / 1e7), zero_point_photons_per_s=1e7)
        scene["detector"].update(focal_length_m=10, pixel_um=numpy.radians(scene["detector"].pop("pixel_scale_arcsec") / 3600) * 1e7)
        self.write(scene, "other.json")
        found = []
        for name in ("tiny.json", "other.json"):
            self.experiment("--methods", "template", "--tables", "real,equal", "--amplitudes", 3e-3, "--seeds", 1, "--controls",
                            "none", "--out", name[:5], scene=name)
            found.append([[float(row[key]) for key in ("period_days", "log10_fap", "slope")] for row in self.rows(name[:5])])
        self.assertEqual(len(found[0]), 2)
        numpy.testing.assert_allclose(*found, rtol=1e-3)


class Numbers(Experiment):
    """The template method, worked out again."""

    ARGUMENTS = ("--methods", "template", "--tables", "real", "--amplitudes", "3e-3,1e-5", "--seeds", 2,
                 "--blind", 100, "--out", "x")

    def estimates(self, frames):
        reference = self.image()
        derivative = (self.image(1e-3) - self.image(-1e-3)) / 2e-3
        weights = derivative / reference
        return ((frames - reference) * weights).sum(axis=(1, 2)) / (derivative * weights).sum()

    def test_against_numpy_and_astropy(self):
        result = self.experiment(*self.ARGUMENTS)
        rows = self.rows("x")
        self.assertEqual(len(rows), 2 * 2 + 100)
        bound = result["tables"][0]["crb_projected_px"]
        derivative = (self.image(1e-3) - self.image(-1e-3)) / 2e-3
        self.assertAlmostEqual(bound * numpy.sqrt((derivative**2 / self.image()).sum()), 1, delta=1e-6)
        truth = 3e-3 * numpy.sin(2 * numpy.pi * numpy.arange(60) / 20 + 0.4)
        for seed in (1, 2):
            (row,) = [r for r in rows if float(r["amplitude_px"]) == 3e-3 and r["seed"] == str(seed)]
            values = self.estimates(self.frames(seed))
            period, log10_fap = self.search(values, result["grid"])
            slope, level = numpy.polyfit(truth, values, 1)
            sigma = numpy.sqrt(((values - level - slope * truth) ** 2).sum() / 58)
            for key, expected, share in (
                ("period_days", period, 1e-3), ("log10_fap", log10_fap, 1e-3), ("slope", slope, 1e-4),
                ("sigma", sigma, 1e-3), ("efficiency", bound * slope / sigma, 1e-3),
                ("period_error", abs(period / 20 - 1), 0.2),
            ):
                self.assertAlmostEqual(float(row[key]) / expected, 1, delta=share, msg=key)
            self.assertEqual(row["found"], "1")

    def test_without_signal(self):
        result = self.experiment(*self.ARGUMENTS)
        scene = tiny_scene()
        scene["signal"] = {"kind": "none"}
        self.write(scene, "still.json")
        blind = [r for r in self.rows("x") if float(r["amplitude_px"]) == 0]
        for seed, series in ((1, 0), (2, 3)):
            (row,) = [r for r in blind if (r["seed"], r["series"]) == (str(seed), str(series))]
            values = self.estimates(self.frames(seed + 2**32 * (2 + series), "still.json"))
            period, log10_fap = self.search(values, result["grid"])
            self.assertAlmostEqual(float(row["period_days"]) / period, 1, delta=0.02)
            self.assertAlmostEqual(float(row["log10_fap"]), log10_fap, delta=0.02)
            self.assertAlmostEqual(float(row["sigma"]) / values.std(ddof=1), 1, delta=1e-4)
            self.assertAlmostEqual(float(row["slope"]), 1, delta=1e-4)
        (control,) = result["tables"][0]["controls"]
        self.assertEqual((control["series"], control["frames"]), (100, 6000))
        self.assertAlmostEqual(control["efficiency"], 1, delta=4 / numpy.sqrt(2 * 6000))
        faps = numpy.sort([10 ** float(r["log10_fap"]) for r in blind])
        self.assertEqual(control["alarms"], (faps < 1e-3).sum())
        steps = numpy.arange(100) / 100
        gap = lambda x: numpy.maximum(x - steps, steps + 0.01 - x).max(axis=-1)
        drawn = numpy.sort(numpy.random.default_rng(1).random((40000, 100)))
        self.assertAlmostEqual(control["ks_p"], (gap(drawn) >= gap(faps)).mean(), delta=0.015)

    def test_theory(self):
        result = self.experiment(*self.ARGUMENTS)
        table, grid = result["tables"][0], result["grid"]
        shape = numpy.sin(2 * numpy.pi * numpy.arange(60) / 20 + 0.4)
        highest = grid["f0"] + grid["df"] * (grid["nf"] - 1)
        periodogram = LombScargle(numpy.arange(60.0), shape)

        def log10_fap(amplitude):
            power = amplitude**2 * shape.var() / (table["crb_px"] ** 2 + amplitude**2 * shape.var())
            return numpy.log10(
                periodogram.false_alarm_probability(power, method="baluev", maximum_frequency=highest)
            )

        self.assertAlmostEqual(log10_fap(table["threshold_px"]), -3, delta=1e-3)
        self.assertAlmostEqual(table["pca_threshold_px"] / table["crb_px"], (4 * 4096 / 60) ** 0.25, delta=1e-3)
        for rung in table["ladder"]:
            self.assertAlmostEqual(rung["expected_log10_fap"], log10_fap(rung["amplitude_px"]), delta=1e-3)
        strong, weak = table["ladder"]
        self.assertEqual((strong["found"], weak["found"]), (2, 0))
        self.assertLess(abs(strong["log10_fap"] / strong["expected_log10_fap"] - 1), 0.15)


class Components(Experiment):
    """What is learnt from the series itself, worked out again from its frames."""

    def series(self):
        frames = self.frames(1).reshape(60, -1)
        reference = self.image().ravel()
        residuals = (frames - reference) / numpy.sqrt(reference)

        def principal(x):
            left, singular, _ = numpy.linalg.svd(x - x.mean(axis=0), full_matrices=False)
            return left[:, 0] * singular[0]

        x = residuals - residuals.mean(axis=0)
        rms = numpy.sqrt((x**2).mean())
        atom = principal(residuals) @ x  # any start that sees the signal
        for _ in range(300):
            atom /= numpy.linalg.norm(atom)
            codes = x @ atom
            codes = numpy.sign(codes) * numpy.maximum(abs(codes) - rms, 0)
            atom = codes @ x
        return {
            "pca": principal(frames), "pca-white": principal(residuals),
            "pca-blocks": principal(residuals.reshape(30, 2, -1).mean(axis=1)), "dictionary": codes,
        }

    def test_against_numpy_and_astropy(self):
        result = self.experiment("--methods", "pca,pca-white,pca-blocks,dictionary", "--tables", "real", "--amplitudes",
                                 "3e-3,1e-5", "--seeds", 1, "--blind", 5, "--out", "x")
        table, daily = result["tables"][0], result["grid"]
        self.assertEqual(table["controls"], [])  # nothing to learn from in series without signal
        truth = 3e-3 * numpy.sin(2 * numpy.pi * numpy.arange(60) / 20 + 0.4)
        for method, values in self.series().items():
            share = 1e-2 if method == "dictionary" else 2e-3  # it ends where little is gained
            block = 60 // len(values)
            grid = {**daily, "nf": int((0.5 / block - 1.5 / 60) / (0.1 / 60) + 1e-9) + 1}
            period, log10_fap = self.search(values, grid, block)
            line = numpy.polyfit(truth.reshape(-1, block).mean(axis=1), values, 1)
            rest = values - numpy.polyval(line, truth.reshape(-1, block).mean(axis=1))
            sigma = numpy.sqrt(block * (rest**2).sum() / (len(values) - 2))
            (row,) = [r for r in self.rows("x") if r["method"] == method and float(r["amplitude_px"]) == 3e-3]
            for key, expected in (
                ("period_days", period), ("log10_fap", log10_fap), ("sigma", sigma),
                ("efficiency", table["crb_px"] * abs(line[0]) / sigma),
            ):
                self.assertAlmostEqual(float(row[key]) / expected, 1, delta=share, msg=(method, key))
            self.assertAlmostEqual(abs(float(row["slope"]) / line[0]), 1, delta=share)  # either sign
            self.assertEqual(row["found"], "1")
        weak = [rung["found"] for rung in table["ladder"] if rung["amplitude_px"] == 1e-5]
        self.assertEqual(weak, [0, 0, 0, 0])  # a fortieth of the threshold


def short_scene(frames):
    scene = one_wavelength()
    scene["cadence"].update(frames=frames)
    scene["signal"].update(period_days=frames / 3, amplitude_px=5e-6)
    return scene


class Unsupervised(Experiment):
    def test_is_that_of_train(self):
        """On the series' own frames, for the first seed and large amplitudes alone. `train` uses other noise, compared
        with which a signal of 1e-2 px is large."""
        scene = short_scene(12)
        scene["signal"]["amplitude_px"] = 1e-2
        self.write(scene, "s.json")
        self.experiment("--methods", "untrained-paper,cae-unsupervised", "--tables", "real", "--amplitudes",
                        "1e-2,1e-5", "--seeds", 2, "--blind", 1, "--out", "x", scene="s.json")
        rows = {}
        for row in self.rows("x"):
            rows.setdefault(row["method"], []).append(row)
        tried = lambda method: [(float(r["amplitude_px"]), int(r["seed"])) for r in rows[method]]
        self.assertEqual(tried("untrained-paper"), [(1e-2, 1), (1e-2, 2), (1e-5, 1), (1e-5, 2), (0, 1)])
        self.assertEqual(tried("cae-unsupervised"), [(1e-2, 1)])
        train = ("train", "s.json", "--mode", "unsupervised", "--layout", "paper", "--input", "raw", "--out", "w.tlmw")
        self.succeed("simulate", "s.json", "--seed", 1, "--out", "f.npy")
        self.succeed(*train, "--epochs", 10)
        text = self.succeed("encode", "--weights", "w.tlmw", "f.npy")
        values = numpy.array([float(line.split(",")[2]) for line in text.splitlines()[1:]])
        slope, level = numpy.polyfit(1e-2 * numpy.sin(2 * numpy.pi * numpy.arange(12) / 4 + 0.4), values, 1)
        (row,) = rows["cae-unsupervised"]
        self.assertAlmostEqual(float(row["mean"]) / values.mean(), 1, delta=1e-2)
        self.assertAlmostEqual(float(row["slope"]) / slope, 1, delta=0.1)
        self.assertNotAlmostEqual(float(rows["untrained-paper"][0]["mean"]) / values.mean(), 1, delta=0.02)


class Networks(Experiment):
    @long
    def test_every_table(self):
        """One wavelength, one seed: slow is the training alone."""
        self.write(short_scene(60), "s.json")
        result = self.experiment("--quick", "--tables", "real,equal,robust", "--amplitudes", "1e-4,1e-8", "--seeds", 1,
                                 "--blind", 2, "--out", "x", scene="s.json")
        mismatches = ["defocus", "separation", "scale", "pointing-0.1", "pointing-0.5"]
        tables = {table["table"]: table for table in result["tables"]}
        self.assertEqual(
            list(tables),
            ["real", "equal", "matched", "jitter", "projected"] + [m + end for m in mismatches for end in ("", "-mean")],
        )
        self.assertAlmostEqual(tables["real"]["flux_ratio"], 3.12, delta=1e-9)
        self.assertAlmostEqual(tables["equal"]["flux_ratio"], 1, delta=1e-9)
        of_scene = ["cae", "template", "fit", "untrained"]
        for name in ("real", "equal"):
            found = {(r["method"], r["amplitude_px"]): r["found"] for r in tables[name]["ladder"]}
            self.assertEqual([method for method, amplitude in found if amplitude == 1e-4],
                             [*of_scene, "pca", "pca-white", "pca-blocks", "dictionary", "untrained-paper"])
            self.assertEqual(found["pca-white", 1e-4] + found["pca-blocks", 1e-4], 2)
            self.assertEqual(found["cae", 1e-4] + found["template", 1e-4], 2)
            self.assertEqual(found["cae", 1e-8] + found["template", 1e-8] + found["untrained", 1e-8], 0)
        controls = {(t, c["method"]): c for t in tables for c in tables[t]["controls"]}
        self.assertEqual(len(controls), 15 * len(of_scene) + 2)
        for name in list(tables)[2:]:
            self.assertEqual([rung["method"] for rung in tables[name]["ladder"]], of_scene)
        self.assertAlmostEqual(controls["real", "cae"]["efficiency"], 0.96, delta=0.2)
        self.assertLess(controls["real", "untrained"]["efficiency"], 0.1)
        for method in ("cae", "template"):
            matched = controls["matched", method]
            self.assertAlmostEqual(matched["slope"], 1, delta=0.01)
            self.assertGreater(controls["jitter", method]["sigma_px"], 50 * matched["sigma_px"])
            self.assertGreater(controls["projected", method]["efficiency"], 0.8)
            self.assertLess(abs(controls["projected", method]["bias_px"]), 3e-6)
            for small in mismatches[:4]:
                share = controls[small + "-mean", method]["efficiency"] / matched["efficiency"]
                self.assertAlmostEqual(share, 1, delta=0.12, msg=small)
                self.assertLess(abs(controls[small + "-mean", method]["bias_px"]), 1e-6)
            share = controls["pointing-0.5-mean", method]["efficiency"] / matched["efficiency"]
            self.assertAlmostEqual(share, 0.8, delta=0.14)  # sharp fringes of one wavelength
        self.assertLess(controls["pointing-0.5", "cae"]["efficiency"], 0.5)  # beyond the linear part of its ELUs
        self.assertGreater(controls["pointing-0.5", "template"]["efficiency"], 0.6)
        text = (self.folder / "x" / "experiment.md").read_text()
        for name in ("## Table real: ", "## Table equal: ", "## Table robust: ", "| at the bound |", "| untrained |"):
            self.assertIn(name, text)


class Controls(Experiment):
    SHORT = ("--methods", "template", "--tables", "real", "--amplitudes", "1e-3", "--seeds", 2)

    def test_left_out(self):
        """The series without signal are those of all controls, as far as they are computed."""
        full = self.experiment(*self.SHORT, "--blind", 40, "--out", "full")
        self.assertEqual((full["controls"], full["blind"]), ("full", 40))
        every = self.rows("full")
        self.assertEqual(len(every), 2 + 40)
        for word, asked, left in (("none", 40, 0), ("quick", 40, 4), ("quick", 1, 1), ("quick", 0, 0)):
            out = f"{word}{asked}"
            result = self.experiment(*self.SHORT, "--blind", asked, "--controls", word, "--out", out)
            self.assertEqual((result["controls"], result["blind"]), (word, left))
            self.assertEqual([control["series"] for control in result["tables"][0]["controls"]], [left] if left else [])
            rows = self.rows(out)
            self.assertEqual(len(rows), 2 + left)
            self.assertEqual([row for row in rows if row not in every], [])
            self.assertIn(f"Controls: {word}: ", (self.folder / out / "experiment.md").read_text())


class SharedFrames(Experiment):
    def test_the_same_as_alone(self):
        """pca-white and dictionary use the same frames; each has the results that it has alone, in any order."""
        common = ("--tables", "real", "--amplitudes", "3e-3,1e-3", "--seeds", 2, "--controls", "none")
        alone = []
        for method in ("pca-white", "dictionary"):
            self.experiment("--methods", method, *common, "--out", method)
            alone += self.rows(method)
        for number, methods in enumerate(("pca-white,dictionary", "dictionary,template,pca-white")):
            self.experiment("--methods", methods, *common, "--out", f"both{number}")
            rows = [row for row in self.rows(f"both{number}") if row["method"] != "template"]
            self.assertEqual(len(rows), 2 * 2 * 2)
            self.assertEqual([row for row in alone if row not in rows], [])


class GoingOn(Experiment):
    ARGUMENTS = ("experiment", "tiny.json", "--methods", "template", "--tables", "real", "--amplitudes", "1e-3",
                 "--seeds", 2, "--blind", 400)

    def start(self, *arguments, **options):
        return subprocess.Popen(self.words_of(*arguments), cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                text=True, **options)

    # promise: stopped-work-resumes
    def test_stopped_and_resumed(self):
        whole = self.succeed(*self.ARGUMENTS, "--out", "whole")
        lines = (self.folder / "whole" / "journal.jsonl").read_bytes().count(b"\n")
        self.assertEqual(lines, 1 + 2 + 400)
        journal = self.folder / "parts" / "journal.jsonl"
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            before = journal.read_bytes().count(b"\n") if journal.exists() else 0
            with self.start(*self.ARGUMENTS, "--out", "parts") as run:
                while not journal.exists() or journal.read_bytes().count(b"\n") < before + 5:
                    self.assertIsNone(run.poll())
                    time.sleep(0.002)
                run.send_signal(number)
                out, err = run.communicate(timeout=PATIENCE)
            self.assertEqual((run.returncode, out), (code, ""))
            self.assertEqual(err.count("\n"), 1)
            self.assertLess(journal.read_bytes().count(b"\n"), lines)
            self.assertEqual([p.name for p in journal.parent.iterdir()], ["journal.jsonl"])
        with open(journal, "ab") as file:
            file.write(b'{"table":"real","method":"templ')  # as a process leaves it that dies
        self.assertEqual(self.succeed(*self.ARGUMENTS, "--out", "parts"), whole)
        for name in ("experiment.csv", "experiment.md", "journal.jsonl"):
            self.assertEqual(
                (self.folder / "parts" / name).read_bytes(), (self.folder / "whole" / name).read_bytes(), name
            )
        results = [json.loads((self.folder / name / "experiment.json").read_text()) for name in ("parts", "whole")]
        self.assertIn("--out whole", results[1].pop("provenance")["command"])
        results[0].pop("provenance")
        self.assertEqual(*results)
        modified = journal.stat().st_mtime_ns
        self.assertEqual(self.succeed(*self.ARGUMENTS, "--out", "parts"), whole)  # nothing is left to do
        self.assertEqual(journal.stat().st_mtime_ns, modified)

    def stop(self, *arguments, seen, **options):
        """Exit code and standard error of an experiment that is stopped once its folder "e" has been seen."""
        with self.start(*arguments, "--quick", "--out", "e", **options) as run:
            while run.poll() is None and not seen():
                time.sleep(0.002)
            start = time.monotonic()
            run.terminate()
            out, err = run.communicate(timeout=PATIENCE)
        self.assertLess(time.monotonic() - start, test_stops.SOON)
        self.assertEqual(out, "")
        return run.returncode, err

    # promise: signals-leave-no-part
    def test_stopped_without_results(self):
        """While the first network is trained: a journal without results is removed, and so is the folder."""
        self.write(one_wavelength(), "s.json")
        journal = self.folder / "e" / "journal.jsonl"
        code, err = self.stop("experiment", "s.json", "--methods", "cae", seen=lambda: journal.exists() and journal.read_bytes())
        self.assertEqual((code, err), (143, test_stops.STOPPED + "; the same command resumes the experiment\n"))
        self.assertFalse((self.folder / "e").exists())

    # promise: signals-leave-no-part
    @long
    def test_stopped_during_a_long_call_of_the_library(self):
        self.write(test_stops.slow_scene(), "slow.json")
        code, _ = self.stop("experiment", "slow.json", seen=(self.folder / "e").exists,
                            preexec_fn=test_stops.on_one_processor)
        self.assertEqual(code, 143)
        self.assertFalse((self.folder / "e").exists())

    def test_other_arguments_need_another_folder(self):
        short = ["experiment", "tiny.json", "--methods", "template", "--tables", "real", "--amplitudes", "1e-3",
                 "--seeds", "1", "--blind", "0", "--out", "x"]
        self.succeed(*short)
        kept = (self.folder / "x" / "experiment.json").read_bytes()
        for option, value, text in (("--amplitudes", "1e-4", "amplitudes_px = [0.001]: "), ("--seeds", "2", "seeds = 1: "),
                                    ("--blind", "1", "blind = 0: "), ("--tables", "equal", 'tables = ["real"]: ')):
            changed = list(short)
            changed[changed.index(option) + 1] = value
            self.refuse(2, "x/journal.jsonl: ", "--out", text, arguments=changed)
        scene = tiny_scene()
        scene["stars"]["A"]["photons_per_s"] = 1e7
        self.write(scene)
        self.refuse(2, "x/journal.jsonl: scene_digest = ", arguments=short)
        self.assertEqual((self.folder / "x" / "experiment.json").read_bytes(), kept)

    def test_journals_that_cannot_be_used(self):
        short = ["experiment", "tiny.json", "--methods", "template", "--tables", "real", "--amplitudes", "1e-3",
                 "--seeds", "1", "--blind", "1", "--out", "x"]
        self.succeed(*short)
        journal = self.folder / "x" / "journal.jsonl"
        good = journal.read_bytes()
        row = good.splitlines()[1]
        for damage in (b"nothing\n", b"{}\n", b'{"table":"real"}\n', row.replace(b"1", b"[]") + b"\n",
                       re.sub(b'("amplitude_px":)[^,]*', rb"\1null", row) + b"\n"):
            journal.write_bytes(good + damage)
            self.refuse(3, "x/journal.jsonl:4: ", arguments=short)
        journal.write_bytes(b"\x93NUMPY\n" + good)
        self.refuse(3, "x/journal.jsonl:1: ", arguments=short)
        journal.write_bytes(good)
        with open(journal) as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            self.refuse(6, "x/journal.jsonl: ", arguments=short)
        self.succeed(*short)


class Moving(Experiment):
    ARGUMENTS = ("moving.json", "--out", "x", "--seeds", 1, "--amplitudes", test_run_moving.AMPLITUDE, "--tables")

    def test_only_the_fit_follows(self):
        self.write(test_run_moving.moving_scene(), "moving.json")
        self.succeed("experiment", *self.ARGUMENTS, "real", "--blind", 3, "--methods", "fit,template")
        (table,) = json.loads((self.folder / "x/experiment.json").read_text())["tables"]
        fit, template = table["ladder"]
        self.assertEqual((fit["found"], template["found"]), (1, 0))
        self.assertAlmostEqual(fit["slope"], 1, delta=0.1)
        control = {row["method"]: row for row in table["controls"]}
        self.assertEqual(control["fit"]["alarms"], 0)
        self.assertAlmostEqual(control["fit"]["slope"], 1, delta=1e-3)
        self.assertGreater(control["fit"]["efficiency"], 0.7)
        self.assertLess(control["template"]["efficiency"], 0.1)

    @long
    def test_banks(self):
        """In frames of 256x256 px, of one date: nine networks."""
        telescope, detector = test_run_moving.SCENE["telescope"], test_run_moving.SCENE["detector"]
        scene = test_run_moving.moving_scene(
            binary={"separation_arcsec": 7, "position_angle_deg": 30}, detector={**detector, "shape": [256, 256]},
            telescope={**telescope, "pupil_samples": 128})
        scene["cadence"]["frames"], scene["signal"]["period_days"] = 30, 15
        self.write(scene, "moving.json")
        self.succeed("experiment", *self.ARGUMENTS, "real", "--blind", 1, "--methods", "bank,untrained-bank")
        (table,) = json.loads((self.folder / "x/experiment.json").read_text())["tables"]
        self.assertEqual([row["found"] for row in table["ladder"]], [1, 0])
        self.assertGreater(table["controls"][1]["sigma_px"], 10 * table["controls"][0]["sigma_px"])

    def test_robust_needs_stars_at_rest(self):
        self.write(test_run_moving.moving_scene(), "moving.json")
        self.refuse(2, "moving.json: ", arguments=("experiment", *self.ARGUMENTS, "real,robust"))


class Files(Experiment):
    SHORT = ("experiment", "tiny.json", "--methods", "template", "--tables", "real", "--amplitudes", "1e-3", "--seeds", 1,
             "--blind", 0, "--out", "x")

    def test_the_schema_has_the_methods(self):
        schema = json.loads((ROOT / "tools/schema/toliman-experiment-1.schema.json").read_text())
        self.assertEqual(sorted(schema["$defs"]["method"]["enum"]), sorted(METHODS))

    # promise: foreign-files-need-force
    def test_foreign_files_are_kept(self):
        """Before the work; those of an earlier experiment are replaced."""
        for name in ("experiment.csv", "experiment.md", "experiment.json"):
            (self.folder / "x").mkdir(exist_ok=True)
            (self.folder / "x" / name).write_text("notes")
            self.refuse(6, f"x/{name}: ", arguments=self.SHORT)
            self.succeed(*self.SHORT, "--force")
            self.succeed(*self.SHORT)
            self.assertNotIn("notes", (self.folder / "x" / name).read_text())


class Refusals(Experiment):
    def test_options(self):
        for text, *options in (
                *((f"{word}: ", f"--amplitudes={word}") for word in ("0", "-1e-6", "0.2", "nan", "1e-6x")),
                ("1e-6: ", "--amplitudes", "1e-6,1e-6"), ("--methods: magic: ", "--methods", "magic"),
                ("tamplate: ", "--methods", "cae,tamplate"), ("real?", "--tables", "reel"), ("cae: ", "--methods", "cae,cae"),
                ("--tables", "--tables", "weekly"), ("--controls", "--controls", "some"),
                *((option[:7], option) for option in ("--seeds=0", "--seeds=x", "--blind=-1"))):
            self.refuse(2, text, arguments=("experiment", "tiny.json", "--out", "x", *options))
        self.refuse(2, "--out", arguments=("experiment", "tiny.json"))
        self.refuse(6, "no/x: ", arguments=("experiment", "tiny.json", "--out", "no/x", "--tables", "real"))

    def test_scenes(self):
        single = tiny_scene()
        del single["stars"]["B"]
        single["binary"]["offsets_px"] = {"A": [0, 0]}
        for change, text in (({"signal": {"kind": "none"}}, "tiny.json: signal: "), (single, "tiny.json: stars.B: "),
                             ({"noise": {"photon": False, "read_e": 5}}, "tiny.json: noise.photon = false: "),
                             ({"cadence": {**tiny_scene()["cadence"], "frames": 4}}, "cadence.frames = 4: "),
                             ({"detector": {"shape": [64, 64], "pixel_scale_arcsec": -1}}, "detector.pixel_scale_arcsec = -1")):
            self.write({**tiny_scene(), **change})
            self.refuse(2, text, arguments=("experiment", "tiny.json", "--out", "x"))


if __name__ == "__main__":
    unittest.main()
