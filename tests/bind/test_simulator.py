"""Tests Simulator in Python: the same frames as the program's, images as the header describes them, scenes as
dicts."""
import copy
import errno
import json
import logging
import math
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

from package import ROOT, toliman
from refusal import refused

SCENES = ROOT / "examples" / "scenes"
ROWS, COLS = 260, 270  # not square, so that exchanged rows and columns are detected


def scene(**changes):
    """The chapter's scene with other members at the top level."""
    found = json.loads((SCENES / "chapter.json").read_text())
    found["detector"]["shape"] = [ROWS, COLS]
    found["telescope"]["pupil_samples"] = 128
    return {**found, **changes}


class Frames(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.simulator = toliman.Simulator(scene())
        cls.addClassCleanup(cls.simulator.close)

    def test_frames_equal_the_program_s(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            (path / "scene.json").write_text(json.dumps(scene()))
            subprocess.run([os.environ["TOLIMAN"], "simulate", path / "scene.json", "--frames", "7:80", "--out",
                            path / "frames.npy"], check=True, stderr=subprocess.DEVNULL)
            theirs = numpy.load(path / "frames.npy")
        ours = self.simulator.frames(7, 73)
        self.assertEqual(ours.shape, (73, ROWS, COLS))
        self.assertTrue((ours == theirs).all())
        self.assertTrue((self.simulator.frame(79) == ours[72]).all())
        self.assertFalse((self.simulator.frame(79, seed=2) == ours[72]).all())

    def test_exposures_are_frames(self):
        expected = numpy.array([self.simulator.expect(step) for step in (0.01, -0.02)])
        frames = self.simulator.frames(7, displacements=[0.01, -0.02])
        self.assertTrue((self.simulator.expose(expected, 7) == frames).all())
        self.assertTrue((self.simulator.expose(expected[1], 8) == frames[1]).all())
        self.assertFalse((self.simulator.expose(expected, 7, seed=2) == frames).all())
        with self.assertRaisesRegex(ValueError, "shape"):
            self.simulator.expose(expected[:, :-1])

    def test_all_frames_by_default(self):
        few = toliman.Simulator(scene(cadence={**scene()["cadence"], "frames": 3}))
        frames = few.frames()
        self.assertEqual(len(frames), 3)
        self.assertTrue((few.frames(1) == frames[1:]).all())
        self.assertTrue((few.frames(2, displacements=[0.01])[0] == few.frame(2, displacement=0.01)).all())
        moved = numpy.linspace(-0.01, 0.01, 70)  # more than are passed to C at a time
        self.assertTrue((few.frames(0, displacements=moved)[69] == few.frame(69, displacement=0.01)).all())
        self.assertEqual(few.frames(0, 0).shape, (0, ROWS, COLS))
        with refused(toliman.InputError, "first"):
            few.frames(2, 2)

    def test_series_is_the_scene_s_sinusoid(self):
        times, displacements = self.simulator.series()
        info, signal = self.simulator.info, scene()["signal"]
        numpy.testing.assert_array_equal(times, numpy.arange(info.frames))
        expected = info.amplitude_px * numpy.sin(2 * numpy.pi * times / info.period_days + signal.get("phase_rad", 0))
        numpy.testing.assert_allclose(displacements, expected, atol=1e-20)
        numpy.testing.assert_array_equal(self.simulator.series(5, 2)[1], displacements[5:7])

    def test_images_are_derivatives(self):
        step = 1e-3
        moved = self.simulator.propagate(step) - self.simulator.propagate(-step)
        derivative = self.simulator.image("separation")
        self.assertLess(abs(moved / (2 * step) - derivative).max(), 1e-4 * abs(derivative).max())
        both = self.simulator.image()
        numpy.testing.assert_allclose(self.simulator.image("star_a") + self.simulator.image("star_b"), both, rtol=1e-12)
        numpy.testing.assert_allclose(self.simulator.expect(0), both, atol=1e-9 * both.max())
        self.assertEqual(both.shape, (ROWS, COLS))

    def test_derivatives_by_name(self):
        parameters = {parameter.name: parameter for parameter in toliman.parameters()}
        self.assertEqual((parameters["zernike_7"].unit, parameters["zernike_7"].scope), ("nm", "instrument"))
        self.assertEqual((parameters["roll"].unit, parameters["roll"].scope), ("rad", "frame"))
        numpy.testing.assert_array_equal(self.simulator.derivative("separation"), self.simulator.image("separation"))
        self.assertTrue(self.simulator.derivative("zernike_7").any())
        with refused(toliman.InputError, "name"):
            self.simulator.derivative("zernike_77")
        with refused(toliman.UnsupportedError):
            self.simulator.derivative("mask_rotation")

    def test_derivatives_between_nodes_of_wavelengths(self):
        """Of spectra with so many wavelengths, or so far apart, that images are interpolated between nodes."""
        scene = json.loads((ROOT / "examples" / "scenes" / "mission.json").read_text())
        scene["detector"]["shape"] = [128, 128]
        scene["telescope"]["pupil_samples"] = 128
        del scene["telescope"]["mask"]
        scene["stars"]["B"]["spectrum"] = {"kind": "blackbody", "temperature_k": 5260}
        step = 1e-3

        def changed(star):
            other = copy.deepcopy(scene)
            other["stars"]["A"]["spectrum"] = star
            return toliman.Simulator(other)

        def compare(name, at, distance, tolerance):
            derivative = changed(at(0)).derivative(name)
            difference = (changed(at(distance)).image() - changed(at(-distance)).image()) / (2 * distance)
            error = abs(derivative - difference).max() / abs(derivative).max()
            self.assertLess(error, tolerance, name)

        def shaped(coefficients):
            return {"kind": "blackbody", "temperature_k": 5790, "modes": coefficients}
        compare("spectrum_a_1", lambda d: shaped([d]), step, 1e-6)
        compare("spectrum_a_11", lambda d: shaped([0] * 10 + [d]), step, 1e-6)
        compare("temperature_a", lambda d: {"kind": "blackbody", "temperature_k": 5790 + d}, 1, 1e-6)
        with refused(toliman.InputError, "stars.A.spectrum.modes"):
            changed(shaped([1]))
        scene.pop("band")
        scene["stars"].pop("B")
        scene.pop("binary")
        for lines in ([500, 700], [585]):
            compare("wavelength", lambda d, lines=lines: {"kind": "lines", "wavelength_nm": [nm + d for nm in lines],
                                                           "weight": [1] * len(lines)}, 0.01, 1e-5)

    def test_gradient_by_the_opd(self):
        """With the defocus of each cell, from the OPD of another scene, it is the transpose of the derivative."""
        aberrated = scene(band={"wavelength_nm": 575})
        aberrated["telescope"]["aberrations"] = {"zernike_rms_nm": {"6": 20, "4": 1000}}
        unfocused = toliman.Simulator(aberrated).pupil()[1]
        aberrated["telescope"]["aberrations"] = {"zernike_rms_nm": {"6": 20}}
        simulator = toliman.Simulator(aberrated)
        weights = numpy.random.default_rng(3).normal(size=simulator.shape)
        product = weights * simulator.derivative("focus")
        by_cell = (unfocused - simulator.pupil()[1]) / 1000 * simulator.opd_gradient(weights)
        self.assertAlmostEqual(by_cell.sum(), product.sum(), delta=1e-12 * abs(product).sum())
        with refused(ValueError, "weights"):
            simulator.opd_gradient(weights[1:])

    def test_stars_are_at_their_offsets(self):
        """The brightest pixel of star A's image must be at the star's offset."""
        clear = scene()
        del clear["telescope"]["mask"]
        simulator = toliman.Simulator(clear)
        image, (x, y) = simulator.image("star_a"), simulator.offsets()[0]
        row, column = numpy.unravel_index(image.argmax(), image.shape)
        self.assertLessEqual(abs(row - ((ROWS - 1) / 2 + y)), 1)
        self.assertLessEqual(abs(column - ((COLS - 1) / 2 + x)), 1)

    def test_pupil_and_spectrum(self):
        amplitude, opd = self.simulator.pupil()
        self.assertEqual((amplitude.shape, opd.shape), ((128, 128), (128, 128)))
        obscured = scene()["telescope"]["secondary_m"] / scene()["telescope"]["aperture_m"]
        self.assertAlmostEqual(amplitude.sum() / 128**2, numpy.pi / 4 * (1 - obscured**2), delta=1e-3)  # of its square
        spectrum, info = self.simulator.spectrum(), self.simulator.info
        self.assertEqual(spectrum.wavelength_m.shape, (info.wavelengths,))
        self.assertAlmostEqual(spectrum.weight_a.sum() / spectrum.weight_b.sum(), info.flux_ratio, delta=1e-9)
        self.assertFalse(self.simulator.plate_scale().any())

    def test_plans(self):
        beforehand, plan = toliman.plan(scene()), self.simulator.plan
        self.assertEqual(beforehand.wavelengths, plan.wavelengths)
        self.assertLess(plan.wavelengths, plan.scene_wavelengths)
        self.assertEqual(plan.engine, "matrix_dft")
        self.assertIn("photon noise", self.simulator.stages)
        self.assertNotIn("read noise", self.simulator.stages)
        self.assertEqual(self.simulator.stages, list(beforehand.stages))
        for name, move in (("mission.json", False), ("sky.json", True)):
            self.assertEqual("moving stars" in toliman.plan(SCENES / name).stages, move)
        self.assertEqual(toliman.plan(SCENES / "mission.json").scene_wavelengths,
                         toliman.plan(json.loads((SCENES / "mission.json").read_text()), folder=SCENES).scene_wavelengths)


class Scenes(unittest.TestCase):
    def test_found_by_name(self):
        self.assertEqual([path.name for path in toliman.shipped_scenes()], ["chapter.json", "mission.json", "sky.json"])
        self.assertEqual(toliman.plan("chapter.json").bytes, toliman.plan(str(SCENES / "chapter.json")).bytes)
        for missing in ("here/chapter.json", "no_chapter.json"):
            with self.assertRaises(toliman.NotFoundError) as raised:
                toliman.plan(missing)
            self.assertEqual((raised.exception.filename, raised.exception.errno), (missing, errno.ENOENT))

    def test_numbers_of_numpy(self):
        plain = toliman.plan(scene(accuracy=1e-6))
        self.assertEqual(toliman.plan(scene(accuracy=numpy.float64(1e-6))).wavelengths, plain.wavelengths)
        with refused(TypeError, "scene.accuracy"):
            toliman.plan(scene(accuracy=1j))
        with refused(ValueError, "scene.noise.seed"):
            toliman.plan(scene(noise={"photon": True, "seed": 2**53 + 1}))

    def test_refusals(self):
        with self.assertRaises(ValueError) as raised:
            toliman.Simulator(scene(accuracyy=1))
        error = raised.exception
        self.assertEqual((type(error), error.name, error.status, error.field), (toliman.InputError, "TOLIMAN_E_SCENE", 6, "accuracyy"))
        with refused(ValueError, "scene.accuracy"):
            toliman.Simulator(scene(accuracy=float("nan")))
        faint = scene(cadence={"frames": 2, "interval_days": 1, "peak_photons": 1e-6})  # the least
        toliman.Simulator(faint).close()
        faint["cadence"] = {"frames": 2, "interval_days": 1, "exposure_s": 1e-9}
        for star in faint["stars"].values():
            del star["relative_flux"]
            star["photons_per_s"] = 1.0
        with refused(toliman.InputError, "cadence"):
            toliman.Simulator(faint)
        with refused(ValueError, "folder"):
            toliman.Simulator("chapter.json", folder=".")
        with refused(ValueError, "engine"):
            toliman.Simulator("chapter.json", engine="fast")
        with refused(ValueError, "threads"):
            toliman.Simulator("chapter.json", threads=-1)

    def test_warnings_are_logged(self):
        far = scene()
        far["detector"]["full_well_e"] = 1e6
        with self.assertLogs("toliman", "WARNING") as logs:
            toliman.plan(far)
        self.assertIn("full_well_e", " ".join(logs.output))

    def test_sampling_is_logged(self):
        """Where it is too coarse, and only there: steps of the wavefront of half a wavelength, points lambda/D apart."""
        def logged(defocus_nm, scale, pixel):
            changed = scene()
            changed["telescope"]["aberrations"] = {"zernike_rms_nm": {"4": defocus_nm}}
            changed["detector"].update(pixel_scale_arcsec=scale, pixel=pixel, shape=[64, 64])
            with self.assertLogs("toliman", "WARNING") as logs:
                logging.getLogger("toliman").warning("-")  # assertLogs needs one
                toliman.plan(changed)
            return [word for word in ("OPD", "lambda/D") if word in " ".join(logs.output)]

        steepest = 8 * math.sqrt(3) / scene()["telescope"]["pupil_samples"]  # nm from cell to cell at the edge, per nm rms
        for ratio, words in (0.9, []), (1.1, ["OPD"]):
            self.assertEqual(logged(ratio * 0.5 * scene()["band"]["min_nm"] / steepest, 0.2, "point"), words)
        width = math.degrees(scene()["band"]["max_nm"] * 1e-9 / scene()["telescope"]["aperture_m"]) * 3600
        self.assertEqual([logged(0, ratio * width, pixel) for ratio, pixel in ((0.95, "point"), (1.05, "point"), (1.05, "integrated"))],
                         [[], ["lambda/D"], []])

    def test_dependent_nuisances_are_logged(self):
        star = {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}}}
        single = scene(stars=star, binary={"offsets_px": {"A": [4, 0]}}, band={"wavelength_nm": 580},
                       preprocess={"project": ["shift_y", "roll"]})
        single["signal"] = {"kind": "sinusoid", "star": "A", "amplitude_px": 1e-6, "period_days": 365}
        single["detector"]["shape"] = [256, 256]
        with toliman.Simulator(single) as simulator:
            for make in (toliman.Template, toliman.CAE, toliman.Components):
                with self.assertLogs("toliman", "WARNING") as logs:
                    make(simulator).close()
                self.assertEqual([record.getMessage() for record in logs.records], [
                    "scene: preprocess.project: roll is a combination of shift_y (1.00): it is dropped"])


if __name__ == "__main__":
    unittest.main()
