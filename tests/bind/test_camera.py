"""The detector's effects against a slow model in numpy, their derivatives against differences of whole images, frames that
are drawn by numpy through that model, and calibrations that find them."""
import copy
import json
import pathlib
import tempfile
import unittest

import numpy

from package import LONG, toliman
from refusal import refused
import test_bank
from toliman.experiment import variants

SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.032, "pupil_samples": 32, "struts": {"count": 3, "width_m": 0.004},
                  "mask": {"kind": "spiral", "opd_nm": 292.5, "edges": "area", "terms": [{"a": 1, "f": 1.2, "m": -5, "p": 1}]}},
    "band": {"min_nm": 530, "max_nm": 640, "step_nm": 55},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 7.5e6},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2.5e6}},
    "binary": {"separation_arcsec": 4.5, "position_angle_deg": 40},
    "cadence": {"frames": 6, "interval_days": 15, "exposure_s": 100},
    "detector": {"shape": [40, 36], "pixel_scale_arcsec": 0.375, "pixel": "integrated"},
    "noise": {"photon": True, "seed": 7},
}
EFFECTS = {"transfer_smear": 1e-3, "brighter_fatter_px2_per_e": 1e-8, "interpixel_capacitance": 0.01,
           "nonlinearity_per_e": 1e-8}
EARTH_PX = 1e-6
DARK = {"dark_e_per_s": 3.0, "qe": 0.8, "flat_rms": 0.01}


def scene_with(detector, **groups):
    scene = copy.deepcopy(SCENE)
    scene["detector"].update(detector)
    for name, group in groups.items():
        scene[name] = {**scene.get(name, {}), **group}
    return scene


def flow(values):
    """The sum over the four neighbours of their value minus a pixel's own; nothing crosses the border."""
    padded = numpy.pad(values, 1, mode="edge")
    return padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:] - 4 * values


def read_out(light, effects, coadds=1, dark=0, draw=lambda charge: charge):
    """What a detector reads, in electrons, by the definitions of toliman-scene-1.schema.json."""
    charge = draw(light + effects.get("transfer_smear", 0) * light.sum(axis=0) + dark)
    charge = charge + effects.get("brighter_fatter_px2_per_e", 0) / coadds / 4 * flow(charge**2)
    charge = charge + effects.get("interpixel_capacitance", 0) * flow(charge)
    return charge - effects.get("nonlinearity_per_e", 0) / coadds * charge**2


