"""toliman run: the whole job on the chapter's scene, every figure and control of its result; what is left out with --controls;
scenes that it cannot take, and a folder that holds the results of another run."""
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import time
import unittest

import numpy
from program import PATIENCE, PROGRAM, SCENES, ProgramTest, long, one_wavelength
from shared_run import FRAMES, SCENE, SEED, rows_of, scene_of, shared_run

UNKNOWN = ("latent_sigma_px", "efficiency", "efficiency_error", "no_signal", "untrained")


class ChapterRun(ProgramTest):
    def test_files(self):
        """Of the run that tests share; test_quick has what is printed."""
        files = shared_run()
        self.assertEqual(sorted(p.name for p in files.iterdir()), ["periodogram.csv", "result.json", "scene.json", "series.csv", "training.csv", "weights.tlmw"])
        result = json.loads((files / "result.json").read_text())
        self.assertEqual((result["schema"], result["seed"], result["frames"]), ("toliman-run/2", SEED, FRAMES))
        self.assertEqual((result["estimator"], result["fit"]), ("network", None))
        self.assertEqual(
            set(result["timings"]),
            {"setup_s", "train_s", "simulate_s", "encode_s", "fit_s", "period_s", "controls_s", "total_s"},
        )
        series, power = (rows_of(files / f"{name}.csv") for name in ("series", "periodogram"))
        self.assertEqual(list(series), ["frame", "t", "true", "latent", "template"])
        self.assertEqual((len(series["t"]), len(power["power"])), (FRAMES, result["grid"]["nf"]))
        self.assertEqual(list(power), ["frequency", "power", "template", "true"])
        for column, period in (("power", result["period_days"]), ("template", result["template"]["period_days"]),
                               ("true", result["true_series"]["period_days"])):
            self.assertAlmostEqual(power["frequency"][power[column].argmax()], 1 / period, delta=result["grid"]["df"])
        self.check_what_a_report_needs(files, result)

    @long
    def test_figures_of_the_chapter(self):
        result = json.loads(self.succeed("run", SCENES / "chapter.json", "--seed", "3", "--out", "results", "--json"))
        self.assertEqual((result["scene"], result["seed"], result["frames"]), ("chapter", 3, 1095))
        self.assertAlmostEqual(result["amplitude_uas"], 0.2, delta=1e-12)  # 1e-6 px of 0.2 arcsec
        self.assertAlmostEqual(result["crb_px"], 1.239e-6, delta=0.01e-6)
        self.assertLess(abs(result["period_days"] / 365 - 1), 0.04)  # one seed; the median of many is below 1.5 %
        self.assertLess(result["log10_fap"], -40)
        # With 2,000 frames a sigma is known to 1.6 %: three of those on either side.
        self.assertGreater(result["efficiency"], 0.94 * 0.95)
        self.assertLess(result["efficiency"], 1.05)
        self.assertGreater(result["no_signal"]["log10_fap"], -3)
        self.assertGreater(result["untrained"]["log10_fap"], -3)
        self.assertAlmostEqual(result["template"]["sigma_px"] / result["crb_px"], 1, delta=0.05)
        self.assertAlmostEqual(result["mmse"] / result["photon_floor"], 1, delta=0.01)
        self.assertGreater(result["mssim"], 1 - 1e-7)
        self.assertGreater(result["decoder"]["cosine"], 0.95)
        self.assertAlmostEqual(result["decoder"]["gain"], 1, delta=0.05)
        series = rows_of(self.folder / "results" / "series.csv")
        slope = (series["latent"] * series["true"]).sum() / (series["true"] ** 2).sum()
        self.assertAlmostEqual(slope, 1, delta=0.25)  # in pixels, right sign; sigma of the slope is 0.055
        self.check_truth(result)

    def check_truth(self, result):
        """The chapter's Table 1 has 0.33 +- 0.05 of the time span; Baluev's FAP of 1e-3 is one that noise rarely has."""
        truth = result["true_series"]
        self.assertAlmostEqual(truth["period_days"], 365, delta=1e-3)
        self.assertAlmostEqual(truth["half_width_period_days"] / 1095, 0.0499, delta=2e-4)
        self.assertLess(truth["log10_fap"], -16000)
        # exp(-N P/2) of some 550 independent frequencies is 1e-3
        self.assertAlmostEqual(result["power_at_fap_1e-3"], 2 / 1095 * math.log(550e3), delta=0.004)

    def check_what_a_report_needs(self, files, result):
        scene = files.parent / SCENE
        self.assertEqual((files / "scene.json").read_bytes(), scene.read_bytes())
        self.assertEqual(pathlib.Path(result["scene_folder"]), files.parent)
        losses = rows_of(files / "training.csv")["loss"]
        self.assertEqual(len(losses), 300)
        self.assertAlmostEqual(math.sqrt(1 - losses[-1]), result["cosine"], delta=1e-3)
        self.assertGreater(losses[0], 0.9)
        self.succeed("simulate", scene, "--seed", SEED, "--frames", "0:2", "--out", "f.npy")
        latents = self.succeed("encode", "--weights", files / "weights.tlmw", "f.npy").splitlines()[-2:]
        self.assertEqual([float(line.split(",")[2]) for line in latents], rows_of(files / "series.csv")["latent"][:2].tolist())

    def test_the_default_folder_stays_here(self):
        scene = json.loads((SCENES / "chapter.json").read_text())
        inside = self.folder / "inside"
        inside.mkdir()
        for name in ("../escaped", "/escaped", ".hidden", "a/b", ""):
            scene["name"] = name
            (inside / "scene.json").write_text(json.dumps(scene))
            self.refuse(2, "scene.json: name = ", arguments=("run", "inside/scene.json"))


