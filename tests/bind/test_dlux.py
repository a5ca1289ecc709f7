"""toliman.dlux: scenes from the parameters of dLuxToliman, against scenes converted by hand and dLux's formulas."""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import warnings

import numpy

import toliman
from toliman import dlux

TERMS = [{"a": 0.819, "f": 2.918, "l": 0, "m": -27, "p": 4.874}, {"a": 0.93, "f": 1.829, "l": 0, "m": 25, "p": 5.967},
         {"a": 0.702, "f": 9.468, "l": 10.905, "m": -27, "p": 4.193}]
LINES = {"kind": "lines", "wavelength_nm": [530, 585, 640], "weight": [1, 1, 1]}
# AlphaCen(separation=8, position_angle=30, log_flux=7.832) behind TolimanOpticalSystem(), converted by hand.
BY_HAND = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.032, "struts": {"count": 3, "width_m": 0.002, "angle_deg": 30},
                  "pupil_samples": 256, "mask": {"kind": "spiral", "opd_nm": 292.5, "terms": TERMS}},
    "stars": {"A": {"spectrum": LINES, "photons_per_s": 52377946.039357245},
              "B": {"spectrum": LINES, "photons_per_s": 15542417.222361198}},
    "binary": {"offsets_px": {"A": [5.333333333333332, 9.237604307034012], "B": [-5.333333333333332, -9.237604307034012]}},
    "cadence": {"frames": 1, "exposure_s": 1},
    "detector": {"shape": [128, 128], "pixel_scale_arcsec": 0.375, "pixel": "integrated"}}
PACKAGES = str(pathlib.Path(toliman.__file__).resolve().parent.parent)
SOURCE = {"separation": 8, "position_angle": 30, "log_flux": 7.832}


def converted(**classes):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return dlux.scene({"AlphaCen": SOURCE, **classes})


def zernike(noll, x, y):
    """Noll's polynomials 2 to 11 written out."""
    r2 = x * x + y * y
    return {2: 2 * x, 3: 2 * y, 4: math.sqrt(3) * (2 * r2 - 1), 5: math.sqrt(6) * 2 * x * y, 6: math.sqrt(6) * (x * x - y * y),
            7: math.sqrt(8) * (3 * r2 - 2) * y, 8: math.sqrt(8) * (3 * r2 - 2) * x,
            9: math.sqrt(8) * (3 * x * x * y - y**3), 10: math.sqrt(8) * (x**3 - 3 * x * y * y),
            11: math.sqrt(5) * (6 * r2 * r2 - 6 * r2 + 1)}[noll]


class PhotonBudget(unittest.TestCase):
    """The photon counts of dLuxToliman: 1.128e6 and 3.524e5 photons/s/cm2 of 0.01 and 1.33 mag in V from 530 to 640 nm, by
    pysynphot and Phoenix models of 5790 and 5260 K; behind band, glass and detector 6.342e5 and 1.967e5."""

    def test_shipped_scenes_have_the_electrons(self):
        area = math.pi / 4 * (12.5**2 - 3.2**2)
        for name in ("mission", "sky"):
            electrons = toliman.plan(f"{name}.json").electrons_per_s
            for found, per_area in zip(electrons, (6.342e5, 1.967e5)):
                self.assertAlmostEqual(found / (per_area * area), 1, delta=2e-3)

    def test_magnitudes_give_the_photons(self):
        """Black bodies of these temperatures differ from the models by less than 3 %."""
        scene = json.loads(next(path for path in toliman.shipped_scenes() if path.name == "mission.json").read_text(encoding="utf-8"))
        scene["telescope"]["struts"] = {"count": 0, "width_m": 0.002}
        scene["stars"] = {star: {"spectrum": {"kind": "blackbody", "temperature_k": kelvin}, "magnitude": magnitude,
                                 "magnitude_band": "V"}
                          for star, kelvin, magnitude in (("A", 5790, 0.01), ("B", 5260, 1.33))}
        plan = toliman.plan(scene)
        self.assertAlmostEqual(plan.open_area_m2 * 1e4, 114.67, delta=0.01)
        for found, per_area, error in zip(plan.photons_per_s, (1.128e6, 3.524e5), (2e-3, 0.03)):
            self.assertAlmostEqual(found / (per_area * plan.open_area_m2 * 1e4), 1, delta=error)