class Images(unittest.TestCase):
    def test_against_numpy(self):
        light = toliman.Simulator(scene_with({"qe": 0.8, "flat_rms": 0.01})).image()
        cases = [{name: value} for name, value in EFFECTS.items()] + [EFFECTS]
        for effects in cases:
            for coadds in 1, 4:
                with self.subTest(effects=effects, coadds=coadds):
                    simulator = toliman.Simulator(scene_with({**DARK, **effects, "coadds": coadds}))
                    wanted = read_out(light, effects, coadds, dark=300)
                    numpy.testing.assert_allclose(simulator.image(), wanted, rtol=0, atol=1e-13 * light.max())
                    self.assertGreater(abs(wanted - light - 300).max(), 1e-6 * light.max())

    def test_diffusion_is_a_blur(self):
        blurred = toliman.Simulator(scene_with({"diffusion_px": 0.3})).image()
        same = toliman.Simulator(scene_with({}, systematics={"jitter_sigma_px": 0.3})).image()
        numpy.testing.assert_allclose(blurred, same, rtol=0, atol=1e-12 * same.max())

    def test_derivatives_against_differences(self):
        """Of whole images, of each parameter and of the stars' places, with all effects on."""
        steps = {"transfer_smear": 1e-4, "brighter_fatter": 1e-9, "interpixel_capacitance": 1e-3, "nonlinearity": 1e-9}
        simulator = toliman.Simulator(scene_with({**DARK, **EFFECTS}))
        keys = dict(zip(steps, EFFECTS))

        def image(name, change):
            return toliman.Simulator(scene_with({**DARK, **EFFECTS, keys[name]: EFFECTS[keys[name]] + change})).image()

        for name, step in steps.items():
            with self.subTest(name):
                wanted = (image(name, step) - image(name, -step)) / (2 * step)
                ours = simulator.derivative(name)
                numpy.testing.assert_allclose(ours, wanted, rtol=0, atol=1e-6 * abs(wanted).max())
        with self.subTest("diffusion"):
            def diffused(variance):
                return toliman.Simulator(scene_with({**DARK, **EFFECTS, "diffusion_px": variance**0.5})).image()
            wanted = (diffused(0.04 + 1e-4) - diffused(0.04 - 1e-4)) / 2e-4
            ours = toliman.Simulator(scene_with({**DARK, **EFFECTS, "diffusion_px": 0.2})).derivative("diffusion")
            numpy.testing.assert_allclose(ours, wanted, rtol=0, atol=1e-6 * abs(wanted).max())
        with self.subTest("separation"):
            wanted = (simulator.propagate(1e-4) - simulator.propagate(-1e-4)) / 2e-4
            numpy.testing.assert_allclose(simulator.derivative("separation"), wanted, rtol=0, atol=1e-6 * abs(wanted).max())

    def test_the_gradient_by_the_opd_is_the_adjoint(self):
        simulator = toliman.Simulator(scene_with({**DARK, **EFFECTS}))
        weights = numpy.random.default_rng(1).normal(size=simulator.shape)
        pupil = simulator.pupil()[0]
        radius = (numpy.arange(32) - 15.5) / 16
        x, y = numpy.meshgrid(radius, radius)
        coma = numpy.sqrt(8) * (3 * (x**2 + y**2) - 2) * y * 1e-9  # Noll 7 of 1 nm
        wanted = (weights * simulator.derivative("zernike_7")).sum()
        ours = (coma * (pupil > 0) * simulator.opd_gradient(weights)).sum()
        self.assertAlmostEqual(ours / wanted, 1, delta=1e-9)

    def test_frames_are_those_of_numpy_in_mean_and_variance(self):
        """With coupled noise: the variance of a pixel, and the covariance of neighbours."""
        effects = {"interpixel_capacitance": 0.02, "nonlinearity_per_e": 1e-7}
        scene = scene_with(effects, cadence={"exposure_s": 0.1})
        simulator = toliman.Simulator(scene)
        frames = simulator.frames(0, 3000, displacements=numpy.zeros(3000))
        rest = frames - simulator.image()
        light = toliman.Simulator(scene_with({}, cadence={"exposure_s": 0.1})).image()
        rng = numpy.random.default_rng(2)
        drawn = numpy.array([read_out(light, effects, draw=rng.poisson) for _ in range(3000)]) - simulator.image()
        for ours, theirs in ((rest**2, drawn**2), (rest[:, 1:] * rest[:, :-1], drawn[:, 1:] * drawn[:, :-1])):
            noise = numpy.sqrt((ours.std(axis=0)**2 + theirs.std(axis=0)**2) / 3000)
            pulls = (ours.mean(axis=0) - theirs.mean(axis=0)) / noise
            self.assertLess(abs(pulls).max(), 5.5)
            self.assertAlmostEqual(pulls.std(), 1, delta=0.1)
        covariance = (rest[:, 1:] * rest[:, :-1]).mean(axis=0).sum() / (rest**2).mean(axis=0).sum()
        self.assertAlmostEqual(covariance, 0.04, delta=0.005)  # 2 k


