"""toliman run --controls: what is left out, what stays the same; and the same bits on one processor."""
import json
import os
import unittest

import numpy
from program import ProgramTest
from shared_run import FRAMES, SEED, scene_of, shared_run

UNKNOWN = ("latent_sigma_px", "efficiency", "efficiency_error", "no_signal", "untrained")


class Controls(ProgramTest):
    def setUp(self):
        super().setUp()
        self.full = shared_run()
        self.full_result = json.loads((self.full / "result.json").read_text())
        (self.folder / "scene.json").write_text(json.dumps(scene_of()))

    def check_same_files(self, folder):
        for name in ("series.csv", "periodogram.csv", "training.csv", "displacement.csv", "weights.tlmw"):
            self.assertEqual((folder / name).read_bytes(), (self.full / name).read_bytes(), name)
        images = sorted(path.name for path in (self.full / "images").iterdir())
        self.assertEqual(sorted(path.name for path in (folder / "images").iterdir()), images)
        for name in images:
            self.assertEqual((folder / "images" / name).read_bytes(), (self.full / "images" / name).read_bytes(), name)

    def check_same_result(self, result, *others):
        """All keys but those that the controls, time and place of the run change."""
        free = {"controls", "provenance", "scene_folder", "template", "fit", "timings", *others}
        for key in self.full_result.keys() - free:
            self.assertEqual(result[key], self.full_result[key], key)

    def test_none(self):
        text = self.succeed("run", "scene.json", "--seed", SEED, "--controls", "none", "--out", "x")
        self.assertIn("; efficiency not defined\n", text)
        self.assertIn("controls      none: no frames without signal, no untrained network\n", text)
        self.assertNotIn("sigma", text)
        result = json.loads((self.folder / "x" / "result.json").read_text())
        self.assertEqual((result["controls"], self.full_result["controls"]), ("none", "full"))
        self.assertEqual([result[key] for key in UNKNOWN], [None] * len(UNKNOWN))
        self.assertEqual(result["template"], {**self.full_result["template"], "sigma_px": None})
        self.assertIsNone(result["fit"])
        self.check_same_result(result, *UNKNOWN)
        self.check_same_files(self.folder / "x")

    def test_quick(self):
        """The scatter is that of frames 20 ... 219 of the scene without signal, encoded by the network of the run."""
        result = json.loads(self.succeed("run", "scene.json", "--seed", SEED, "--controls", "quick", "--json", "--out", "x"))
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

    def test_one_processor(self):
        one = min(os.sched_getaffinity(0))
        self.succeed("run", "scene.json", "--seed", SEED, "--controls", "none", "--out", "x",
                     preexec_fn=lambda: os.sched_setaffinity(0, {one}))
        self.check_same_files(self.folder / "x")

    def test_refused(self):
        self.refuse(2, "--controls", "some", "must be one of none, quick, full", arguments=("run", "scene.json", "--controls", "some"))


if __name__ == "__main__":
    unittest.main()
