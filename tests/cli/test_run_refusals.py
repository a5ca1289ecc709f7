"""toliman run and train on scenes that they cannot take, and what run says where an efficiency has no meaning."""
import json
import re
import subprocess
import time
import unittest

from program import PATIENCE, PROGRAM, ProgramTest, one_wavelength


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
            self.refuse(2, "s.json: noise: ", "photon", "read_e above 0 e-", arguments=("run", "s.json"))

    def test_read_noise_only(self):
        """The bound counts photons that these frames do not scatter by: it was an efficiency of 1534."""
        self.scene(noise={"photon": False, "read_e": 5})
        done = self.run_program("run", "s.json", "--out", "results")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("efficiency is not defined", done.stderr)
        self.assertIn("efficiency not defined\n", done.stdout)
        result = json.loads((self.folder / "results/result.json").read_text())
        self.assertIsNone(result["efficiency"])
        self.assertIsNone(result["efficiency_error"])
        self.assertLess(result["latent_sigma_px"], result["crb_px"] / 100)

    def test_both_noises(self):
        """The scene is gone before the end: the run had read it and keeps it."""
        self.scene(noise={"photon": True, "read_e": 5})
        scene = self.folder / "s.json"
        text = scene.read_text()
        kept = self.folder / "kept"
        with subprocess.Popen([PROGRAM, "run", "s.json", "--out", "kept"], cwd=self.folder, stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True) as process:
            while not kept.exists() and process.poll() is None:
                time.sleep(0.001)
            scene.unlink()
            stderr = process.communicate(timeout=PATIENCE)[1]
        self.assertEqual(process.returncode, 0, stderr)
        self.assertEqual((kept / "scene.json").read_text(), text)
        self.assertAlmostEqual(json.loads((kept / "result.json").read_text())["efficiency"], 1, delta=0.15)

    def test_no_significant_period(self):
        self.scene(signal={"amplitude_px": 0})
        done = self.run_program("run", "s.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("highest peak  ", done.stdout)
        self.assertIn(": no significant period\n", done.stdout)
        self.assertNotIn("report", done.stderr)  # there is none of a run before

    def test_a_short_period_and_a_report_of_another_run(self):
        self.scene(cadence={"frames": 60, "interval_days": 1}, signal={"period_days": 2.6, "amplitude_px": 1e-4})
        (self.folder / "r" / "report").mkdir(parents=True)
        (self.folder / "r" / "report" / "report.html").write_text("")
        done = self.run_program("run", "s.json", "--out", "r")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("r/report shows the previous run; update it with: toliman report r\n", done.stderr)
        result = json.loads((self.folder / "r" / "result.json").read_text())
        period, error = result["period_days"], result["period_error_days"]
        self.assertLess(error, 0.001)
        decimals = 1 - int(f"{error:.1e}".split("e")[1])
        self.assertIn(f"period found  {period:.{decimals}f} +- {error:.{decimals}f} days, ", done.stdout)
        template = re.search(r"template .* period ([\d.]+) days", done.stdout)[1]
        self.assertAlmostEqual(float(template), result["template"]["period_days"], delta=error)
        self.assertGreaterEqual(len(template), 2 + decimals - 1)

    def test_frames(self):
        for frames in (4, 400001):
            self.scene(cadence={"frames": frames})
            self.refuse(2, f"s.json: cadence.frames = {frames}: must be in [5, 400000] for run", arguments=("run", "s.json"))

    def test_what_the_network_takes(self):
        self.scene(detector={"shape": [128, 256]})
        for command in (["run", "s.json"], ["train", "s.json", "--out", "w"]):
            self.refuse(2, "s.json: detector.shape = [128, 256]: must be at least [256, 256] px for the network",
                        arguments=command)
        scene = json.loads((self.folder / "s.json").read_text())
        scene["detector"]["shape"] = [256, 256]
        scene["stars"].pop("B")
        scene.pop("binary")
        scene["preprocess"] = {"project": ["shift_x"]}
        (self.folder / "s.json").write_text(json.dumps(scene))
        for command in (["run", "s.json"], ["train", "s.json", "--out", "w"]):
            self.refuse(2, "s.json: preprocess.project: ", "leaves no information about the separation", arguments=command)


if __name__ == "__main__":
    unittest.main()
