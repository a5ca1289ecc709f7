"""toliman run and train on scenes that they cannot take, and run on a folder that holds the results of another run."""
import json
import re
import shutil
import subprocess
import time
import unittest

from program import PATIENCE, PROGRAM, ProgramTest, one_wavelength
from shared_run import shared_run


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
            while not (folder / "images" / "residuals.npy.0.tmp").exists() and process.poll() is None:
                time.sleep(0.001)
            scene.unlink()
            stdout, stderr = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, 0, stderr)
        self.assertIn("r/report shows the previous run; update it with: toliman report r\n", stderr)
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
        for name in ("result.json", "series.csv", "periodogram.csv", "training.csv", "displacement.csv", "weights.tlmw", "images/frame.npy"):
            with self.subTest(name):
                own = (folder / name).read_bytes()
                (folder / name).write_text("notes\n")
                self.refuse(6, f"r/{name}: exists and was not written by toliman: give --force to replace it\n",
                            arguments=("run", "s.json", "--out", "r"))
                (folder / name).write_bytes(own)

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