class Fluxes(unittest.TestCase):
    """Stars whose flux is given in electrons, with an exposure or a peak, and stars made equal."""
    IN_ELECTRONS = {"A": {"detected_per_s": 6e6}, "B": {"detected_per_s": 2e6}}

    @staticmethod
    def scene(stars, cadence, **detector):
        scene = scene_with(detector)
        scene["cadence"] = {"frames": 6, **cadence}
        for name, flux in stars.items():
            del scene["stars"][name]["photons_per_s"]
            scene["stars"][name].update(flux)
        return scene

    def test_a_peak_scales_electrons(self):
        """Which are the unit of the peak; the ratio remains, and the image is that of an exposure but for the factor."""
        exposed, scaled = (toliman.Simulator(self.scene(self.IN_ELECTRONS, cadence))
                           for cadence in ({"exposure_s": 10}, {"peak_photons": 1e5}))
        for simulator in exposed, scaled:
            self.assertEqual((simulator.info.unit, round(simulator.info.flux_ratio, 12)), ("electron", 3))
        self.assertAlmostEqual(scaled.image().max() / 1e5, 1, delta=1e-12)
        factor = 1e5 / exposed.image().max()
        numpy.testing.assert_allclose(scaled.image(), factor * exposed.image(), rtol=1e-11)

    def test_stars_made_equal(self):
        """Have the mean of both fluxes with an exposure, and the peak with a peak; the unit stays."""
        in_photons = {star: {"photons_per_s": flux["detected_per_s"]} for star, flux in self.IN_ELECTRONS.items()}
        relative = {star: {"relative_flux": flux["detected_per_s"] / 2e6} for star, flux in self.IN_ELECTRONS.items()}
        for stars, cadence, detector, unit in (
                (self.IN_ELECTRONS, {"exposure_s": 10}, {}, "electron"), (self.IN_ELECTRONS, {"peak_photons": 1e5}, {}, "electron"),
                (in_photons, {"exposure_s": 10}, {"qe": 0.5}, "electron"), (in_photons, {"peak_photons": 1e5}, {}, "photon"),
                (relative, {"peak_photons": 1e5}, {}, "photon")):
            with self.subTest(stars=stars, cadence=cadence), tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "scene.json"
                path.write_text(json.dumps(self.scene(stars, cadence, **detector)))
                before = toliman.Simulator(path)
                equal = variants.Variants(str(path), before).equal_stars()
                self.assertEqual((equal.info.unit, round(equal.info.flux_ratio, 12)), (unit, 1))
                if "peak_photons" in cadence:
                    self.assertAlmostEqual(equal.image().max() / 1e5, 1, delta=1e-12)
                else:
                    totals = [toliman.plan(json.loads(path.read_text())).electrons_per_s, (4e6 * detector.get("qe", 1),) * 2]
                    self.assertAlmostEqual(sum(totals[0]) / sum(totals[1]), 1, delta=1e-12)
                    self.assertAlmostEqual(equal.image("star_a").sum() / equal.image("star_b").sum(), 1, delta=0.02)

    def test_facts_that_contradict(self):
        electrons, photons = {"detected_per_s": 1e6}, {"photons_per_s": 1e6}
        exposure, peak = {"exposure_s": 10}, {"peak_photons": 1e5}
        for a, b, cadence, detector, field in (
                (electrons, electrons, peak, {"qe": 0.5}, "detector.qe"), (electrons, photons, exposure, {}, "stars"),
                (electrons, photons, peak, {}, "stars"), (electrons, {}, peak, {}, "stars"),
                (electrons, {"magnitude": 3, "magnitude_band": "V"}, exposure, {}, "stars"),
                (electrons, {"relative_flux": 1}, peak, {}, "stars"), ({**electrons, **photons}, photons, peak, {}, "stars.A.photons_per_s"),
                (electrons, electrons, {**exposure, **peak}, {}, "cadence.peak_photons"),
                ({}, {}, exposure, {}, "cadence.exposure_s")):
            with self.subTest(a=a, b=b, cadence=cadence, detector=detector), refused(toliman.InputError, field):
                toliman.Simulator(self.scene({"A": a, "B": b}, cadence, **detector))