class Controls(ProgramTest):
    def setUp(self):
        super().setUp()
        self.full = shared_run()
        self.full_result = json.loads((self.full / "result.json").read_text())
        (self.folder / "scene.json").write_text(json.dumps(scene_of()))

    def check_same_files(self, folder):
        for name in ("series.csv", "periodogram.csv", "training.csv", "weights.tlmw"):
            self.assertEqual((folder / name).read_bytes(), (self.full / name).read_bytes(), name)

    def check_same_result(self, result, *others):
        """All keys but those that the controls, time and place of the run change."""
        free = {"controls", "provenance", "scene_folder", "template", "fit", "timings", *others}
        for key in self.full_result.keys() - free:
            self.assertEqual(result[key], self.full_result[key], key)

    def test_none_on_one_processor(self):
        one = min(os.sched_getaffinity(0))
        text = self.succeed("run", "scene.json", "--seed", SEED, "--controls", "none", "--out", "x",
                            preexec_fn=lambda: os.sched_setaffinity(0, {one}))
        self.assertEqual(("controls      none: " in text, "sigma" in text), (True, False))
        result = json.loads((self.folder / "x" / "result.json").read_text())
        self.assertEqual((result["controls"], self.full_result["controls"]), ("none", "full"))
        self.assertEqual([result[key] for key in UNKNOWN], [None] * len(UNKNOWN))
        self.assertEqual(result["template"], {**self.full_result["template"], "sigma_px": None})
        self.assertIsNone(result["fit"])
        self.check_same_result(result, *UNKNOWN)
        self.check_same_files(self.folder / "x")

    def test_quick(self):
        """The scatter is that of frames 20 ... 219 of the scene without signal, encoded by the network of the run."""
        out = self.succeed("run", "scene.json", "--seed", SEED, "--controls", "quick", "--json", "--out", "x")
        self.assertEqual(out, (self.folder / "x" / "result.json").read_text())
        result = json.loads(out)
        self.assertEqual((result["controls"], result["no_signal"]["frames"]), ("quick", 200))
        self.check_same_result(result, *UNKNOWN)
        self.check_same_files(self.folder / "x")
        for key in ("no_signal", "untrained"):  # as many frames as the cadence has
            self.assertEqual(result[key]["log10_fap"], self.full_result[key]["log10_fap"])
        still = {**scene_of(cadence={"frames": FRAMES + 200}), "signal": {"kind": "none"}}
        (self.folder / "still.json").write_text(json.dumps(still))
        self.succeed("simulate", "still.json", "--seed", SEED, "--frames", f"{FRAMES}:{FRAMES + 200}", "--out", "f.npy")
        lines = self.succeed("encode", "--weights", "x/weights.tlmw", "f.npy").splitlines()[-200:]
        latents = [float(line.split(",")[2]) for line in lines]
        self.assertAlmostEqual(result["latent_sigma_px"] / numpy.std(latents, ddof=1), 1, delta=1e-9)
        self.assertAlmostEqual(result["efficiency"] * result["latent_sigma_px"] / result["crb_projected_px"], 1, delta=1e-12)
        self.assertAlmostEqual(result["efficiency_error"] / result["efficiency"], 1 / 20, delta=1e-12)

    def test_refused(self):
        self.refuse(2, "--controls some", arguments=("run", "scene.json", "--controls", "some"))