class Dlux(unittest.TestCase):
    def assert_same(self, found, expected, place="scene"):
        if isinstance(expected, dict):
            self.assertEqual(sorted(found), sorted(expected), place)
            for key, value in expected.items():
                self.assert_same(found[key], value, f"{place}.{key}")
        elif isinstance(expected, list):
            self.assertEqual(len(found), len(expected), place)
            for i, value in enumerate(expected):
                self.assert_same(found[i], value, f"{place}[{i}]")
        elif isinstance(expected, float):
            self.assertAlmostEqual(found / expected, 1, delta=1e-12, msg=place)
        else:
            self.assertEqual(found, expected, place)

    def test_scenes_converted_by_hand(self):
        self.assert_same(converted(), BY_HAND)
        optics = {"noll_indices": [4, 5, 6, 7, 8], "coefficients": [5e-9, -3e-9, 2e-9, 4e-9, -6e-9], "z_oversize": 1}
        found = converted(TolimanOpticalSystem=optics, AlphaCen={**SOURCE, "x_position": 0.1, "y_position": -0.05},
                          GaussianJitter={"r": 0.01, "shear": 0.3, "phi": 45})
        self.assert_same(found["telescope"]["aberrations"], {"zernike_rms_nm": {"4": 5.0, "5": -3.0, "6": 2.0, "7": 4.0, "8": -6.0}})
        self.assert_same(found["binary"], {"offsets_px": {"A": [5.599999999999999, 9.104270973700679],
                                                          "B": [-5.0666666666666655, -9.370937640367345]}})
        self.assert_same(found["systematics"], {"jitter_covariance_px2": {
            "xx": 0.6332055565895989, "yy": 0.6332055565895988, "xy": 0.21673478782597014}})

    def test_scenes_are_read(self):
        """The product puts the stars and the light where dLuxToliman does."""
        found = converted(TolimanOpticalSystem={"wf_npixels": 128, "psf_npixels": 64, "radial_orders": [2], "z_oversize": 1.01,
                                                "coefficients": [1e-9, 0, -2e-9]},
                          GaussianJitter={"r": 1e-3}, Downsample={"kernel_size": 4})
        with toliman.Simulator(found) as simulator:
            self.assertEqual(simulator.info.unit, "photon")
            self.assertAlmostEqual(simulator.info.separation_px, 8 / 0.375, delta=1e-12)
            self.assertAlmostEqual(simulator.info.flux_ratio, 3.37, delta=1e-12)
            a = simulator.image("star_a")
            row, column = numpy.unravel_index(numpy.argmax(a), a.shape)
            self.assertGreater(row, 32)
            self.assertGreater(column, 32)

    def test_with_a_camera(self):
        """The response of dLuxToliman's scene and a transfer smear that is added to it: as by hand, and as numpy reads out."""
        side = BY_HAND["detector"]["shape"][0]
        response = 1 + 0.01 * numpy.random.default_rng(1).standard_normal((side, side))
        with tempfile.TemporaryDirectory() as folder:
            numpy.save(pathlib.Path(folder) / "flat.npy", response)
            found = converted(ApplyPixelResponse={"pixel_response": "flat.npy"})
            found["detector"]["transfer_smear"] = 1e-3
            camera = {"response": "flat.npy", "transfer_smear": 1e-3}
            by_hand = {**BY_HAND, "detector": {**BY_HAND["detector"], **camera}}
            image, expected = (toliman.Simulator(one, folder=folder).image() for one in (found, by_hand))
            light = response * toliman.Simulator(BY_HAND).image()
        numpy.testing.assert_allclose(image, expected, rtol=0, atol=1e-12 * expected.max())
        numpy.testing.assert_allclose(image, light + 1e-3 * light.sum(axis=0), rtol=0, atol=1e-12 * expected.max())

    def test_oversized_polynomials(self):
        x, y = numpy.random.default_rng(1).uniform(-0.7, 0.7, (2, 50))
        for noll in range(4, 12):
            found = converted(TolimanOpticalSystem={"noll_indices": [noll], "coefficients": [1e-9], "z_oversize": 1.01})
            terms = found["telescope"]["aberrations"]["zernike_rms_nm"]
            surface = sum(value * zernike(int(j), x, y) for j, value in terms.items())
            expected = zernike(noll, x / 1.01, y / 1.01)
            self.assertLess(numpy.ptp(surface - expected), 1e-12, noll)  # apart from piston

    def test_smear(self):
        for given, expected in (
                ({"JitteredToliman": {"jitter_mag": 0.75, "jitter_angle": 30}}, ("linear", 2.0, 30)),
                ({"JitteredToliman": {"jitter_mag": 0.75, "jitter_angle": 30, "jitter_shape": "shm", "n_psfs": 9}},
                 ("harmonic", 2.0, 30)),
                ({"SHMJitter": {"A": 0.75, "phi": 90}}, ("harmonic", 4.0, 90))):
            smear = converted(**given)["systematics"]["smear"]
            self.assertEqual(smear, dict(zip(("kind", "length_px", "angle_deg"), expected)))

    def test_refusals(self):
        for given, name in (
                ({"TolimanSpikes": {}}, "TolimanSpikes"), ({"MixedAlphaCen": {}}, "MixedAlphaCen"),
                ({"Optics": {}}, "Optics"), ({"AlphaCen": []}, "AlphaCen"), ({"AlphaCen": {}}, "AlphaCen.log_flux"),
                ({"AlphaCen": {**SOURCE, "seperation": 9}}, "AlphaCen.seperation"),
                ({"AlphaCen": {**SOURCE, "contrast": "3"}}, "AlphaCen.contrast"),
                ({"AlphaCen": {**SOURCE, "weights": [[1, 1, 1]]}}, "AlphaCen.weights"),
                ({"TolimanOpticalSystem": {"noll_indices": [4], "coefficients": [1e-9]}}, "TolimanOpticalSystem.z_oversize"),
                ({"TolimanOpticalSystem": {"noll_indices": [4], "coefficients": [1, 2]}}, "TolimanOpticalSystem.coefficients"),
                ({"TolimanOpticalSystem": {"n_struts": 4}}, "TolimanOpticalSystem.n_struts"),
                ({"TolimanOpticalSystem": {"psf_npixels": 12.5}}, "TolimanOpticalSystem.psf_npixels"),
                ({"TolimanOpticalSystem": {"mask": [[0]]}}, "TolimanOpticalSystem.mask"),
                ({"GaussianJitter": {"r": 1, "shear": 1}}, "GaussianJitter.shear"),
                ({"GaussianJitter": {}}, "GaussianJitter.r"),
                ({"JitteredToliman": {"jitter_mag": 1, "jitter_angle": 0, "jitter_shape": "x"}}, "JitteredToliman.jitter_shape"),
                ({"SHMJitter": {"A": 1, "phi": 30}}, "SHMJitter.phi"),
                ({"SHMJitter": {"A": 1, "phi": 0}, "JitteredToliman": {"jitter_mag": 1, "jitter_angle": 0}}, "SHMJitter"),
                ({"ApplyPixelResponse": {"pixel_response": [[1]]}}, "ApplyPixelResponse.pixel_response")):
            with self.subTest(name), self.assertRaises(ValueError) as caught:
                converted(**given)
            self.assertEqual(str(caught.exception).split(":")[0], name)

    def test_program(self):
        with tempfile.TemporaryDirectory() as folder:
            work = pathlib.Path(folder)
            (work / "out").mkdir()
            (work / "in.json").write_text(json.dumps({
                "AlphaCen": SOURCE, "TolimanOpticalSystem": {"mask": "mask.npy"},
                "ApplyPixelResponse": {"pixel_response": "flat.npy"}}), encoding="utf-8")

            def run(source, target):
                return subprocess.run([sys.executable, "-m", "toliman.dlux", source, target], cwd=work, check=False,
                                      capture_output=True, text=True, env={**os.environ, "PYTHONPATH": PACKAGES})
            done = run("in.json", "out/scene.json")
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "out/scene.json\n", ""))
            made = json.loads((work / "out" / "scene.json").read_text(encoding="utf-8"))
            self.assertEqual(made["telescope"]["mask"], {"kind": "file", "quantity": "opd_m", "file": "../mask.npy"})
            self.assertEqual(made["detector"]["response"], "../flat.npy")
            (work / "plain.json").write_text(json.dumps({"AlphaCen": SOURCE}), encoding="utf-8")
            self.assertIn("mask of mission.json", run("plain.json", "s.json").stderr)
            (work / "bad.json").write_text('{"AlphaCen": {}}', encoding="utf-8")
            self.assertEqual(run("bad.json", "s.json").returncode, 2)
            self.assertIn("bad.json: AlphaCen.log_flux: is missing", run("bad.json", "s.json").stderr)
            (work / "text.json").write_text("[", encoding="utf-8")
            self.assertEqual(run("text.json", "s.json").returncode, 3)
            self.assertEqual(run("none.json", "s.json").returncode, 3)


if __name__ == "__main__":
    unittest.main()