class Fits(unittest.TestCase):
    def test_a_fit_undoes_the_readout(self):
        """Frames of numpy: places at the bound and chi-square 1; without the effects in the scene, neither."""
        scene = scene_with({**DARK, **EFFECTS})
        simulator = toliman.Simulator(scene)
        light = toliman.Simulator(scene_with({"qe": 0.8, "flat_rms": 0.01})).image()
        rng = numpy.random.default_rng(3)
        frames = numpy.array([read_out(light, EFFECTS, dark=300, draw=rng.poisson) for _ in range(200)])
        ours = toliman.Fit(simulator, capture_px=2).frames(frames)
        truth = numpy.hypot(*(simulator.offsets()[1] - simulator.offsets()[0]))
        pulls = (ours["separation_px"] - truth) / ours["separation_sigma_px"]
        self.assertLess(abs(pulls.mean()), 4 / 200**0.5)
        self.assertAlmostEqual(pulls.std(), 1, delta=0.16)
        self.assertAlmostEqual(ours["chi_square"].mean(), 1, delta=0.012)
        for name in EFFECTS:
            with self.subTest(name):
                without = toliman.Simulator(scene_with({**DARK, **{key: value for key, value in EFFECTS.items() if key != name}}))
                wrong = toliman.Fit(without, capture_px=2).frames(frames[:2])
                self.assertGreater(wrong["chi_square"].min(), 1.5)

    def test_the_expected_frame_is_read_out(self):
        simulator = toliman.Simulator(scene_with({**DARK, **EFFECTS}))
        image, _ = toliman.Fit(simulator, capture_px=2).predict()[:2]
        numpy.testing.assert_allclose(image, simulator.image(), rtol=0, atol=1e-7 * image.max())

    def test_saturated_pixels_and_their_neighbours_are_left_out(self):
        effects = {"interpixel_capacitance": 0.01, "full_well_e": 1e6}
        simulator = toliman.Simulator(scene_with(effects))
        frame = simulator.frame(0)
        ours = toliman.Fit(simulator, capture_px=2).frames(frame[None])
        saturated = (frame > 0.95e6).sum()
        self.assertGreater(saturated, 0)
        self.assertGreaterEqual(int(ours["excluded"][0]), saturated)
        self.assertAlmostEqual(ours["chi_square"][0], 1, delta=0.2)

    def test_exposing_the_expected_frame_is_simulating(self):
        """Also where it saturates and pixels mix."""
        for effects in {}, {"interpixel_capacitance": 0.01}, EFFECTS:
            simulator = toliman.Simulator(scene_with({**effects, "full_well_e": 2e6}))
            expected = toliman.Simulator(scene_with(effects)).image()
            frame = simulator.frames(0, 1, displacements=[0])[0]
            numpy.testing.assert_allclose(simulator.expose(expected), frame, rtol=0, atol=1e-5 * frame.max())

    def test_bright_hits_are_left_out(self):
        """Of a bit that flips far from the stars to a ray in the column of a star, with each effect."""
        for effects in {"transfer_smear": 1e-3}, {"brighter_fatter_px2_per_e": 3e-9}, {"nonlinearity_per_e": 1e-8, "full_well_e": 1e9}:
            simulator = toliman.Simulator(scene_with(effects))
            light = toliman.Simulator(scene_with({})).image()
            fit, offsets = toliman.Fit(simulator, capture_px=2), simulator.offsets()
            truth = numpy.hypot(*(offsets[1] - offsets[0]))
            col = int(round(offsets[0][0] + 17.5))
            for size in 0.3, 1, 5, 20:
                hit = numpy.random.default_rng(5).poisson(light).astype(float)
                smear = effects.get("transfer_smear", 0) * light.sum(axis=0)
                hit += numpy.random.default_rng(6).poisson(numpy.broadcast_to(smear, light.shape))
                hit[5, col] += size * light.max()
                frame = read_out(hit, {key: value for key, value in effects.items() if key not in ("transfer_smear", "full_well_e")})
                found = fit.frames(frame[None])
                with self.subTest(effects=effects, size=size):
                    self.assertLess(abs(found["separation_px"][0] - truth), 4.5 * found["separation_sigma_px"][0])

    def test_neighbours_of_bad_pixels_are_left_out(self):
        """A count that flips has no charge, so that undoing the mixing of pixels makes its neighbours wrong by less than a
        fit finds: a pixel that it finds costs the same pixels as one that the scene knows."""
        for effects in {"interpixel_capacitance": 0.01}, {"brighter_fatter_px2_per_e": 1e-8}:
            simulator = toliman.Simulator(scene_with(effects))
            frame, rng = simulator.frame(0), numpy.random.default_rng(8)
            bright = numpy.argwhere(frame[2:-2, 2:-2] > 0.05 * frame.max()) + 2
            for row, col in rng.permutation(bright)[:6]:
                flipped = frame.copy()
                flipped[row, col] += 12 * frame[row, col]**0.5 + 0.02 * frame.max()
                bad = numpy.zeros(frame.shape)
                bad[row, col] = 1
                with self.subTest(effects=effects, row=row, col=col), tempfile.TemporaryDirectory() as folder:
                    numpy.save(pathlib.Path(folder) / "bad.npy", bad)
                    known = toliman.Simulator(scene_with({**effects, "bad_pixels": "bad.npy"}), folder=folder)
                    found, expected = (toliman.Fit(one, capture_px=2).frames(flipped[None]) for one in (simulator, known))
                    self.assertEqual(found["bad_pixels"], 1)
                    difference = found["separation_px"] - expected["separation_px"]
                    self.assertLess(abs(difference), 1e-3 * expected["separation_sigma_px"])
                    self.assertAlmostEqual(found["separation_sigma_px"] / expected["separation_sigma_px"], 1, delta=1e-5)

    def test_a_count_that_is_not_finite_is_named(self):
        simulator = toliman.Simulator(scene_with(EFFECTS))
        frame = simulator.image()
        frame[7, 5] = numpy.nan
        with self.assertRaisesRegex(toliman.InputError, r"\[7\]\[5\]"):
            toliman.Fit(simulator, capture_px=2).frames(frame[None])

    def test_mistakes(self):
        for free in ("nonlinearity", "transfer_smear", "diffusion", "flat"):
            with self.subTest(free):
                with refused(toliman.UnsupportedError, "options->free"):
                    toliman.Fit(toliman.Simulator(SCENE), free=[free])
        for detector in ({"nonlinearity_per_e": 1e-5}, {"brighter_fatter_px2_per_e": 1e-5}):
            with self.subTest(detector):
                with refused(toliman.InputError, "detector"):
                    toliman.Simulator(scene_with(detector))