class Scenes(ProgramTest):
    def scene(self, **groups):
        """The chapter's scene at one wavelength and 20 frames, with groups updated."""
        scene = one_wavelength()
        scene["cadence"]["frames"] = 20
        for name, group in groups.items():
            scene[name] = group if group is None else {**scene.get(name, {}), **group}
        (self.folder / "s.json").write_text(json.dumps({k: v for k, v in scene.items() if v is not None}))

    def test_no_noise(self):
        for noise in (None, {"photon": False}):
            self.scene(noise=noise)
            self.refuse(2, "s.json: noise: ", arguments=("run", "s.json"))

    def test_both_noises_a_short_period_and_the_results_of_another_run(self):
        """The scene is gone before the end: the run had read it and keeps it. It replaces the results, not the report."""
        self.scene(cadence={"frames": 60, "interval_days": 1}, signal={"period_days": 2.6, "amplitude_px": 1e-4},
                   noise={"photon": True, "read_e": 5})
        scene, folder = self.folder / "s.json", self.folder / "r"
        text = scene.read_text()
        shutil.copytree(shared_run(), folder)
        (folder / "report").mkdir()
        (folder / "report" / "report.html").write_text("")
        with subprocess.Popen([PROGRAM, "run", "s.json", "--controls", "quick", "--out", "r"], cwd=self.folder,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            while not (folder / "weights.tlmb.0.tmp").exists() and process.poll() is None:
                time.sleep(0.001)
            scene.unlink()
            stdout, stderr = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, 0, stderr)
        self.assertIn("toliman report r\n", stderr)
        self.assertEqual((folder / "scene.json").read_text(), text)
        result = json.loads((folder / "result.json").read_text())
        self.assertAlmostEqual(result["efficiency"], 1, delta=0.15)
        period, error = result["period_days"], result["period_error_days"]
        self.assertLess(error, 0.001)
        decimals = 1 - int(f"{error:.1e}".split("e")[1])
        self.assertIn(f"period found  {period:.{decimals}f} +- {error:.{decimals}f} days, ", stdout)
        template = re.search(r"template .* period ([\d.]+) days", stdout)[1]
        self.assertAlmostEqual(float(template), result["template"]["period_days"], delta=error)
        self.assertGreaterEqual(len(template), 2 + decimals - 1)

    def test_files_of_others(self):
        """One of them in the folder of results, and nothing there is replaced."""
        self.scene()
        folder = self.folder / "r"
        shutil.copytree(shared_run(), folder)
        for name in ("result.json", "series.csv", "weights.tlmw"):
            with self.subTest(name):
                own = (folder / name).read_bytes()
                (folder / name).write_text("notes\n")
                self.refuse(6, f"r/{name}: ", "--force", arguments=("run", "s.json", "--out", "r"))
                (folder / name).write_bytes(own)

    def test_frames(self):
        for frames in (4, 400001):
            self.scene(cadence={"frames": frames})
            self.refuse(2, f"s.json: cadence.frames = {frames}: ", arguments=("run", "s.json"))

    def test_what_the_network_takes(self):
        self.scene(detector={"shape": [127, 256]})
        for command in (["run", "s.json"], ["train", "s.json", "--out", "w"]):
            self.refuse(2, "s.json: detector.shape = [127, 256]: ", arguments=command)
        scene = json.loads((self.folder / "s.json").read_text())
        scene["detector"]["shape"] = [256, 256]
        scene["stars"].pop("B")
        scene.pop("binary")
        scene["preprocess"] = {"project": ["shift_x"]}
        (self.folder / "s.json").write_text(json.dumps(scene))
        for command in (["run", "s.json"], ["train", "s.json", "--out", "w"]):
            self.refuse(2, "s.json: preprocess.project: ", arguments=command)


if __name__ == "__main__":
    unittest.main()
