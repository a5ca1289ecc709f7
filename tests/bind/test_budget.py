"""Simulator.budget in Python: the numbers of the program, names, errors."""
import json
import math
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

from package import ROOT, toliman
from refusal import refused


def small_scene():
    """The chapter's scene with few samples, wavelengths and pixels."""
    scene = json.loads((ROOT / "examples/scenes/chapter.json").read_text())
    scene["telescope"]["pupil_samples"] = 64
    scene["band"]["step_nm"] = (scene["band"]["max_nm"] - scene["band"]["min_nm"]) / 4
    scene["detector"]["shape"] = [48, 48]
    return scene


class Budget(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.simulator = toliman.Simulator(small_scene())
        cls.addClassCleanup(cls.simulator.close)

    def assert_same(self, ours, theirs):
        """A number of the program, null for one that is not finite."""
        if theirs is None:
            self.assertFalse(math.isfinite(ours))
        else:
            self.assertAlmostEqual(ours, theirs, delta=1e-9 * abs(theirs))

    def test_numbers_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "scene.json"
            path.write_text(json.dumps(small_scene()))
            # with the kernels of this process: a bound with nearly dependent parameters differs by 3e-5 between kernels
            kernels = {**os.environ, "OPENBLAS_CORETYPE": toliman.machine().blas_core}
            theirs = json.loads(subprocess.run(
                [os.environ["TOLIMAN"], "budget", path, "--free", "flux_a,shift_x", "--frames", "4", "--earth-px", "2e-6",
                 "--json"], check=True, capture_output=True, env=kernels).stdout)
        ours = self.simulator.budget(["flux_a", "shift_x"], frames=4, earth_px=2e-6)
        self.assertEqual((ours.summary.earth_px, ours.summary.earth_from, ours.summary.free_count), (2e-6, "the options", 2))
        self.assertEqual([step.name for step in ours.steps], [step["name"] for step in theirs["scene_mask"]["steps"]])
        for step, other in zip(ours.steps, theirs["scene_mask"]["steps"]):
            self.assert_same(step.crb_shared_px, other["crb_shared_px"])
        self.assertEqual(len(ours.rows), len(theirs["scene_mask"]["parameters"]))
        for row, other in zip(ours.rows, theirs["scene_mask"]["parameters"]):
            self.assertEqual((row.name, row.unit, row.is_free), (other["name"], other["unit"], other["free"]))
            if other["bias_px"] is None or abs(other["bias_px"]) > 1e-12:  # no cancellation
                self.assert_same(row.bias_px, other["bias_px"])

    def test_default_is_the_scene_s_projection(self):
        ours = self.simulator.budget()
        self.assertEqual(ours.summary.crb_px, self.simulator.bounds.crb_projected_px)
        numpy.testing.assert_array_equal(numpy.diag(ours.correlations), 1)
        self.assertEqual(self.simulator.budget([]).summary.crb_px, self.simulator.bounds.crb_px)

    def test_errors(self):
        with refused(toliman.InputError, "options->free_names"):
            self.simulator.budget(["shift_z"])
        with refused(toliman.UnsupportedError):
            self.simulator.budget(["mask_rotation"])
        with refused(ValueError, "free"):
            self.simulator.budget("flux_a")
        with refused(ValueError, "frames"):
            self.simulator.budget(frames=-1)


if __name__ == "__main__":
    unittest.main()