class Templates(unittest.TestCase):
    def test_coupled_noise_keeps_the_bound(self):
        """Neighbours share noise, which the variances of trained estimators leave out; their scatter, of the same random
        numbers, is nearly the same share of the bound as without: 0.05 % and 0.5 % more."""
        shares = []
        for coupling in 0, 2e-3, 2e-2:
            scene = scene_with({"interpixel_capacitance": coupling}, cadence={"exposure_s": 1, "frames": 200})
            simulator = toliman.Simulator(scene)
            values = toliman.Template(simulator).encode(simulator.frames(displacements=numpy.zeros(200)))
            shares.append(numpy.std(values) / simulator.bounds.crb_projected_px)
        self.assertAlmostEqual(shares[0], 1, delta=4 / 400**0.5)
        numpy.testing.assert_allclose(shares, shares[0], rtol=0.01)


class Banks(unittest.TestCase):
    """Networks behind a readout: the scene of test_bank, with pixels of layout core."""
    TIMES = numpy.arange(40) * 1.25

    @classmethod
    def bank(cls, effects):
        scene = copy.deepcopy(test_bank.SCENE)
        scene["detector"].update(shape=[128, 128], **effects)
        scene["cadence"].update(frames=len(cls.TIMES), interval_days=1.25)
        scene["signal"]["amplitude_px"] = 0
        scene["noise"]["read_e"] = 0
        simulator = toliman.Simulator(scene)
        bank = toliman.Bank(toliman.Fit(simulator, capture_px=2), layout="core", places=1, spacing_px=2.5, steps=60)
        bank.train(threads=1)
        return simulator, bank

    def test_separations_are_those_of_the_fit(self):
        """Without a bias, and within what the networks leave of its accuracy; a batch has the bits of single frames."""
        simulator, bank = self.bank(EFFECTS)
        frames = simulator.frames()
        networks, fits = bank.encode(frames, times_days=self.TIMES)
        more = (networks["sigma_px"]**2 - fits["separation_sigma_px"]**2)**0.5
        pulls = (networks["separation_px"] - fits["separation_px"]) / more
        self.assertLess(abs(pulls.mean()), 4 / len(pulls)**0.5)
        self.assertAlmostEqual(pulls.std(), 1, delta=4 / (2 * len(pulls))**0.5)
        self.assertLess(abs(fits["displacement_px"] / fits["separation_sigma_px"]).max(), 4.5)
        for k in 0, 25:
            found, fitted = bank.encode_frame(frames[k], time_days=self.TIMES[k])
            self.assertEqual((found.separation_px, fitted.separation_px), (networks["separation_px"][k], fits["separation_px"][k]))

    def test_frames_are_undone_once(self):
        """Frames that numpy undoes, measured by the bank of an ideal detector without the border: the same separations."""
        effects = {name: value for name, value in EFFECTS.items() if name != "transfer_smear"}
        simulator, bank = self.bank(effects)
        frames = simulator.frames(0, 6)
        ideal = frames.copy()
        for _ in range(40):
            ideal += frames - numpy.array([read_out(one, effects) for one in ideal])
        self.assertGreater(abs(ideal - frames).max(), 1e-3 * frames.max())
        border = numpy.ones(frames.shape[1:])
        border[1:-1, 1:-1] = 0
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "border.npy"
            numpy.save(path, border)
            without = self.bank({"bad_pixels": str(path)})[1]
        found, wanted = (one.encode(given, times_days=self.TIMES[:6])[0]["separation_px"]
                         for one, given in ((bank, frames), (without, ideal)))
        numpy.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9)


