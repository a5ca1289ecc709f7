"""What the report of a run shows of its scene, against plain Fourier sums, simulate, the scene and astropy."""
import datetime
import functools
import json
import math
import shlex
import unittest

import numpy
from astropy.timeseries import LombScargle
from pages import results
from program import ProgramTest
from toliman.report import run_simulation
from shared_run import FRAMES, SCENE, SEED, SIDE, rows_of, scene_of, shared_run

RUN = shared_run()
PICTURES, REASON = run_simulation.simulate(RUN, results.load(RUN / "result.json", "toliman-run/2"))
ARCSEC = math.pi / 180 / 3600
NAMES = ("pupil_amplitude", "pupil_opd", "psf_600nm", "psf_550-600nm", "psf_500-700nm", "expected", "frame", "difference",
         "frames", "reconstructions", "residuals")


class Telescope:
    """Point spread functions by plain sums over the pupil that was written."""

    def __init__(self, amplitude, opd_nm, aperture_m):
        self.amplitude, self.opd = amplitude, numpy.where(amplitude > 0, opd_nm, 0)
        self.step = aperture_m / len(amplitude)
        self.x = (numpy.arange(len(amplitude)) - (len(amplitude) - 1) / 2) * self.step

    def light(self, nm, x_px, y_px, arcsec):
        """Fraction of a star's light in pixels of this size at (x, y) px from the star."""
        field = self.amplitude * numpy.exp(2j * numpy.pi * self.opd / nm)
        scale = arcsec * ARCSEC / (nm * 1e-9)
        columns, rows = (numpy.exp(-2j * numpy.pi * scale * numpy.outer(place, self.x)) for place in (x_px, y_px))
        return abs(rows @ field @ columns.T) ** 2 * (self.step * scale) ** 2 / self.amplitude.sum()


