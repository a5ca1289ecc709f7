"""Work that continues in a folder or from a journal while the scene, or a file that it names, has changed: refused by name."""
import copy
import pathlib
import tempfile
import unittest
import warnings

import numpy

from package import toliman
from refusal import refused
import test_camera

SHAPE = test_camera.SCENE["detector"]["shape"]
QE, THROUGHPUT, BAND = "nm,qe\n500,0.7\n700,{}\n", "nm,throughput\n500,0.7\n700,{}\n", "nm,response\n540,0\n560,1\n600,{}\n630,0\n"


def response(seed):
    return 1 + 0.01 * numpy.random.default_rng(seed).standard_normal(SHAPE)


def bad_pixel(place):
    return (numpy.arange(SHAPE[0] * SHAPE[1]) == place).reshape(SHAPE).astype(float)


FILES = {"qe.csv": (QE.format(0.75), QE.format(0.751)), "throughput.csv": (THROUGHPUT.format(0.8), THROUGHPUT.format(0.801)),
         "band.csv": (BAND.format(1), BAND.format(0.99)), "response.npy": (response(1), response(2)),
         "bad.npy": (bad_pixel(200), bad_pixel(300))}
KEYS = ({"diffusion_px": 0.2}, {"transfer_smear": 1e-3}, {"interpixel_capacitance": 1e-3}, {"nonlinearity_per_e": 1e-9},
        {"brighter_fatter_px2_per_e": 1e-9}, {"sidelobe": {"period_um": 15000, "angle_deg": 35, "centre_nm": 575}})


class ChangedFiles(unittest.TestCase):
    def setUp(self):
        self.enterContext(warnings.catch_warnings(action="ignore"))
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        for name, (content, _) in FILES.items():
            self.write(name, content)

    def write(self, name, content):
        if isinstance(content, str):
            (self.folder / name).write_text(content)
        else:
            numpy.save(self.folder / name, content)

    def simulator(self, detector):
        scene = copy.deepcopy(test_camera.SCENE)
        scene["telescope"]["throughput"] = ["throughput.csv"]
        scene["detector"].update(qe="qe.csv", response="response.npy", bad_pixels="bad.npy", **detector)
        for star, magnitude in (("A", 3), ("B", 4)):
            del scene["stars"][star]["photons_per_s"]
            scene["stars"][star].update(magnitude=magnitude, magnitude_band="band.csv", magnitude_system="ab")
        return toliman.Simulator(scene, folder=self.folder)

    def calibrate(self, simulator):
        """Until the first step."""
        toliman.calibrate(simulator, self.frames, free="scale", journal=self.folder / "journal", step=lambda *_: True)

    def track(self, simulator):
        for name, make in (("fit", toliman.Fit), ("template", toliman.Template)):
            toliman.Tracker(make(simulator), 0.001, 0.01, 20, folder=self.folder / name).close()

    def assert_refused(self, detector):
        simulator = self.simulator(detector)
        with refused(toliman.InputError, self.folder / "journal"):
            self.calibrate(simulator)
        for name, make in (("fit", toliman.Fit), ("template", toliman.Template)):
            with self.assertRaisesRegex(toliman.InputError, "ledger.tlml: written with estimator .* a file of the scene"):
                toliman.Tracker(make(simulator), 0.001, 0.01, 20, folder=self.folder / name)

    def test_changes_are_refused(self):
        before = self.simulator({})
        self.frames = before.frames(0, 6)
        with refused(toliman.Cancelled):
            self.calibrate(before)
        self.track(before)
        for name, (content, other) in FILES.items():
            with self.subTest(name):
                self.write(name, other)
                self.assert_refused({})
                self.write(name, content)
        for detector in KEYS:
            with self.subTest(detector):
                self.assert_refused(detector)
        with refused(toliman.Cancelled):  # nothing was lost
            self.calibrate(before)
        self.track(before)


if __name__ == "__main__":
    unittest.main()