class Budgets(unittest.TestCase):
    """Rows of the budget against fits of whole frames by a model that lacks the effect."""

    @classmethod
    def setUpClass(cls):
        cls.nominal = toliman.Simulator(scene_with(DARK))
        cls.fit = toliman.Fit(cls.nominal, capture_px=2)
        cls.rows = {row.name: row for row in cls.nominal.budget(
            ["flux_a", "flux_b", "shift_x", "shift_y", "roll", "background"], earth_px=EARTH_PX).rows}
        cls.truth = cls.error_of(cls.nominal.image())

    @classmethod
    def error_of(cls, frame):
        return float(cls.fit.frames(frame[None])["separation_px"][0])

    def test_effects_of_the_detector(self):
        keys = {"diffusion": "diffusion_px", "transfer_smear": "transfer_smear", "brighter_fatter": "brighter_fatter_px2_per_e",
                "interpixel_capacitance": "interpixel_capacitance", "nonlinearity": "nonlinearity_per_e"}
        for name, key in keys.items():
            with self.subTest(name):
                amount = self.rows[name].tenth_crb_amount
                value = amount**0.5 if name == "diffusion" else amount
                frame = toliman.Simulator(scene_with({**DARK, key: value})).image()
                self.assertAlmostEqual((self.error_of(frame) - self.truth) / (self.rows[name].bias_px * amount), 1, delta=0.02)

    def test_missions(self):
        """An amount of an Earth that varies with a period is a planet like an Earth: 24 frames of numpy, fitted one by one."""
        light = self.nominal.image() - 300
        phases = numpy.arange(24) / 24 * 2 * numpy.pi
        for name, key in {"transfer_smear": "transfer_smear", "brighter_fatter": "brighter_fatter_px2_per_e",
                          "interpixel_capacitance": "interpixel_capacitance", "nonlinearity": "nonlinearity_per_e"}.items():
            with self.subTest(name):
                amounts = self.rows[name].earth_amount * numpy.sin(phases)
                errors = [self.error_of(read_out(light, {key: amount}, dark=300)) for amount in amounts]
                amplitude = abs(2 * numpy.mean(errors * numpy.sin(phases)))
                self.assertAlmostEqual(amplitude / EARTH_PX, 1, delta=0.03)

    def test_flat(self):
        """The standard deviation over responses of 1e-4 that numpy draws."""
        rng, frame, dark = numpy.random.default_rng(4), self.nominal.image(), 300
        errors = [self.error_of(dark + (frame - dark) * (1 + 1e-4 * rng.normal(size=frame.shape))) - self.truth
                  for _ in range(300)]
        self.assertAlmostEqual(numpy.std(errors) / (1e-4 * self.rows["flat"].bias_px), 1, delta=0.13)


