"""Fits with free="self": the parameters that are chosen, and separations of frames whose optics and jitter drift. The short
form of drift_campaign.py."""
import copy
import logging
import unittest

import numpy

from package import toliman

SIDE = 48
SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.01875, "pupil_samples": 48, "struts": {"count": 3, "width_m": 0.002},
                  "mask": {"kind": "spiral", "edges": "area", "opd_nm": 297.5, "terms": [{"a": 1, "f": 1.2, "m": -5, "p": 1}]}},
    "band": {"min_nm": 550, "max_nm": 600, "step_nm": 25},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 7.5e9},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2.5e9}},
    "binary": {"date": 2027, "orbit": "alpha-cen", "moving": True},
    "cadence": {"frames": 4, "interval_days": 20, "exposure_s": 10},
    "detector": {"shape": [SIDE, SIDE], "pixel_scale_arcsec": 0.4},
    "noise": {"photon": True, "read_e": 2.5, "seed": 7},
    "accuracy": 1e-7,
}
JITTER = ["jitter_xx", "jitter_yy", "jitter_xy"]
ODD = ["zernike_7", "zernike_8", "zernike_9", "zernike_10"]  # of odd azimuthal order: tilts of the field, not of its symmetry
ALL = [*JITTER, "focus", *(f"zernike_{noll}" for noll in range(5, 12))]


def scene(**changes):
    """The scene with other values: {"telescope.aberrations": ...}."""
    changed = copy.deepcopy(SCENE)
    for name, value in changes.items():
        *groups, key = name.split("__")
        part = changed
        for group in groups:
            part = part[group]
        if value is None:
            part.pop(key)
        else:
            part[key] = value
    return changed


def chosen(of, free="self"):
    return [parameter.name for parameter in toliman.Fit(toliman.Simulator(of), free=free).parameters[7:]]


class SelfCalibration(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        logging.getLogger("toliman").setLevel(logging.ERROR)

    def test_parameters(self):
        """All that a frame determines: without struts not the even aberrations, in faint frames none."""
        for name, of, wanted in (
                ("struts", scene(), ALL),
                ("no struts", scene(telescope__struts=None), [*JITTER, *ODD]),
                ("faint", scene(cadence={"frames": 4, "interval_days": 20, "exposure_s": 1e-7}), [])):
            with self.subTest(name):
                self.assertEqual(chosen(of), wanted)
        self.assertEqual(chosen(scene(), "scale self focus"),
                         ["scale", "focus", *(one for one in ALL if one != "focus")])

    def test_limits(self):
        """A parameter is chosen if the bound of the fit with all candidates is within the limits."""
        for exposure in (1e-3, 3e-5, 1e-5):
            of = scene(cadence={"frames": 4, "interval_days": 20, "exposure_s": exposure})
            names = chosen(of)
            fit = toliman.Fit(toliman.Simulator(of), free=names)
            sigmas = numpy.sqrt(numpy.diag(fit.predict()[2]))[7:]
            limits = [0.02 if name.startswith("jitter") else 5 for name in names]
            self.assertTrue(numpy.all(sigmas < 1.1 * numpy.array(limits)), (exposure, names, sigmas))
            self.assertLess(len(names), 12)

    def test_drift(self):
        """0.4 nm and 3e-4 px^2 of change bias the fit by many standard deviations, and leave that with "self" as it is."""
        drifted = scene(telescope__aberrations={"zernike_rms_nm": {"4": 0.2, "6": -0.2, "8": 0.2, "11": 0.2}},
                        systematics={"jitter_covariance_px2": {"xx": 3e-4, "yy": 1e-4, "xy": 1e-4}})
        frames = toliman.Simulator(drifted).frames()
        truth = toliman.Fit(toliman.Simulator(drifted))
        times = 20.0 * numpy.arange(4)
        exact = numpy.array([truth.predict(time_days=t)[1][0] for t in times])
        model = toliman.Simulator(scene())
        pulls = {}
        for free in ("", "self"):
            found = toliman.Fit(model, free=free).frames(frames, times_days=times)
            pulls[free] = (found["separation_px"] - exact) / found["separation_sigma_px"]
            if free:
                numpy.testing.assert_array_less(found["chi_square"], 1.2)
        self.assertGreater(numpy.abs(pulls[""]).max(), 20)
        self.assertLess(numpy.abs(pulls["self"]).max(), 3.5)


if __name__ == "__main__":
    unittest.main()