class Images(ProgramTest):
    def setUp(self):
        super().setUp()
        self.result = json.loads((RUN / "result.json").read_text())
        self.images = {name: PICTURES.images[name].values for name in NAMES}
        self.telescope = Telescope(self.images["pupil_amplitude"], self.images["pupil_opd"], 0.125)

    def place(self, name):
        """Coordinates of the columns and of the rows of an image."""
        image, (rows, columns) = PICTURES.images[name], self.images[name].shape[-2:]
        return (image.first_x + image.step * numpy.arange(columns), image.first_y + image.step * numpy.arange(rows))

    def test_all_are_there(self):
        self.assertEqual({path.name for path in RUN.iterdir()}, {
            "periodogram.csv", "result.json", "scene.json", "series.csv", "training.csv", "weights.tlmw"})
        self.assertEqual((set(PICTURES.images), REASON, set(PICTURES.reasons.values())), (set(NAMES), "", {""}))
        for name, values in self.images.items():
            self.assertEqual(numpy.isfinite(values).all(), name != "pupil_opd")
        self.assertEqual([PICTURES.images[name].unit for name in NAMES],
                         ["", "nm"] + 3 * ["fraction of light"] + 5 * ["photons"] + ["sigma of the pixel"])

    def test_pupil(self):
        amplitude, opd = self.images["pupil_amplitude"], self.images["pupil_opd"]
        area = math.pi / 4 * (125**2 - 18.75**2)  # mm^2
        self.assertAlmostEqual(amplitude.sum() * PICTURES.images["pupil_amplitude"].step ** 2 / area, 1, delta=1e-3)
        self.assertEqual(numpy.isnan(opd).tolist(), (amplitude == 0).tolist())
        numpy.testing.assert_allclose(numpy.unique(opd[amplitude > 0].round(9)), [0, 297.5])

    def test_point_spread_functions(self):
        """The chapter's bands, in 1 nm steps, both ends with half weight, photons of a black body."""
        for name, low, high in (("psf_600nm", 600, 600), ("psf_550-600nm", 550, 600), ("psf_500-700nm", 500, 700)):
            nm = numpy.arange(low, high + 1)
            weight = nm**-4.0 / numpy.expm1(1.438776877e7 / (nm * 5790))
            weight[[0, -1]] /= 2
            x, y = self.place(name)
            middle = slice(SIDE // 2 - 4, SIDE // 2 + 4)  # rows
            want = sum(w * self.telescope.light(wave, x, y[middle], 0.2) for w, wave in zip(weight / weight.sum(), nm))
            numpy.testing.assert_allclose(self.images[name][middle], want, rtol=0, atol=3e-6 * want.max())

    def frame_of(self, displacement):
        """The binary without noise at the positions that result.json states; the brightest pixel has 1e9 photons."""
        place, (x, y) = self.result["geometry"], self.place("expected")
        a, b = ([place[f"{star}_{axis}_px"] for axis in "xy"] for star in "ab")
        length = math.hypot(a[0] - b[0], a[1] - b[1])
        a = [a[i] + displacement * (a[i] - b[i]) / length for i in range(2)]  # away from B
        stars = [flux * self.telescope.light(580, x - at[0], y - at[1], 0.2) for flux, at in ((3.12, a), (1, b))]
        return sum(stars)

    def test_frames(self):
        still = self.frame_of(0)
        scale = 1e9 / still.max()
        numpy.testing.assert_allclose(self.images["expected"], scale * still, rtol=0, atol=1e3)
        largest = max(rows_of(RUN / "series.csv")["true"], key=abs)
        change = scale * (self.frame_of(largest) - still)
        numpy.testing.assert_allclose(self.images["difference"], change, rtol=0, atol=1e-3 * abs(change).max())
        self.assertAlmostEqual(self.result["peak_counts"], 1e9, delta=1)
        self.assertAlmostEqual(self.result["peak_sigma"], 1e9**0.5, delta=1)
        self.assertEqual(self.result["unit"], "photons")

    def test_geometry(self):
        """10 arcsec at a position angle of 30 degrees, from north through east."""
        place = self.result["geometry"]
        self.assertEqual((place["aperture_m"], place["pixel_scale_arcsec"]), (0.125, 0.2))
        b_from_a = [place[f"b_{axis}_px"] - place[f"a_{axis}_px"] for axis in "xy"]
        for direction, share in (("north", math.cos(math.radians(30))), ("east", math.sin(math.radians(30)))):
            along = sum(b_from_a[i] * place[f"{direction}_{axis}"] for i, axis in enumerate("xy"))
            self.assertAlmostEqual(along, 10 / 0.2 * share, delta=1e-9)
        turned = math.degrees(math.atan2(place["north_x"], place["north_y"]))  # without rotation, north is +y, east -x
        self.assertAlmostEqual(turned, 50, delta=1e-9)

    def test_random_frames(self):
        samples = PICTURES.samples
        self.assertEqual([k * 5 // FRAMES for k in samples], [0, 1, 2, 3, 4])
        self.succeed("simulate", RUN.parent / SCENE, "--seed", SEED, "--out", "f.npy")
        frames = numpy.load(self.folder / "f.npy")
        self.assertTrue((self.images["frame"] == frames[0]).all())
        first_x, first_y = (self.place("frames")[i][0] - self.place("frame")[i][0] for i in range(2))
        crop = frames[samples, int(first_y):int(first_y) + SIDE, int(first_x):int(first_x) + SIDE]
        self.assertTrue((self.images["frames"] == crop).all())
        expected = self.images["expected"][int(first_y):int(first_y) + SIDE, int(first_x):int(first_x) + SIDE]
        residuals = (crop - self.images["reconstructions"]) / numpy.sqrt(expected)
        numpy.testing.assert_allclose(self.images["residuals"], residuals, rtol=0, atol=1e-6)

    def test_reconstructions_are_the_latents(self):
        """The derivative image, scaled by the latent: here 1e-4 px is 80 times the noise."""
        series = rows_of(RUN / "series.csv")
        crop = int(self.place("frames")[0][0] - self.place("frame")[0][0])
        largest = max(series["true"], key=abs)
        per_px = self.images["difference"][:, crop:crop + SIDE] / largest
        expected = self.images["expected"][:, crop:crop + SIDE]
        weight = per_px / expected
        for k, image in zip(PICTURES.samples, self.images["reconstructions"]):
            fitted = (weight * (image - expected)).sum() / (weight * per_px).sum()
            self.assertAlmostEqual(fitted / series["latent"][k], 1, delta=0.02)

    def test_residuals(self):
        """The means are over all 20 frames, of which 5 are kept: three standard errors of those."""
        stated, kept = self.result["residuals"], self.images["residuals"]
        self.assertEqual(stated["frames"], FRAMES)
        error = 3 / math.sqrt(kept.size)
        self.assertAlmostEqual(stated["mean"], kept.mean(), delta=error)
        self.assertAlmostEqual(stated["rms"], kept.std(), delta=error)
        pairs = (kept[:, :, 1:] * kept[:, :, :-1]).mean() / kept.var()
        self.assertAlmostEqual(stated["correlation"], pairs, delta=error)

    def test_power_of_the_truth(self):
        table, series = rows_of(RUN / "periodogram.csv"), rows_of(RUN / "series.csv")
        want = LombScargle(series["t"], series["true"]).power(table["frequency"], method="cython")
        numpy.testing.assert_allclose(table["true"][:-1], want[:-1], rtol=0, atol=1e-9)  # at the last, sine is 0
        truth = self.result["true_series"]
        self.assertAlmostEqual(truth["fwhm_period_days"], 2 * truth["half_width_period_days"], delta=1e-9)

    def test_fitted_sinusoid(self):
        """Least squares at the stated period by numpy."""
        series, result = rows_of(RUN / "series.csv"), self.result
        angle = 2 * math.pi * (series["t"] - result["fitted_time_offset_days"]) / result["period_days"]
        columns = numpy.stack([numpy.sin(angle), numpy.cos(angle), numpy.ones(FRAMES)], axis=1)
        (sine, cosine, offset), squares, _, _ = numpy.linalg.lstsq(columns, series["latent"], rcond=None)
        self.assertAlmostEqual(result["fitted_amplitude_px"], math.hypot(sine, cosine), delta=1e-9)
        self.assertAlmostEqual(math.remainder(result["fitted_phase_rad"] - math.atan2(cosine, sine), 2 * math.pi), 0, delta=1e-6)
        self.assertAlmostEqual(result["fitted_offset_px"], offset, delta=1e-9)
        error = math.sqrt(squares[0] / (FRAMES - 4) * 2 / FRAMES)
        self.assertAlmostEqual(result["fitted_amplitude_error_px"] / error, 1, delta=0.15)

    def test_provenance(self):
        origin = self.result["provenance"]
        self.assertEqual(shlex.split(origin["command"]), ["toliman", "run", SCENE, "--seed", str(SEED)])
        date = datetime.datetime.fromisoformat(origin["date"].replace("Z", "+00:00"))
        began = datetime.datetime.fromtimestamp((RUN.parent / SCENE).stat().st_mtime, datetime.timezone.utc)
        self.assertLessEqual(abs(date - began), datetime.timedelta(minutes=5))
        self.assertEqual(origin["processor"], json.loads(self.succeed("doctor", "--json"))["cpu"])

    def test_displacement_errors(self):
        """Interpolation between fifths of a pixel, here by the weights of Keys and over more of the image."""
        table = PICTURES.displacement
        numpy.testing.assert_allclose(table["displacement_px"], [1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
        self.assertLess(table["taylor"].max(), 1e-8)
        x = numpy.arange(-15.5, 16)
        light = functools.partial(self.telescope.light, 580, y_px=x, arcsec=0.2)

        def linear(u):
            return numpy.maximum(1 - abs(u), 0)

        def cubic(u):
            u = abs(u)
            return numpy.where(u < 1, 1.5 * u**3 - 2.5 * u**2 + 1, numpy.where(u < 2, -0.5 * u**3 + 2.5 * u**2 - 4 * u + 2, 0))

        def interpolated(weight, shift):
            fraction = -5 * shift - math.floor(-5 * shift)
            return sum(weight(k - fraction) * light(x_px=x + (math.floor(-5 * shift) + k) / 5) for k in range(-1, 3))

        inside = slice(2, -2)
        still = light(x_px=x - 1 / 3)
        for i in (0, 2, 4):
            d = table["displacement_px"][i]
            exact = light(x_px=x - 1 / 3 - d)
            signal = abs(exact - still)[:, inside].max()
            for name, weight in (("linear", linear), ("cubic", cubic)):
                image, before = interpolated(weight, 1 / 3 + d), interpolated(weight, 1 / 3)
                error = abs(image - exact)[:, inside].max() / signal
                change = abs(image - before - exact + still)[:, inside].max() / signal
                self.assertAlmostEqual(table[name][i] / error, 1, delta=1e-3)
                self.assertAlmostEqual(table[name + "_change"][i] / change, 1, delta=1e-3)


class OtherRuns(ProgramTest):
    def run_scene(self, scene):
        """result.json of a run; its outputs are self.done."""
        (self.folder / "s.json").write_text(json.dumps(scene))
        self.done = self.run_program("run", "s.json", "--controls", "quick", "--out", "r")
        self.assertEqual(self.done.returncode, 0, self.done.stderr)
        return json.loads((self.folder / "r/result.json").read_text())

    def pictures(self):
        """What the report shows of this run."""
        found, reason = run_simulation.simulate(self.folder / "r", results.load(self.folder / "r/result.json", "toliman-run/2"))
        self.assertEqual(reason, "")
        return found

    def test_read_noise_only_and_pixels_too_small_to_be_divided(self):
        """The bound counts photons, by which these frames do not scatter: it was an efficiency of 1534."""
        scene = scene_of(telescope={"aperture_m": 100, "secondary_m": 10}, binary={"separation_arcsec": 2e-4},
                         noise={"photon": False, "read_e": 5})
        scene["detector"]["pixel_scale_arcsec"] = 4e-6  # at least 1e-6
        result = self.run_scene(scene)
        self.assertEqual(self.pictures().displacement, {})
        self.assertIn("efficiency not defined\n", self.done.stdout)
        self.assertEqual((result["efficiency"], result["efficiency_error"]), (None, None))
        self.assertLess(result["latent_sigma_px"], result["crb_px"] / 100)

    def test_no_signal_one_star_and_a_pupil_with_too_few_samples(self):
        """The lines are more than 4096 nm apart, the most steps that a band may have."""
        scene = scene_of(signal={"amplitude_px": 0}, telescope={"pupil_samples": 60})
        scene["stars"].pop("B")
        scene.pop("binary")
        scene["cadence"]["frames"] = 7
        scene.pop("band")
        scene["stars"]["A"]["spectrum"] = {"kind": "lines", "wavelength_nm": [5580, 580], "weight": [0.01, 1]}
        result = self.run_scene(scene)
        self.assertIn("highest peak  ", self.done.stdout)
        self.assertNotIn("report", self.done.stderr)  # there is none of a run before
        self.assertEqual((result["true_series"], result["fit"]), (None, None))
        self.assertEqual({result["geometry"][key] for key in ("b_x_px", "b_y_px")}, {None})
        self.assertEqual(set(rows_of(self.folder / "r/periodogram.csv")["true"]), {0})
        pictures = self.pictures()
        self.assertEqual(len(set(pictures.samples)), 5)
        self.assertFalse(pictures.images["difference"].values.any())
        self.assertEqual(len(pictures.displacement["taylor"]), 5)
        for name, missing in (("psf_600nm", False), ("psf_500-700nm", True)):
            self.assertEqual((name in pictures.images, bool(pictures.reasons[name])), (not missing, missing))
        self.assertIn("pupil_samples = 60: ", pictures.reasons["psf_500-700nm"])


if __name__ == "__main__":
    unittest.main()