class Calibrations(unittest.TestCase):
    def test_effects_are_found(self):
        """Unknown smear, non-linearity, coupling, brighter-fatter and diffusion, from frames with pointing."""
        motion = {"pointing_rms_px": 0.7}
        truth = toliman.Simulator(scene_with({**DARK, **EFFECTS, "diffusion_px": 0.2}, systematics=motion))
        nominal = toliman.Simulator(scene_with(DARK, systematics=motion))
        free = "jitter_xx jitter_yy jitter_xy focus zernike_5-8 transfer_smear nonlinearity interpixel_capacitance brighter_fatter"
        found = toliman.calibrate(nominal, truth.frames(), free=free)
        self.assertEqual(found.flags, (), found.verdict)
        values = found.values()
        wanted = {"jitter_xx": 0.04, "jitter_yy": 0.04, "jitter_xy": 0, "transfer_smear": 1e-3, "nonlinearity": 1e-8,
                  "interpixel_capacitance": 0.01, "brighter_fatter": 1e-8}
        for name, value in wanted.items():
            with self.subTest(name):
                self.assertLess(abs(values[name].value - value), 4 * values[name].sigma)
                self.assertLess(values[name].sigma, 0.1 * max(value, 1e-2))
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "fitted.json"
            found.save(path)
            detector = json.loads(path.read_text())["detector"]
            for name, key in (("transfer_smear", "transfer_smear"), ("nonlinearity", "nonlinearity_per_e")):
                self.assertAlmostEqual(detector[key], values[name].value, delta=1e-12 * abs(detector[key]))
            self.assertGreater(toliman.Simulator(path).image().min(), 0)

    def test_errors_with_the_response_unknown(self):
        """Over seeds of the noise, in `make long` eight of them. With the response known they would be 1.6 to 4 times smaller: stars that move by 0.3 px
        hardly tell pixels from optics. Limits are the quantiles of chi-square at 1e-3 and 1 - 1e-3."""
        seeds, limits, limits_of_all = (8, (0.31, 1.81), (0.63, 1.4)) if LONG else (2, (0.03, 2.63), (0.33, 1.81))
        cadence, motion = {"frames": 12, "interval_days": 1}, {"pointing_rms_px": 0.3}
        nominal = toliman.Simulator(scene_with({"shape": [28, 28]}, cadence=cadence, systematics=motion))
        wanted = {"transfer_smear": 1e-3, "nonlinearity": 1e-8, "interpixel_capacitance": 0.01, "brighter_fatter": 1e-8}
        pulls = []
        for seed in range(100, 100 + seeds):
            truth = toliman.Simulator(scene_with({**EFFECTS, "shape": [28, 28], "flat_rms": 0.01}, cadence=cadence,
                                                 systematics=motion, noise={"seed": seed}))
            found = toliman.calibrate(nominal, truth.frames(), free=f"focus zernike_5-8 {' '.join(wanted)}", detector=True,
                                      response_rms=0.01, threads=1)
            self.assertEqual(found.flags, (), found.verdict)
            values = found.values()
            pulls.append([(values[name].value - value) / values[name].sigma for name, value in wanted.items()])
        for name, rms in zip(wanted, numpy.mean(numpy.square(pulls), axis=0)**0.5):
            self.assertTrue(limits[0] < rms < limits[1], (name, rms))
        rms = numpy.mean(numpy.square(pulls))**0.5
        self.assertTrue(limits_of_all[0] < rms < limits_of_all[1], rms)

    def test_hits_are_left_out(self):
        """Five cosmic rays of 1e4 e in every frame bias neither the response nor the optics; the bits do not depend on
        threads and interruptions. Frames that are poor without their bad pixels are not cleaned."""
        cadence, motion = {"frames": 12, "interval_days": 1}, {"pointing_rms_px": 1.0}
        truth = toliman.Simulator(scene_with({"flat_rms": 0.01}, cadence=cadence, systematics=motion))
        nominal = toliman.Simulator(scene_with({}, cadence=cadence, systematics=motion))
        frames, random = truth.frames(), numpy.random.default_rng(9)
        hit = frames.copy()
        for frame in hit:
            frame.ravel()[random.choice(frame.size, 5, replace=False)] += 1e4
        how = {"free": "focus zernike_5-8", "detector": True, "response_rms": 0.01}
        expected, found = (toliman.calibrate(nominal, given, threads=1, **how) for given in (frames, hit))
        self.assertEqual((expected.flags, found.flags), ((), ()), found.verdict)
        self.assertEqual(expected.frames["bad_pixels"].sum(), 0)
        self.assertGreater(found.frames["bad_pixels"].sum(), 0.8 * 5 * len(hit))  # others are within the noise of a star
        response = truth.image() / nominal.image()
        pulls = (found.response - response / response.mean()) / found.response_sigma
        self.assertAlmostEqual((pulls**2).mean()**0.5, 1, delta=4 / (2 * pulls.size)**0.5)
        self.assertLess(abs(pulls).max(), 5)
        for name, value in found.values().items():
            self.assertLess(abs(value.value - expected.values()[name].value), 0.5 * value.sigma, name)
        with tempfile.TemporaryDirectory() as folder:
            journal = pathlib.Path(folder) / "part"
            with refused(toliman.Cancelled):
                toliman.calibrate(nominal, hit, journal=journal, step=lambda _, step: step.is_response, **how)
            again = toliman.calibrate(nominal, hit, journal=journal, threads=2, **how)
        numpy.testing.assert_array_equal(again.response, found.response)
        wrong = toliman.calibrate(nominal, hit, free="focus")
        self.assertEqual(wrong.frames["bad_pixels"].sum(), 0)
        self.assertIn("incomplete", wrong.flags)

    def test_a_blur_that_is_less_than_assumed_is_saved(self):
        """As jitter or diffusion below 0 alone, whose sum is a blur."""
        motion = {"pointing_rms_px": 0.7}
        for truth, nominal, free in (({"jitter_sigma_px": 0.2}, {"jitter_sigma_px": 0.3}, "diffusion jitter_xy"),
                                     ({}, {}, "jitter_xx jitter_yy jitter_xy")):
            diffusion = {} if truth else {"diffusion_px": 0.2}
            true = toliman.Simulator(scene_with(diffusion, systematics={**motion, **truth}))
            start = toliman.Simulator(scene_with({} if truth else {"diffusion_px": 0.3}, systematics={**motion, **nominal}))
            found = toliman.calibrate(start, true.frames(), free=free)
            with self.subTest(free), tempfile.TemporaryDirectory() as folder:
                found.save(pathlib.Path(folder) / "fitted.json")
                again = toliman.Simulator(pathlib.Path(folder) / "fitted.json").image()
                numpy.testing.assert_allclose(again, true.image(), rtol=0, atol=2e-3 * again.max())

    def test_diffusion_is_no_other_parameter_than_jitter(self):
        nominal = toliman.Simulator(SCENE)
        with refused(toliman.InputError, "options->free"):
            toliman.calibrate(nominal, nominal.frames(), free="+diffusion")
        found = toliman.calibrate(nominal, nominal.frames(), free="diffusion jitter_xy")
        self.assertLess(abs(found.values()["diffusion"].value), 4 * found.values()["diffusion"].sigma)


if __name__ == "__main__":
    unittest.main()
