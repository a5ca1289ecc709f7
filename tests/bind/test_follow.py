"""Tests that the fit follows the stars: their orbit, pointing from 0 to 3 px, roll; and changes of the optics.

For each case: frames over a year of the scene `sky`, with fresh noise, against the Cramer-Rao bound with the same
parameters free; model images of three years against propagation. Long version: TOLIMAN_SEEDS=20."""
import json
import os
import unittest

import numpy

from package import ROOT, toliman

LONG = int(os.environ.get("TOLIMAN_SEEDS", 1)) > 1
FRAMES, AT_ONCE = (1000, 100) if LONG else (40, 20)
POINTING = (0, 0.01, 0.1, 1, 3) if LONG else (0.3,)
CASES = {"0.375 arcsec/px": {}, "0.2 arcsec/px": {"pixel_scale_arcsec": 0.2}, "128x128": {"shape": [128, 128]}, "64x64": {"shape": [64, 64]}}
SCENES = ROOT / "examples" / "scenes"


def sky(detector=None, pointing=0.3, date=2026.5, days=365.25, **more):
    scene = json.loads((SCENES / "sky.json").read_text())
    for part in (scene["telescope"]["mask"], *(star["spectrum"] for star in scene["stars"].values())):
        part["file"] = str(SCENES / part["file"])
    scene["detector"].update(detector or {})
    scene["binary"]["date"] = date
    scene["cadence"].update(frames=FRAMES, interval_days=days / FRAMES)
    scene["systematics"] = {"pointing_rms_px": pointing, "roll_rms_deg": 0.01} if pointing else {}
    for key, value in more.items():
        scene[key] = {**scene[key], **value}
    return scene


def at_rest(places, detector=None, accuracy=1e-13, **more):
    """The same with both stars at given places x, y of A and B (px), all wavelengths propagated."""
    scene = sky(detector, 0, **more)
    scene["accuracy"] = accuracy
    scene["binary"] = {"offsets_px": {"A": list(places[:2]), "B": list(places[2:])}}
    return scene


class Follow(unittest.TestCase):
    def check(self, case, pointing, free=()):
        simulator = toliman.Simulator(sky(CASES[case], pointing))
        fit = toliman.Fit(simulator, free=free)
        times, truth = simulator.series()
        parts = [fit.frames(simulator.frames(first, AT_ONCE, seed=3), times_days=times[first:first + AT_ONCE])
                 for first in range(0, FRAMES, AT_ONCE)]
        results = numpy.concatenate(parts)
        lost = int((results["flags"] & 1).sum())
        bounds = numpy.array([fit.predict(time_days=day)[2][0, 0] ** 0.5 for day in times[::FRAMES // 20]])
        pulls = (results["displacement_px"] - truth) / results["separation_sigma_px"]
        bound = numpy.interp(times, times[::FRAMES // 20], bounds)
        scatter = float(numpy.sqrt(numpy.mean(((results["displacement_px"] - truth) / bound) ** 2)))
        print(f"{case}, pointing {pointing} px: {FRAMES} frames, {lost} lost, scatter {scatter:.3f} of the bound "
              f"{bounds.mean():.3e} px, mean {pulls.mean():+.3f} sigma, largest {abs(pulls).max():.2f}, "
              f"{results['iterations'].mean():.1f} steps, chi-square {results['chi_square'].mean():.5f}")
        self.assertEqual(lost, 0)
        self.assertAlmostEqual(scatter, 1, delta=max(0.05, 3.5 / (2 * FRAMES) ** 0.5))
        self.assertLess(abs(pulls.mean()), max(0.1, 3.5 / FRAMES ** 0.5))
        self.assertLess(abs(pulls).max(), 5)

    def test_pointing(self):
        for case in CASES if LONG else ["64x64"]:
            for pointing in POINTING:
                with self.subTest(case=case, pointing=pointing):
                    self.check(case, pointing)

    def test_model_images(self):
        """Noise-free images, propagated at the stars' places of three years: errors of separation and image."""
        detector = CASES["0.375 arcsec/px" if LONG else "64x64"]
        fit = toliman.Fit(toliman.Simulator(sky(detector, days=1095)))
        errors, worst = [], 0
        for day in numpy.linspace(0, 1090, 12 if LONG else 2):
            shift = 0.3 * numpy.sin(day), 0.3 * numpy.cos(7 * day)
            model, values, _ = fit.predict(time_days=day, shift=shift)
            angle = numpy.radians(values[1])
            share = fit_share(detector)
            apart = values[0] * numpy.array([-numpy.sin(angle), numpy.cos(angle)])
            places = [*(shift - share * apart), *(shift + (1 - share) * apart)]
            image = toliman.Simulator(at_rest(places, detector)).expect(0)
            worst = max(worst, abs(model - image).max() / image.max())
            errors.append(fit.frame(image, time_days=day)[0].displacement_px)
        print(f"model images: largest error of the image {worst:.1e} of the peak, of the separation "
              f"{max(map(abs, errors)):.1e} px")
        self.assertLess(worst, 1e-9)
        self.assertLess(max(map(abs, errors)), 1e-8)

    def test_optics(self):
        """Focus, scale and jitter that differ from the model: followed in each frame, and not followed."""
        detector = CASES["0.375 arcsec/px" if LONG else "64x64"]
        scale = (detector or {}).get("pixel_scale_arcsec", 0.375)
        simulator = toliman.Simulator(sky(detector))
        fits = {"fitted": toliman.Fit(simulator, free=["focus", "scale", "jitter_xx", "jitter_yy", "jitter_xy"]),
                "not": toliman.Fit(simulator)}
        places = [-1.3, -5.2, 4.9, 20.3]
        separation = numpy.hypot(places[2] - places[0], places[3] - places[1])
        changes = {"none": ({}, {}, {}), "focus 1 nm": ({"aberrations": {"zernike_rms_nm": {"4": 1}}}, {}, {}),
                   "scale 1e-5": ({}, {"pixel_scale_arcsec": scale / (1 + 1e-5)}, {}),
                   "jitter 1e-3 px^2": ({}, {}, {"jitter_covariance_px2": {"xx": 1e-3, "yy": 1e-3}})}
        for name, (telescope, changed, jitter) in changes.items():
            image = toliman.Simulator(at_rest(places, {**detector, **changed}, telescope=telescope,
                                              systematics=jitter)).expect(0)
            errors = {}
            for kind, fit in fits.items():
                result = fit.frame(image, separation=separation, position_angle=-numpy.degrees(numpy.arctan2(6.2, 25.5)))[0]
                errors[kind] = result.displacement_px
                if kind == "not":
                    excess = result.chi_square
            print(f"{name}: error {errors['fitted']:+.1e} px if fitted, {errors['not']:+.1e} px if not (chi-square "
                  f"{excess:.3g})")
            self.assertLess(abs(errors["fitted"]), 1e-7, name)
            if "focus" in name or "jitter" in name:
                self.assertGreater(abs(errors["not"]), 1e-6, name)


def fit_share(detector):
    """Of the separation, from the barycentre of the light to A."""
    spectrum = toliman.Simulator(sky(detector)).spectrum()
    fluxes = sum(spectrum.weight_a), sum(spectrum.weight_b)
    return fluxes[1] / sum(fluxes)


if __name__ == "__main__":
    unittest.main()
